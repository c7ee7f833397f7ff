# SPDX-License-Identifier: Apache-2.0
"""`Beginning`: paths, options, seed and start drawing of a run, and its initial progress on a picture."""

from __future__ import annotations

import dataclasses
import importlib
from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from livecl import interruption
from livecl.drawing.assembly import empty_drawing
from livecl.drawing.checks import check_whole
from livecl.drawing.drawing import Drawing
from livecl.image.background import TRAIN, background_for, target_over
from livecl.options import Options
from livecl.run.progress import Progress
from livecl.schedule import MAX_AUTO_PATHS, MAX_DEFAULT_PATHS, growing_schedule, parse_schedule

#: Learning rate of colours for flat pictures: they are measured in the picture, and need little training.
STRUCTURE_COLOR_RATE = 2e-4
#: Largest learning rate of points, px, of outlines known to a tenth of a pixel: larger steps would lose them.
STRUCTURE_POINT_RATE = 0.3
#: Mean squared difference between picture and ground below which layers cost less, in proportion: a picture of pale
#: shapes alone, six levels from the ground or less, is drawn like one of more contrast.
PALE = 5e-4


@dataclasses.dataclass(frozen=True, kw_only=True)
class Beginning:
    """Beginning of a run on any picture.

    Raises ValueError if the seed is not usable.
    """

    #: As for :func:`livecl.vectorize`; `start` of the picture's size.
    paths: int | Literal["auto"] | None = None
    schedule: str | Sequence[int] | None = None
    options: Options = dataclasses.field(default_factory=Options)
    seed: int = 0
    start: Drawing | None = None
    lock: Sequence[int] = ()
    hidden: NDArray[np.bool_] | None = None  # (M, 3), control points of `start` that no pixel depends on: not moved

    def __post_init__(self) -> None:
        if self.paths == "auto":
            object.__setattr__(self, "options", self.options.choosing_paths())
        check_whole("seed", self.seed, 0)

    def progress(self, image: NDArray[np.float32]) -> Progress:
        """Return the progress before the first stage on a picture, (H, W, 3) or (H, W, 4).

        Raises ValueError if the options have variant "released", which starts from nothing, and there is a start
        drawing.
        """
        start, options = self.start, self.options
        if start is None:
            drawing = empty_drawing((image.shape[0], image.shape[1]), background_for(options.background, image))
            options = priced_for(options, image, drawing)
            options = placed_by(options, image, drawing, sum(self._stages(options)))
            return Progress.start(drawing, options, self._stages(options), self.seed)
        if options.variant == "released":
            raise ValueError("start: variant 'released' trains the newest paths only, so it starts from nothing")
        refines = start.num_layers > 0
        stages = self._stages(options) if self.schedule or self.paths or not refines else ()
        drawing = start.replace(background=background_for(options.background, image, start.background))
        locked = np.zeros(start.num_layers, bool)
        locked[np.array(self.lock, dtype=np.intp)] = True
        options = dataclasses.replace(options, placement="region") if options.placement == "structure" else options
        progress = Progress.start(drawing, options, (0, *stages) if refines else stages, self.seed, locked)
        progress.state.hidden = self.hidden
        return progress

    def _stages(self, options: Options) -> tuple[int, ...]:
        """Return the paths of each stage; without a number or list, they depend on the picture."""
        if self.paths is None and self.schedule is None and options.path_gain:
            return growing_schedule(MAX_AUTO_PATHS if options.placement == "structure" else MAX_DEFAULT_PATHS)
        return parse_schedule(self.schedule, self.paths)


def _load_libraries() -> None:
    """Import the parts of SciPy and scikit-image that the search for structure needs: it takes up to a second."""
    for name in ("skimage.draw", "skimage.measure", "livecl.layering.structure"):
        importlib.import_module(name)


def priced_for(options: Options, image: NDArray[np.float32], drawing: Drawing) -> Options:
    """Return the options with lower prices of layers for a pale picture: in proportion to what there is to draw.

    Those of a noisy picture stay, as noise would be drawn.
    """
    target, ground = target_over(image, drawing.background), drawing.background
    shown = float(np.mean(np.square(target if ground is None else target - ground)))
    if not 0 < shown < PALE:
        return options
    interruption.apart(_load_libraries)
    from livecl.layering.segmentation.noise import noise_level

    if noise_level(np.asarray(target, dtype=np.float64)):
        return options
    share = shown / PALE
    return dataclasses.replace(options, prune=share * options.prune, path_gain=share * options.path_gain)


def placed_by(
    options: Options,
    image: NDArray[np.float32],
    drawing: Drawing,
    count: int,
) -> Options:
    """Return the options with the placement that suits a picture: structure or regions.

    Flat pictures and those of smoothly shaded regions are placed by structure. That is kept as found: no revisions,
    which would trade structure for error, and no merging.
    """
    if options.placement != "structure":
        return options
    if options.shape == "outline" and options.background != TRAIN and options.new_color == "target":
        interruption.apart(_load_libraries)
        from livecl.layering.fills.choice import shading_of
        from livecl.layering.structure import structure_kind

        interruption.check()
        target, ground = target_over(image, drawing.background), drawing.background
        asked = 0 if options.path_gain else count
        least = max(options.prune, options.path_gain)
        kind = structure_kind(target, ground, count, shading_of(options), asked, least)
        if kind is not None:
            opacity: Literal["opaque", "train"] = "train" if options.opacity == "train" else "opaque"
            if kind == "cells":  # nothing to train or to simplify
                options = dataclasses.replace(options, iterations=1, simplify=False, primitives=False)
            return dataclasses.replace(
                options,
                revisions=0,
                merge=False,
                opacity=opacity,
                learning_rate=min(options.learning_rate, STRUCTURE_POINT_RATE),
                color_learning_rate=STRUCTURE_COLOR_RATE,
            )
    return dataclasses.replace(options, placement="region")
