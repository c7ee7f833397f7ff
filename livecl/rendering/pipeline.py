# SPDX-License-Identifier: Apache-2.0
"""The kernels in their order: from a drawing to its image, to the distance weight, to the gradient of a loss."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from livecl.drawing.drawing import Drawing
from livecl.opencl.launcher import Launcher
from livecl.rendering.device_drawing import Scene, Use
from livecl.rendering.fills import fill_gradients, record_reals
from livecl.rendering.gradients import Gradients
from livecl.rendering.tiling import TILE, Grid, IntArray, Spans


@dataclasses.dataclass(frozen=True)
class DistanceWeight:
    """The distance weight of eq. (1) of the drawing whose loss is asked for, in place of an image of weights.

    Attributes
    ----------
    tau : float
        Reach of the weight, px.
    pieces : (M,) array_like of int, optional
        Lines that each segment is flattened into for the distances; None chooses them by the tolerance.
    """

    tau: float = 10.0
    pieces: ArrayLike | None = None

    def __post_init__(self) -> None:
        if not 0 < self.tau < np.inf:
            raise ValueError(f"tau: got {self.tau}, wanted a positive number of pixels")


class Pipeline:
    """Launches kernels, band after band, for drawings whose images have one number of channels.

    Parameters
    ----------
    launcher, grid, tolerance, max_tiles
        As for :class:`livecl.rendering.device_drawing.Scene`.
    """

    def __init__(self, launcher: Launcher, grid: Grid, tolerance: float, max_tiles: int) -> None:
        self.launcher = launcher
        self._grid = grid
        self._scene = Scene(launcher, grid, tolerance, max_tiles)

    def load(self, drawing: Drawing) -> None:
        """Put the drawing on the device that all other methods work on."""
        self._scene.load(drawing)

    def render(self, channels: int, pieces: ArrayLike | None) -> Any:
        """Return the buffer of the image's planes."""
        (spans,) = self._scene.flatten(Use("coverage", pieces, 0))
        image = self.launcher.reserve_reals("image", channels * self._plane)
        for band in spans.each_band:
            self._cover(spans, band)
            self.launcher("composite_forward", self._band_tiles(band), "coverage")
        return image

    def cover(self, pieces: ArrayLike | None) -> Any:
        """Return the buffer of a plane for each layer, its coverage."""
        (spans,) = self._scene.flatten(Use("coverage", pieces, 0))
        drawing = self._scene.drawing
        assert drawing is not None
        planes = self.launcher.reserve_reals("planes", drawing.num_layers * self._plane)
        for band in spans.each_band:
            self._cover(spans, band)
            self.launcher("coverage_planes", drawing.num_layers * int(band[3] - band[2]), "coverage")
        return planes

    def weigh(self, weight: DistanceWeight, closest_from: int | None = None) -> Any:
        """Return the buffer of a plane that holds the distance weight, or the largest closeness (`Rasterizer`)."""
        run = self.launcher
        (spans,) = self._scene.flatten(Use("distance", weight.pieces, weight.tau))
        self._reserve_distances(weight, spans)
        plane = run.reserve_reals("distance_weight", self._plane)
        run.set(first_layer=closest_from or 0, released=closest_from is not None)
        self._measure(spans.each_band)
        for band in spans.each_band:
            if len(spans.bands) > 1:
                self._measure([band], normalize=False)
            run.set(band=band)
            run("distance_weight", self._band_tiles(band), "distance")
        return plane

    def begin_backward(self, pieces: ArrayLike | None) -> Callable[[], tuple[float, Gradients]]:
        """Launch the backward kernels for a loss of the given ``d_image``; see :meth:`begin_loss`."""
        (spans,) = self._scene.flatten(Use("coverage", pieces, 0))
        return self._begin("composite_backward", spans)

    def begin_loss(
        self, weight: DistanceWeight | None, pieces: ArrayLike | None
    ) -> Callable[[], tuple[float, Gradients]]:
        """Launch the kernels of the weighted squared error and its gradient, by ``target``, ``scale`` and a weight.

        Parameters
        ----------
        weight : DistanceWeight or None
            None takes the plane ``weight``.
        pieces : (M,) array_like of int, or None
            Lines of each segment for coverage.

        Returns
        -------
        callable
            Waits and returns loss and gradients.
        """
        use = Use("coverage", pieces, 0)
        if weight is None:
            (spans,) = self._scene.flatten(use)
            return self._begin("composite_loss", spans)
        distances, spans = self._scene.flatten(Use("distance", weight.pieces, weight.tau), use)
        if len(distances.bands) > 1 or len(spans.bands) > 1:  # closeness is not there for all strips at a time
            self.launcher.set(weight=self.weigh(weight))
            return self._begin("composite_loss", spans)
        self._reserve_distances(weight, distances)
        self._reserve_coverage(spans)
        num_distance_spans, num_coverage_spans = len(distances.spans), len(spans.spans)
        self.launcher.set(num_distance_spans=num_distance_spans, num_coverage_spans=num_coverage_spans)
        self.launcher("span_both", num_distance_spans + num_coverage_spans)
        self.launcher("distance_normalize", 1, "distance")
        return self._begin("composite_distance_loss", spans, covered=True)

    @property
    def _tile(self) -> int:
        """Pixels of a tile."""
        return TILE * self._grid.lanes

    @property
    def _plane(self) -> int:
        """Pixels of a plane."""
        return self._grid.num_strips * self._grid.num_tiles * self._tile

    def _band_tiles(self, band: IntArray) -> int:
        return int(band[3] - band[2]) * self._grid.num_tiles

    def _reserve_coverage(self, spans: Spans) -> None:
        run = self.launcher
        run.reserve("tile_state", spans.num_tiles * 4)
        run.reserve_reals("area", spans.num_tiles * self._tile)
        run.reserve_reals("d_coverage", spans.num_tiles * self._tile)

    def _reserve_distances(self, weight: DistanceWeight, spans: Spans) -> None:
        run, drawing = self.launcher, self._scene.drawing
        assert drawing is not None
        run.reserve_reals("closeness", spans.num_tiles * self._tile)
        run.reserve("near", spans.num_tiles * 4)
        run.reserve_reals("span_sums", len(spans.spans))
        run.reserve_reals("factors", drawing.num_layers)
        run.set(tau=float(weight.tau))

    def _cover(self, spans: Spans, band: IntArray) -> None:
        self._reserve_coverage(spans)
        self.launcher.set(band=band)
        self.launcher("coverage_forward", int(band[1] - band[0]), "coverage")

    def _measure(self, bands: Iterable[IntArray], normalize: bool = True) -> None:
        for band in bands:
            self.launcher.set(band=band)
            self.launcher("distance_forward", int(band[1] - band[0]), "distance")
        if normalize:
            self.launcher("distance_normalize", 1, "distance")

    def _begin(self, composite: str, spans: Spans, covered: bool = False) -> Callable[[], tuple[float, Gradients]]:
        """Cover, composite with a gradient and gather it, band after band; the returned callable fetches the result."""
        run, drawing = self.launcher, self._scene.drawing
        assert drawing is not None
        num_layers, num_segments = drawing.num_layers, drawing.num_segments
        num_lines = self._scene.num_lines("coverage")
        run.reserve_reals("d_colors", 4 * spans.num_tiles)
        run.reserve_reals("d_tiles", 4 * self._grid.num_strips * self._grid.num_tiles)
        run.reserve_reals("d_lines", 4 * num_lines)
        num_reals = record_reals(drawing.fills) if drawing.fills.any_gradients else 0
        run.reserve_reals("d_fills", num_reals * spans.num_tiles)
        run.reserve_reals("fill_sums", num_reals * num_layers)
        run.reserve_reals("result", 4 + 4 * num_layers + 8 * num_segments)
        run.set(num_lines=num_lines)
        for band in spans.each_band:
            run.set(band=band)
            if not covered:
                self._cover(spans, band)
            run(composite, self._band_tiles(band), "coverage")
            run("coverage_backward", num_lines, "coverage")
            run("reduce_tiles", num_layers + 1, "coverage")
            if num_reals:
                run("reduce_fills", num_layers, "coverage")
        run("flatten_backward", num_segments, "coverage")

        def finish() -> tuple[float, Gradients]:
            result = run.read("result", 4 + 4 * num_layers + 8 * num_segments).astype(np.float64)
            d_cubics = result[4 + 4 * num_layers :].reshape(-1, 4, 2)
            d_points = d_cubics[:, :3].copy()
            d_points[drawing.next_segments, 0] += d_cubics[:, 3]
            d_colors = result[4 : 4 + 4 * num_layers].reshape(-1, 4)
            d_fills = None
            if num_reals:
                sums = run.read("fill_sums", (num_layers, num_reals)).astype(np.float64)
                d_fills = fill_gradients(drawing.fills, sums)
            d_background = None if drawing.background is None else result[1:4]
            return float(result[0]), Gradients(d_points, d_colors, d_background, d_fills)

        return finish
