# SPDX-License-Identifier: Apache-2.0
"""livecl: turns a picture into a layered, human-editable SVG of few closed Bézier paths.

An implementation of LIVE ("Towards Layer-wise Image Vectorization", CVPR 2022) on OpenCL. Names are loaded when first
used, so that ``import livecl`` is quick and SVG work needs no OpenCL device.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from livecl.batch import vectorize_files
    from livecl.control import Control
    from livecl.device import list_devices
    from livecl.drawing import Drawing
    from livecl.errors import (
        CheckpointError,
        DeviceError,
        DeviceMemoryError,
        ImageError,
        KernelBuildError,
        LiveclError,
        SvgError,
    )
    from livecl.image import read_image
    from livecl.interpolation import interpolate
    from livecl.options import Options
    from livecl.rasterizer import Gradients, Rasterizer, render
    from livecl.recipe import Recipe
    from livecl.result import Result, RunError
    from livecl.sequences import SequenceResult, vectorize_sequence
    from livecl.state import State
    from livecl.svg import read_svg
    from livecl.vectorization import vectorize

__version__ = "0.1.0"

__all__ = [
    "CheckpointError",
    "Control",
    "DeviceError",
    "DeviceMemoryError",
    "Drawing",
    "Gradients",
    "ImageError",
    "KernelBuildError",
    "LiveclError",
    "Options",
    "Rasterizer",
    "Recipe",
    "Result",
    "RunError",
    "SequenceResult",
    "State",
    "SvgError",
    "interpolate",
    "list_devices",
    "read_image",
    "read_svg",
    "render",
    "vectorize",
    "vectorize_files",
    "vectorize_sequence",
]

_MODULES = {
    "batch": ["vectorize_files"],
    "control": ["Control"],
    "device": ["list_devices"],
    "drawing": ["Drawing"],
    "errors": [
        "CheckpointError",
        "DeviceError",
        "DeviceMemoryError",
        "ImageError",
        "KernelBuildError",
        "LiveclError",
        "SvgError",
    ],
    "image": ["read_image"],
    "interpolation": ["interpolate"],
    "options": ["Options"],
    "rasterizer": ["Gradients", "Rasterizer", "render"],
    "recipe": ["Recipe"],
    "sequences": ["SequenceResult", "vectorize_sequence"],
    "state": ["State"],
    "svg": ["read_svg"],
    "result": ["Result", "RunError"],
    "vectorization": ["vectorize"],
}
_MODULE_OF = {name: module for module, names in _MODULES.items() for name in names}


def __getattr__(name: str) -> Any:
    if name in _MODULE_OF:
        return getattr(importlib.import_module(f"livecl.{_MODULE_OF[name]}"), name)
    raise AttributeError(f"module 'livecl' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
