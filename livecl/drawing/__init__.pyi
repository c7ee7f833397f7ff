# SPDX-License-Identifier: Apache-2.0
from .assembly import concatenate as concatenate
from .assembly import empty_drawing as empty_drawing
from .drawing import Drawing as Drawing
from .fills import KINDS as KINDS
from .fills import LINEAR as LINEAR
from .fills import RADIAL as RADIAL
from .fills import SOLID as SOLID
from .fills import Fills as Fills
from .strokes import Strokes as Strokes

__all__ = [
    "KINDS",
    "LINEAR",
    "RADIAL",
    "SOLID",
    "Drawing",
    "Fills",
    "Strokes",
    "concatenate",
    "empty_drawing",
]
