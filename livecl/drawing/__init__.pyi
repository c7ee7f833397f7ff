# SPDX-License-Identifier: Apache-2.0
from .drawing import Drawing as Drawing
from .drawing import concatenate as concatenate
from .drawing import empty_drawing as empty_drawing
from .fills import KINDS as KINDS
from .fills import LINEAR as LINEAR
from .fills import RADIAL as RADIAL
from .fills import SOLID as SOLID
from .fills import Fills as Fills

__all__ = [
    "KINDS",
    "LINEAR",
    "RADIAL",
    "SOLID",
    "Drawing",
    "Fills",
    "concatenate",
    "empty_drawing",
]
