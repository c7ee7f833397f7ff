# SPDX-License-Identifier: Apache-2.0
from .rasterizer import DeviceImage as DeviceImage
from .rasterizer import DistanceWeight as DistanceWeight
from .rasterizer import Gradients as Gradients
from .rasterizer import Rasterizer as Rasterizer
from .single import render as render

__all__ = [
    "DeviceImage",
    "DistanceWeight",
    "Gradients",
    "Rasterizer",
    "render",
]
