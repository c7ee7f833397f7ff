# SPDX-License-Identifier: Apache-2.0
"""A run guided by masks: a layer for each mask, further paths within it, and all of them trained together."""

from __future__ import annotations

import dataclasses
import time

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from livecl.arrays import FloatArray
from livecl.drawing.assembly import concatenate, stretched
from livecl.drawing.colors import format_rgb
from livecl.drawing.drawing import Drawing
from livecl.image.background import background_for, target_over
from livecl.image.reading import over_background
from livecl.layering.context import Context
from livecl.layering.contributions import paint_at_pixels, visible_shares
from livecl.layering.fills.choice import shaded
from livecl.layering.guides import CLEAR, INSIDE, masked_layers
from livecl.layering.structure.placing import hidden_points
from livecl.rendering.rasterizer import Rasterizer
from livecl.run.beginning import STRUCTURE_COLOR_RATE, STRUCTURE_POINT_RATE, Beginning
from livecl.run.control import Control
from livecl.run.vectorization import vectorize_pixels

#: Paths are added within a mask if at least this many of its pixels differ by at least this much in a channel.
DIFFERENT, LEAST_PIXELS = 12 / 255, 12
#: Width of the plain border around the part of a picture that is vectorized separately, px.
BORDER = 3


@dataclasses.dataclass(frozen=True, eq=False)
class Guided:
    """A picture and its masks."""

    image: NDArray[np.float32]  # (H, W, 3) or (H, W, 4), the picture, straight
    masks: NDArray[np.float32]  # (K, H, W), coverage of each thing
    names: tuple[str, ...]  # (K,), names of the masks
    beginning: Beginning  # of the run; its `paths` are those of each mask, at most, the mask's own shape among them

    def start(self, device: int | str | None, control: Control) -> tuple[Beginning, Control]:
        """Return the beginning of a run that refines the layers of all masks and those within them; and its control.

        `control` limits the runs within masks as well, which have no checkpoint; the one returned has the time left.
        """
        end = None if control.time_limit is None else time.monotonic() + control.time_limit
        options = self.beginning.options
        ground = background_for(options.background, self.image)
        background = None if ground is None else np.array(ground)
        drawing = masked_layers(self.image, self.masks, self.names, background)
        rasterizer = Rasterizer(drawing.size, device)
        context = Context(rasterizer, target_over(self.image, background), options)
        drawing = shaded(context, drawing, np.ones(drawing.num_layers, bool))
        coverages = rasterizer.coverages(drawing)
        shares = visible_shares(coverages)
        parts = [self._drawn(drawing, None, 1 - shares.sum(axis=0), (device, control, end))]
        for layer in range(drawing.num_layers):
            parts.append(drawing.layer_subset([layer]))
            if self.beginning.paths != 1:
                parts.append(self._drawn(drawing, layer, shares[layer], (device, control, end)))
        whole = drawing.layer_subset(np.zeros(0, np.intp))
        for part in parts:
            if part is not None:
                whole = concatenate(whole, part)
        options = dataclasses.replace(
            options,
            learning_rate=min(options.learning_rate, STRUCTURE_POINT_RATE),
            color_learning_rate=min(options.color_learning_rate, STRUCTURE_COLOR_RATE),
        )
        hidden = _hidden(whole, rasterizer)
        beginning = dataclasses.replace(self.beginning, paths=None, options=options, start=whole, hidden=hidden)
        return beginning, dataclasses.replace(control, time_limit=_left(end))

    def _drawn(
        self,
        drawing: Drawing,
        layer: int | None,
        share: NDArray[np.float32],
        surroundings: tuple[int | str | None, Control, float | None],
    ) -> Drawing | None:
        """Return the drawing within the visible part (H, W) of a layer or of the background; None without layers."""
        device, control, end = surroundings
        if end is not None and time.monotonic() >= end:
            return None
        clear, within = ndimage.minimum_filter(share, 3) >= CLEAR, share >= INSIDE
        if not clear.any():
            return None
        base = drawing.background if layer is None else drawing.colors[layer, :3]
        pixels, plain = self.image, np.zeros(4)
        if base is not None:
            pixels, plain = over_background(self.image, base), np.asarray(base)
            if layer is not None:
                pixels = np.clip(pixels + base - paint_at_pixels(drawing, layer)[..., :3], 0, 1)
        nearest = ndimage.distance_transform_edt(~clear, return_distances=False, return_indices=True)
        part = np.where(within[..., None], pixels[tuple(nearest)], plain).astype(np.float32)
        if np.count_nonzero(np.abs(part - plain).max(axis=2) > DIFFERENT) < LEAST_PIXELS:
            return None
        rows, columns = np.flatnonzero(within.any(axis=1)), np.flatnonzero(within.any(axis=0))
        top, left = rows[0] - BORDER, columns[0] - BORDER
        cut = part[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
        framed = np.tile(plain.astype(np.float32), (cut.shape[0] + 2 * BORDER, cut.shape[1] + 2 * BORDER, 1))
        framed[BORDER:-BORDER, BORDER:-BORDER] = cut
        inner = dataclasses.replace(control, checkpoint=None, resume=False, time_limit=_left(end))
        result = vectorize_pixels(framed, self._inner(base, framed), device, None, inner)
        moved = stretched(result.drawing, 1.0, drawing.size, (left, top)).replace(background=drawing.background)
        return moved.replace(groups=[() if layer is None else drawing.groups[layer]] * moved.num_layers)

    def _inner(self, base: FloatArray | None, part: NDArray[np.float32]) -> Beginning:
        """Return the beginning of a run within a mask, with gains scaled to the whole picture."""
        options, paths = self.beginning.options, self.beginning.paths
        more = paths - 1 if isinstance(paths, int) and paths > 1 else paths
        if not isinstance(more, int):
            more, options = None, options.choosing_paths()
        scale = self.image[..., 0].size / part[..., 0].size
        options = dataclasses.replace(
            options,
            background="none" if base is None else format_rgb(base),
            prune=options.prune * scale,
            path_gain=options.path_gain * scale,
            simplify=False,
            primitives=False,
        )
        return Beginning(paths=more, options=options, seed=self.beginning.seed)


def _left(end: float | None) -> float | None:
    """Return the seconds left until a point in time."""
    return None if end is None else max(0.0, end - time.monotonic())


def _hidden(drawing: Drawing, rasterizer: Rasterizer) -> NDArray[np.bool_]:
    """Return the control points (M, 3) of a drawing that no pixel depends on."""
    top = np.zeros(drawing.size, np.int64)
    for layer, coverage in enumerate(rasterizer.coverages(drawing), start=1):
        top[coverage >= INSIDE] = layer
    return hidden_points(drawing, np.arange(drawing.num_layers), top)
