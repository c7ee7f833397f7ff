# SPDX-License-Identifier: Apache-2.0
"""Copy images to the device and back."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pyopencl as cl
from numpy.typing import NDArray

from livecl.opencl.device import OpenDevice
from livecl.rendering.tiling import Grid


@dataclasses.dataclass(frozen=True)
class DeviceImage:
    """An image on the device, in the planes that kernels read."""

    buffer: Any
    channels: int


def upload(opened: OpenDevice, grid: Grid, image: NDArray[Any]) -> DeviceImage:
    """Copy an image (H, W) or (H, W, C), or one for each canvas (count, H, W, C), to the device."""
    planes = grid.pack(image, image.dtype)
    buffer = opened.buffer("image", planes.nbytes)
    cl.enqueue_copy(opened.queue, buffer, planes)
    return DeviceImage(buffer, len(planes))


def download(opened: OpenDevice, grid: Grid, image: DeviceImage, dtype: np.dtype[Any]) -> NDArray[Any]:
    """Copy an image from the device: (H, W, C), or (count, H, W, C) for many canvases."""
    planes = np.empty((image.channels, grid.num_strips, grid.num_columns, grid.lanes), dtype)
    cl.enqueue_copy(opened.queue, planes, image.buffer)
    return grid.unpack(planes)
