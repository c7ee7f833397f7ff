# SPDX-License-Identifier: Apache-2.0
"""The differentiable rasterizer: a drawing to an image, and a loss's gradient back to the drawing, on an OpenCL device."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pyopencl as cl
from numpy.typing import ArrayLike, DTypeLike, NDArray

from livecl.bezier import pieces_for
from livecl.device import open_device
from livecl.drawing import Drawing
from livecl.launcher import Launcher
from livecl.tiling import LANES, Grid, IntArray, Spans, layer_bounds, plan_spans

#: Distance px between curve and polyline that flattening keeps below, unless told otherwise.
TOLERANCE = 0.02
#: Pixels that boxes reach beyond the outline, so that rounding and edges exactly on a tile's border stay inside.
MARGIN = 0.125
#: Pixels that boxes are larger than needed when they are laid out anew, so that small steps keep the layout.
SLACK = 3.0
#: Tiles worked on at a time: 512 bytes each, so 64 MiB; layers that need more are worked on in bands of strips.
MAX_TILES = 1 << 17


@dataclasses.dataclass(frozen=True)
class Gradients:
    """Gradient of a scalar loss with respect to a drawing.

    Attributes
    ----------
    points : (M, 3, 2) float64
        Loss per pixel of displacement.
    colors : (N, 4) float64
        Loss per unit of straight RGBA.
    background : (3,) float64 or None
        Loss per unit of colour; None where the drawing has no background.
    """

    points: NDArray[np.float64]
    colors: NDArray[np.float64]
    background: NDArray[np.float64] | None


@dataclasses.dataclass(frozen=True)
class DeviceImage:
    """An image that stays on the device, in planes as the kernels read them."""

    buffer: Any
    channels: int


@dataclasses.dataclass(frozen=True)
class _Loaded:
    """The drawing that is on the device."""

    drawing: Drawing
    pieces: NDArray[Any] | None
    next_segments: IntArray
    num_lines: int

    def fits(self, drawing: Drawing) -> bool:
        """Whether `drawing` differs from this one in numbers only."""
        return self.drawing.same_structure(drawing) and (drawing.background is None) == (self.drawing.background is None)


class Rasterizer:
    """Renders drawings on one canvas size and differentiates losses of the result.

    Coverage is exact area coverage under the nonzero rule (kernels/coverage.cl states where), layers are composited
    `over` in paint order. Everything an object does is in a fixed order: the same input gives the same bytes.

    Parameters
    ----------
    size : (int, int)
        Height and width of the canvas, px.
    device : int, str or None
        Which OpenCL device, see :func:`livecl.device.choose_device`.
    dtype : float32 or float64
        Number type of the kernels; float64 is for checking gradients.
    tolerance : float
        Largest distance between a curve and the lines that it is flattened into, px.
    max_tiles : int
        Tiles (of 8 columns by 32 bytes) that are worked on at a time; bounds the memory.

    Raises
    ------
    DeviceError, KernelBuildError
        If the device cannot be had, or does not compile the kernels.
    """

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
        self.device = open_device(device)
        self._grid = Grid(*self.size, LANES[self.dtype.name])
        self._launchers: dict[int, Launcher] = {}
        self._loaded: _Loaded | None = None
        self._boxes: dict[str, IntArray] = {}
        self._spans: dict[str, Spans] = {}
        self._launcher(3)

    def forward(self, drawing: Drawing, pieces: ArrayLike | None = None) -> NDArray[Any]:
        """Render a drawing.

        Parameters
        ----------
        drawing : Drawing
            On a canvas of the rasterizer's size.
        pieces : (M,) array_like of int, optional
            Lines that each segment is flattened into, at equal steps of its parameter. None chooses them by the
            tolerance; who differentiates passes them and holds them fixed, as no gradient sees a change.

        Returns
        -------
        (H, W, 3) array
            RGB; or (H, W, 4), premultiplied RGBA, where the drawing has no background.
        """
        run = self._load(drawing, pieces)
        channels = self._channels(drawing)
        planes = self._plane_bytes * channels
        image = run.reserve("image", planes)
        spans = self._place("coverage", MARGIN)
        for band in spans.bands:
            self._cover(run, band)
            run("composite_forward", self._band_tiles(band), band, *self._canvas, "params", *self._covered, image)
        return self.download(DeviceImage(image, channels))

    def backward(self, d_image: ArrayLike) -> Gradients:
        """Gradient of a scalar loss with respect to the drawing last rendered.

        Parameters
        ----------
        d_image : (H, W, 3) or (H, W, 4) array_like
            dL/dimage, loss per unit of colour; of the shape that :meth:`forward` returned.

        Returns
        -------
        Gradients
            ``points`` (M, 3, 2), loss per pixel of displacement; ``colors`` (N, 4); ``background`` (3,).

        Raises
        ------
        ValueError
            If `d_image` is not of the rendered image's shape.
        RuntimeError
            If nothing has been rendered.

        Notes
        -----
        Derivations: kernels/composite.h (colour), kernels/coverage.cl (outline), kernels/flatten.cl (control points).
        """
        if self._loaded is None:
            raise RuntimeError("backward needs a drawing: call forward first")
        drawing = self._loaded.drawing
        run = self._launcher(self._channels(drawing))
        given = self._uploaded("d_image", d_image, run.channels)
        spans = self._place("coverage", MARGIN)
        for band in spans.bands:
            self._cover(run, band)
            run(
                "composite_backward",
                self._band_tiles(band),
                *(band, *self._canvas, "params", *self._covered),
                *(given.buffer, "d_coverage", "d_colors", "d_tiles"),
            )
            self._collect(run, band)
        return self._gradients(run)[1]

    def loss_and_gradients(
        self,
        drawing: Drawing,
        target: ArrayLike | DeviceImage,
        weight: ArrayLike | DeviceImage,
        pieces: ArrayLike | None = None,
        scale: float = 1.0,
    ) -> tuple[float, Gradients]:
        """Weighted squared error of a drawing, and its gradient, in one go.

        The loss is the sum over pixels of ``scale * weight`` times the sum over channels of (image - target)^2.

        Parameters
        ----------
        drawing, pieces
            As for :meth:`forward`.
        target : (H, W, 3) or (H, W, 4) array_like, or DeviceImage
            What the image should be; premultiplied RGBA where the drawing has no background.
        weight : (H, W) array_like, or DeviceImage
            Weight of each pixel, a constant in the gradient.
        scale : float
            Factor of all weights.

        Returns
        -------
        (float, Gradients)
        """
        run = self._load(drawing, pieces)
        wanted = self._uploaded("target", target, run.channels)
        weights = self._uploaded("weight", weight, 1)
        spans = self._place("coverage", MARGIN)
        for band in spans.bands:
            self._cover(run, band)
            run(
                "composite_loss",
                self._band_tiles(band),
                *(band, *self._canvas, "params", *self._covered),
                *(wanted.buffer, weights.buffer, self.dtype.type(scale), "d_coverage", "d_colors", "d_tiles"),
            )
            self._collect(run, band)
        return self._gradients(run)

    def distance_weight(
        self, drawing: Drawing, tau: float = 10.0, pieces: ArrayLike | None = None
    ) -> NDArray[Any]:
        """Return the distance weight of eq. (1), averaged over the layers whose outline is within `tau` of some pixel.

        Returns
        -------
        (H, W) array
            d', 1/px^2 in effect: it sums to 1, or is 0 all over where no outline is near.
        """
        return self.download(self.distance_weight_on_device(drawing, tau, pieces))[..., 0]

    def distance_weight_on_device(
        self, drawing: Drawing, tau: float, pieces: ArrayLike | None = None, closest_from: int | None = None
    ) -> DeviceImage:
        """Like :meth:`distance_weight`, for use as a weight; the next call overwrites it.

        With `closest_from`, the image is instead the largest ReLU(tau - d), px, among the layers from that one on: the
        weight of the authors' program is made from it.
        """
        run = self._load(drawing, pieces)
        weight = run.reserve("distance_weight", self._plane_bytes)
        spans = self._place("distance", tau + MARGIN)
        run.reserve("closeness", spans.num_tiles * self._tile_bytes)
        run.reserve("near", spans.num_tiles * 4)
        run.reserve("span_sums", len(spans.spans) * self.dtype.itemsize)
        run.reserve("factors", drawing.num_layers * self.dtype.itemsize)
        several = len(spans.bands) > 1
        for band in spans.bands:
            self._measure(run, band, tau)
        run(
            *("distance_normalize", 1, np.int32(drawing.num_layers)),
            *("distance.layer_strips", "distance.layer_spans", "span_sums", "factors"),
        )
        for band in spans.bands:
            if several:
                self._measure(run, band, tau)
            run(
                *("distance_weight", self._band_tiles(band), band, np.int32(self._grid.num_tiles)),
                *(np.int32(closest_from or 0), np.int32(closest_from is not None)),
                *("distance.spans", "distance.strip_offsets", "near", "closeness", "factors", weight),
            )
        return DeviceImage(weight, 1)

    def pieces(self, drawing: Drawing) -> NDArray[np.int32]:
        """Return the number of lines that flatten each segment to within the rasterizer's tolerance: (M,)."""
        return pieces_for(drawing.cubics, self.tolerance)

    def upload(self, image: ArrayLike) -> DeviceImage:
        """Put an image (H, W), (H, W, 3) or (H, W, 4) on the device, to be used as a target or a weight many times."""
        array = np.asarray(image, dtype=self.dtype)
        if array.shape[:2] != self.size or array.ndim not in (2, 3):
            raise ValueError(f"image: shape {array.shape}, wanted {self.size} pixels, with or without channels")
        planes = self._grid.pack(array, self.dtype)
        buffer = cl.Buffer(self.device.context, cl.mem_flags.READ_WRITE, planes.nbytes)
        cl.enqueue_copy(self.device.queue, buffer, planes)
        return DeviceImage(buffer, len(planes))

    def download(self, image: DeviceImage) -> NDArray[Any]:
        """Return an image that is on the device: (H, W, channels)."""
        grid = self._grid
        planes = np.empty((image.channels, grid.num_strips, grid.num_columns, grid.lanes), self.dtype)
        cl.enqueue_copy(self.device.queue, planes, image.buffer)
        return grid.unpack(planes)

    @property
    def _tile_bytes(self) -> int:
        return 8 * self._grid.lanes * self.dtype.itemsize

    @property
    def _plane_bytes(self) -> int:
        return self._grid.num_strips * self._grid.num_tiles * self._tile_bytes

    @property
    def _canvas(self) -> tuple[np.int32, np.int32]:
        return np.int32(self._grid.num_strips), np.int32(self._grid.num_tiles)

    _covered = ("coverage.spans", "coverage.strip_offsets", "winding", "area")

    def _band_tiles(self, band: IntArray) -> int:
        return int(band[3] - band[2]) * self._grid.num_tiles

    @staticmethod
    def _channels(drawing: Drawing) -> int:
        return 4 if drawing.background is None else 3

    def _launcher(self, channels: int) -> Launcher:
        if channels not in self._launchers:
            self._launchers[channels] = Launcher(self.device, self.dtype, channels)
        return self._launchers[channels]

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

    def _load(self, drawing: Drawing, pieces: ArrayLike | None) -> Launcher:
        """Put a drawing on the device and flatten it; what has not changed since the last time stays."""
        if drawing.size != self.size:
            raise ValueError(f"drawing: size {drawing.size}, wanted the rasterizer's {self.size}")
        run = self._launcher(self._channels(drawing))
        loaded = self._loaded
        if loaded is not None and loaded.drawing is drawing and loaded.pieces is pieces:
            return run
        if loaded is not None and pieces is not None and loaded.pieces is pieces and loaded.fits(drawing):
            self._loaded = dataclasses.replace(loaded, drawing=drawing)
        else:
            self._loaded = self._load_structure(run, drawing, pieces)
        background = np.zeros(3) if drawing.background is None else drawing.background
        values = [background, np.zeros(1), drawing.colors.ravel(), drawing.points.ravel()]
        run.write("params", np.concatenate(values).astype(self.dtype))
        run(
            *("flatten_forward", drawing.num_segments, np.int32(drawing.num_segments), np.int32(drawing.num_layers)),
            *("params", "next_segments", "line_offsets", "lines", "segment_bounds"),
        )
        return run

    def _load_structure(self, run: Launcher, drawing: Drawing, pieces: ArrayLike | None) -> _Loaded:
        counts = self.pieces(drawing) if pieces is None else np.asarray(pieces)
        if counts.shape != (drawing.num_segments,) or not np.issubdtype(counts.dtype, np.integer) or np.any(counts < 1):
            raise ValueError(f"pieces: wanted {drawing.num_segments} whole numbers of at least 1, one for each segment")
        next_segments = drawing.next_segments
        line_offsets = np.concatenate([[0], np.cumsum(counts)]).astype(np.int32)
        num_lines = int(line_offsets[-1])
        run.write("next_segments", next_segments)
        run.write("line_offsets", line_offsets)
        run.write("layer_segments", drawing.segment_offsets)
        run.write("line_layers", np.repeat(drawing.segment_layers, counts))
        for name in ("lines", "d_lines"):
            run.reserve(name, num_lines * 4 * self.dtype.itemsize)
        run.reserve("segment_bounds", drawing.num_segments * 4 * self.dtype.itemsize)
        run.reserve("result", (4 + 4 * drawing.num_layers + 8 * drawing.num_segments) * self.dtype.itemsize)
        for kind in ("coverage", "distance"):
            self._boxes.pop(kind, None)
        return _Loaded(drawing, pieces, next_segments, num_lines)  # type: ignore[arg-type]  # kept for its identity

    def _place(self, kind: str, margin: float) -> Spans:
        """Lay out the spans of the loaded drawing, unless each layer is still inside the boxes laid out last."""
        assert self._loaded is not None
        drawing = self._loaded.drawing
        bounds = layer_bounds(drawing)
        run = self._launcher(self._channels(drawing))
        tight, boxes = self._grid.boxes(bounds, margin), self._boxes.get(kind)
        if boxes is not None and np.all(tight[:, :2] >= boxes[:, :2]) and np.all(tight[:, 2:] <= boxes[:, 2:]):
            return self._spans[kind]
        boxes = self._grid.boxes(bounds, margin + SLACK)
        spans = plan_spans(boxes, self._grid.num_strips, self.max_tiles)
        self._boxes[kind], self._spans[kind] = boxes, spans
        for name in ("spans", "strip_offsets", "layer_strips", "layer_spans"):
            run.write(f"{kind}.{name}", getattr(spans, name))
        return spans

    def _cover(self, run: Launcher, band: IntArray) -> None:
        spans = self._spans["coverage"]
        run.reserve("winding", spans.num_tiles * 4)
        run.reserve("area", spans.num_tiles * self._tile_bytes)
        run.reserve("d_coverage", spans.num_tiles * self._tile_bytes)
        run.reserve("d_colors", spans.num_tiles * 4 * self.dtype.itemsize)
        run.reserve("d_tiles", self._canvas[0] * self._canvas[1] * 4 * self.dtype.itemsize)
        run(
            *("coverage_forward", int(band[1] - band[0]), band, np.int32(self._grid.num_columns), "coverage.spans"),
            *("layer_segments", "line_offsets", "segment_bounds", "lines", "winding", "area", "d_coverage"),
        )

    def _measure(self, run: Launcher, band: IntArray, tau: float) -> None:
        run(
            *("distance_forward", int(band[1] - band[0]), band, np.int32(self.size[1]), np.int32(self.size[0])),
            *(self.dtype.type(tau), "distance.spans", "layer_segments", "line_offsets", "segment_bounds", "lines"),
            *("near", "closeness", "span_sums"),
        )

    def _collect(self, run: Launcher, band: IntArray) -> None:
        """Gather the gradients of the lines and the sums over tiles, band after band."""
        assert self._loaded is not None
        num_lines, num_layers = self._loaded.num_lines, self._loaded.drawing.num_layers
        tables = ("coverage.spans", "coverage.layer_strips", "coverage.layer_spans")
        run(
            *("coverage_backward", num_lines, band, np.int32(num_lines), np.int32(self.size[1]), np.int32(self.size[0])),
            *("lines", "line_layers", *tables, "winding", "area", "d_coverage", "d_lines"),
        )
        run(
            *("reduce_tiles", num_layers + 1, band, np.int32(num_layers), np.int32(self._grid.num_tiles)),
            *(*tables, "winding", "d_colors", "d_tiles", "result"),
        )

    def _gradients(self, run: Launcher) -> tuple[float, Gradients]:
        assert self._loaded is not None
        drawing = self._loaded.drawing
        num_layers, num_segments = drawing.num_layers, drawing.num_segments
        run(
            *("flatten_backward", num_segments, np.int32(num_segments), np.int32(num_layers)),
            *("line_offsets", "d_lines", "result"),
        )
        result = run.read("result", 4 + 4 * num_layers + 8 * num_segments).astype(np.float64)
        d_cubics = result[4 + 4 * num_layers :].reshape(-1, 4, 2)
        d_points = d_cubics[:, :3].copy()
        d_points[self._loaded.next_segments, 0] += d_cubics[:, 3]
        d_colors = result[4 : 4 + 4 * num_layers].reshape(-1, 4)
        d_background = None if drawing.background is None else result[1:4]
        return float(result[0]), Gradients(d_points, d_colors, d_background)


def render(drawing: Drawing, device: int | str | None = None) -> NDArray[Any]:
    """Render a drawing once.

    Returns
    -------
    (H, W, 3) float32
        RGB; or (H, W, 4), premultiplied RGBA, where the drawing has no background.
    """
    return Rasterizer(drawing.size, device).forward(drawing)
