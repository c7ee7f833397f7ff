# SPDX-License-Identifier: Apache-2.0
"""The sequence of kernels: from a drawing to its image, to the distance weight, to the gradient of a loss."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from livecl.drawing.drawing import Drawing
from livecl.opencl.launcher import Launcher
from livecl.rendering.device_drawing import Placed, Scene, Use
from livecl.rendering.fills import fill_gradients
from livecl.rendering.gradients import Gradients
from livecl.rendering.layout import Sizes
from livecl.rendering.stacks import Stack
from livecl.rendering.tiling import Band, Grid, Spans


@dataclasses.dataclass(frozen=True)
class DistanceWeight:
    """The distance weight of eq. (1) as weight of a loss, in place of an image of weights.

    Attributes
    ----------
    tau : float
        Reach of the weight, px.
    pieces : (M,) array_like of int, optional
        Number of lines of each segment for the distances; None chooses it by the tolerance.
    """

    tau: float = 10.0
    pieces: ArrayLike | None = None

    def __post_init__(self) -> None:
        if not 0 < self.tau < np.inf:
            raise ValueError(f"tau: got {self.tau}, wanted a positive number of pixels")


class Pipeline:
    """Launches kernels, band after band, for drawings whose images have one number of channels.

    Parameters as of :class:`livecl.rendering.device_drawing.Scene`.
    """

    def __init__(self, launcher: Launcher, grid: Grid, tolerance: float, max_tiles: int) -> None:
        self.launcher = launcher
        self.grid = grid
        self._scene = Scene(launcher, grid, tolerance, max_tiles)
        self._sizes = Sizes(grid, launcher.dtype.itemsize, num_layers=0, num_segments=0, record=0)
        self._room: tuple[Any, ...] = ()  # layouts for which buffers are allocated

    def load(self, drawing: Drawing, stack: Stack | None = None) -> None:
        """Load the drawing (of a stack, if the grid has many canvases) for the other methods."""
        if drawing is not self._scene.drawing and self._scene.load(drawing, stack):
            self._sizes = Sizes.of(drawing, self.grid, self.launcher.dtype.itemsize)

    def render(self, channels: int, pieces: ArrayLike | None) -> Any:
        """Render; return the buffer of the image's planes."""
        use = Use("coverage", pieces, 0)
        (placed,) = self._scene.place(use)
        self._reserve("image", channels, coverage=placed)
        self._scene.flatten(use)
        for band in placed.spans.each_band:
            self._cover(band)
            self.launcher("composite_forward", band.num_tiles, "coverage")
        return self.launcher.buffer("image")

    def cover(self, pieces: ArrayLike | None) -> Any:
        """Compute coverage; return the buffer of each layer's plane."""
        use, num_layers = Use("coverage", pieces, 0), self._drawing.num_layers
        (placed,) = self._scene.place(use)
        self._reserve("planes", num_layers, coverage=placed)
        self._scene.flatten(use)
        for band in placed.spans.each_band:
            self._cover(band)
            self.launcher("coverage_planes", num_layers * band.num_tiles // self.grid.num_tiles, "coverage")
        return self.launcher.buffer("planes")

    def weigh(self, weight: DistanceWeight, closest_from: int | None = None) -> Any:
        """Return the buffer of the plane of the distance weight, or of the largest closeness (see `Rasterizer`)."""
        use, run = Use("distance", weight.pieces, weight.tau), self.launcher
        (placed,) = self._scene.place(use)
        self._reserve("distance_weight", 1, distance=placed)
        self._scene.flatten(use)
        self._weigh(weight, placed.spans, closest_from)
        return run.buffer("distance_weight")

    def begin_backward(self, pieces: ArrayLike | None) -> Callable[[], tuple[float, Gradients]]:
        """Launch the backward kernels for a loss of the given ``d_image``; see :meth:`begin_loss`."""
        return self._begin_plain("composite_backward", pieces)

    def begin_loss(
        self, weight: DistanceWeight | None, pieces: ArrayLike | None, scale: float
    ) -> Callable[[], tuple[float, Gradients]]:
        """Launch the kernels of the weighted squared error and its gradient, by ``target`` and a weight.

        Parameters
        ----------
        weight : DistanceWeight or None
            None uses the plane ``weight``.
        pieces : (M,) array_like of int, or None
            Number of lines of each segment for coverage.
        scale : float
            Factor of all weights.

        Returns
        -------
        callable
            Waits and returns loss and gradients.
        """
        run = self.launcher
        run.set(scale=scale)
        if weight is None:
            return self._begin_plain("composite_loss", pieces)
        uses = Use("distance", weight.pieces, weight.tau), Use("coverage", pieces, 0)
        distances, placed = self._scene.place(*uses)
        joint = len(distances.spans.bands) == len(placed.spans.bands) == 1  # otherwise closeness is not all in memory
        self._reserve("" if joint else "distance_weight", 1, coverage=placed, distance=distances, backward=True)
        self._scene.flatten(*uses)
        if not joint:
            self._weigh(weight, distances.spans, None)
            run.set(weight=run.buffer("distance_weight"))
            return self._begin("composite_loss", placed)
        (band,) = placed.spans.each_band
        run.set(grid=band.grid, tau=float(weight.tau), factor_scale=scale)
        run("span_both", len(distances.spans.spans) + len(placed.spans.spans))
        run("distance_normalize", 1, "distance")
        return self._begin("composite_distance_loss", placed, covered=True)

    @property
    def _drawing(self) -> Drawing:
        """The drawing on the device."""
        assert self._scene.drawing is not None
        return self._scene.drawing

    def _reserve(
        self,
        image: str,
        channels: int,
        coverage: Placed | None = None,
        distance: Placed | None = None,
        backward: bool = False,
    ) -> None:
        """Allocate buffers: of an image, by name or "", of coverage, of distances, and of a gradient."""
        room = image, channels, coverage, distance, backward, self._sizes
        if len(self._room) == len(room) and all(one is other for one, other in zip(self._room, room, strict=True)):
            return
        needed = {image: self._sizes.planes(channels)} if image else {}
        if coverage is not None:
            needed["coverage_lines"] = self._sizes.lines(coverage.num_lines)
            needed["cells"] = self._sizes.cells(coverage.spans)
            needed |= self._sizes.backward(coverage.spans, coverage.num_lines) if backward else {}
        if distance is not None:
            needed["distance_lines"] = self._sizes.lines(distance.num_lines)
            needed["distances"] = self._sizes.distances(distance.spans)
        self.launcher.reserve(needed)
        self._room = room

    def _cover(self, band: Band) -> None:
        self.launcher.set(grid=band.grid)
        self.launcher("coverage_forward", band.num_spans, "coverage")

    def _weigh(self, weight: DistanceWeight, spans: Spans, closest_from: int | None) -> None:
        """Compute the plane ``distance_weight``: sums over all bands first, then each band is measured again."""
        run = self.launcher
        run.set(first_layer=closest_from or 0, released=closest_from is not None)
        run.set(tau=float(weight.tau), factor_scale=1.0)
        for band in spans.each_band:
            self._measure(band)
        run("distance_normalize", 1, "distance")
        for band in spans.each_band:
            if len(spans.bands) > 1:
                self._measure(band)
            run.set(grid=band.grid)
            run("distance_weight", band.num_tiles, "distance")

    def _measure(self, band: Band) -> None:
        self.launcher.set(grid=band.grid)
        self.launcher("distance_forward", band.num_spans, "distance")

    def _begin_plain(self, composite: str, pieces: ArrayLike | None) -> Callable[[], tuple[float, Gradients]]:
        """Launch the kernels of a gradient without distances."""
        use = Use("coverage", pieces, 0)
        (placed,) = self._scene.place(use)
        self._reserve("", 0, coverage=placed, backward=True)
        self._scene.flatten(use)
        return self._begin(composite, placed)

    def _begin(self, composite: str, placed: Placed, covered: bool = False) -> Callable[[], tuple[float, Gradients]]:
        """Launch coverage, compositing and backward for each band; return a callable that fetches the result."""
        run, drawing, sizes = self.launcher, self._drawing, self._sizes
        for band in placed.spans.each_band:
            run.set(grid=band.grid)
            if not covered:
                self._cover(band)
            run(composite, band.num_tiles, "coverage")
            run("coverage_backward", placed.num_lines, "coverage")
            run("reduce_tiles", drawing.num_layers + self.grid.count, "coverage")
            if sizes.record:
                run("reduce_fills", drawing.num_layers, "coverage")
        run("flatten_backward", drawing.num_segments, "coverage")

        def finish() -> tuple[float, Gradients]:
            result = run.read("result", sizes.num_results).astype(np.float64)
            d_colors, d_cubics, heads, records = sizes.split_result(result)
            d_points = d_cubics[:, :3].copy()
            d_points[drawing.next_segments, 0] += d_cubics[:, 3]
            d_fills = fill_gradients(drawing.fills, records) if sizes.record else None
            d_backgrounds = heads[:, 1:] if self.grid.count > 1 else heads[0, 1:]
            d_background = None if drawing.background is None else d_backgrounds
            return float(heads[0, 0]), Gradients(d_points, d_colors, d_background, d_fills)

        return finish
