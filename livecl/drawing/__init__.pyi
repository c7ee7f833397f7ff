# SPDX-License-Identifier: Apache-2.0
from .drawing import Drawing as Drawing
from .drawing import concatenate as concatenate
from .drawing import empty_drawing as empty_drawing

__all__ = [
    "Drawing",
    "concatenate",
    "empty_drawing",
]
