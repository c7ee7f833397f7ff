# SPDX-License-Identifier: Apache-2.0
from .blending import interpolate as interpolate

__all__ = [
    "interpolate",
]
