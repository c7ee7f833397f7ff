# SPDX-License-Identifier: Apache-2.0
"""`DeviceCanvas`: the canvas of a rasterizer on its device; upload and download of images."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from livecl.drawing.drawing import Drawing
from livecl.opencl.device import OpenDevice, open_device
from livecl.opencl.guard import on_device
from livecl.opencl.program import LANES
from livecl.rendering.images import DeviceImage, download, upload
from livecl.rendering.strokes import stroke_pieces
from livecl.rendering.threads import Workspace
from livecl.rendering.tiling import Grid

#: Default flattening tolerance: largest distance between curve and polyline, px.
TOLERANCE = 0.02
#: Default number of tiles processed at a time: 512 bytes each, so 64 MiB; with more, strips are processed in bands.
MAX_TILES = 1 << 17


class DeviceCanvas:
    """A canvas size on a device; parameters and errors as for :class:`livecl.Rasterizer`."""

    def __init__(
        self,
        size: tuple[int, int],
        device: int | str | None = None,
        dtype: DTypeLike = np.float32,
        tolerance: float = TOLERANCE,
        max_tiles: int = MAX_TILES,
    ) -> None:
        self.dtype = np.dtype(dtype)
        if self.dtype.name not in LANES:
            raise ValueError(f"dtype: got {self.dtype.name}, wanted float32 or float64")
        if not tolerance > 0:
            raise ValueError(f"tolerance: got {tolerance}, wanted a positive number of pixels")
        self.size = Drawing(points=np.zeros((0, 3, 2)), colors=np.zeros((0, 4)), size=size).size
        self.tolerance = tolerance
        self.max_tiles = max_tiles
        self.device: OpenDevice = open_device(device)
        self._grid = Grid(*self.size, LANES[self.dtype.name])
        self._workspace = Workspace(self.device, self._grid, self.dtype, tolerance, max_tiles)
        self._build()

    def forget(self) -> None:
        """Release the buffers of this thread."""
        self._workspace.forget()

    @on_device
    def _build(self) -> None:
        self._workspace.pipeline(3)

    def pieces(self, drawing: Drawing, tolerance: float | None = None) -> NDArray[np.int32]:
        """Return the number of lines of each segment, (M,), for a tolerance, px (default: the rasterizer's)."""
        return stroke_pieces(drawing, self.tolerance if tolerance is None else tolerance)

    @on_device
    def upload(self, image: ArrayLike) -> DeviceImage:
        """Copy an image (H, W), (H, W, 3) or (H, W, 4) to the device, for repeated use as target or weight."""
        array = np.asarray(image, dtype=self.dtype)
        if array.shape[:2] != self.size or array.ndim not in (2, 3):
            raise ValueError(f"image: shape {array.shape}, wanted {self.size} pixels, with or without channels")
        return upload(self.device, self._grid, array)

    @on_device
    def download(self, image: DeviceImage) -> NDArray[Any]:
        """Copy an image from the device: (H, W, channels)."""
        return download(self.device, self._grid, image, self.dtype)

    def _uploaded(self, name: str, image: ArrayLike | DeviceImage, channels: int) -> DeviceImage:
        if not isinstance(image, DeviceImage):
            array = np.asarray(image, dtype=self.dtype)
            wanted = self.size if channels == 1 else (*self.size, channels)
            if array.shape != wanted:
                raise ValueError(f"{name}: shape {array.shape}, wanted {wanted}")
            image = self.upload(array)
        if image.channels != channels:
            raise ValueError(f"{name}: {image.channels} channels, wanted {channels}")
        return image
