# SPDX-License-Identifier: Apache-2.0
"""`Recipe`: all that makes an SVG of a picture, apart from the picture and the device."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import reprlib
from collections.abc import Collection, Iterable, Sequence
from typing import TYPE_CHECKING, Literal, get_args

from livecl.drawing.assembly import scaled
from livecl.drawing.checks import check_number, check_whole, python_number
from livecl.drawing.drawing import WANTED_DRAWING, Drawing
from livecl.editing.cutout import check_cutout
from livecl.errors import check_type
from livecl.image.resizing import DEFAULT_SIZE, reduced, working_size, working_size_of
from livecl.options import WANTED_OPTIONS, Options
from livecl.run.hints import with_hints
from livecl.schedule import MAX_AUTO_PATHS, growing_schedule, parse_schedule
from livecl.svg.groups import GroupKind
from livecl.svg.outline_data import MAX_PRECISION
from livecl.svg.writer import LayerStyle, format_svg
from livecl.version import __version__

if TYPE_CHECKING:
    from livecl.image.masks import Masks
    from livecl.image.reading import Picture
    from livecl.run.callbacks import OnStep
    from livecl.run.control import Control
    from livecl.run.result import Result

#: How layers are written, and which form groups.
LAYER_STYLES, GROUP_KINDS = get_args(LayerStyle), get_args(GroupKind)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Recipe:
    """Recipe: paths, options, size and seed, for any number of pictures.

    The same recipe, picture and device give the same SVG, to the last byte, wherever they meet: in this process, in a
    worker, on another machine with a processor and versions like these.

    Parameters
    ----------
    paths : int, "auto" or None
        Number of paths, at most, as for :func:`livecl.vectorize`.
    schedule : "exp", sequence of int, text or None
        Paths that each stage adds, as for :func:`livecl.vectorize`.
    options : Options
        Parameters of the method.
    seed : int
        Seed of whatever is random.
    size : int
        Larger pictures are reduced to as many pixels as a square of this side, px, has; 0 to work on all pixels. The
        drawing has the picture's own coordinates all the same.
    precision : int
        Decimals kept of coordinates, px of the picture.
    layers : "inkscape" or "plain"
        How layers and stages are written, see :func:`livecl.svg.writer.format_svg`.
    groups : "thing", "stage" or "none"
        Which layers form groups: those that lie inside another one, with it (a run from `start` keeps that drawing's);
        those that one stage added; none.
    cutout : bool
        Whether layers are cut by those above them, see :func:`livecl.editing.cut_out`.
    trap : float
        How far a layer that is cut goes on below those above it, px of the picture.
    swatches : bool
        Whether colours are written as Inkscape's swatches, which change wherever they are used.
    start : Drawing, optional
        Drawing to start from, stretched to the picture's canvas, which must have the same proportions.
    lock : sequence of int
        Layers of `start` that stay as they are.
    masks : Masks, optional
        Masks of things, of the picture's size: each becomes a group of a path along the mask and of those within it,
        `paths` at most.

    Raises
    ------
    ValueError
        If a value is not usable; the message names it.

    Examples
    --------
    >>> Recipe(paths=4).stages, Recipe(schedule="1,1,2").stages
    ((1, 2, 1), (1, 1, 2))
    """

    paths: int | Literal["auto"] | None = None
    schedule: str | Sequence[int] | None = None
    options: Options = dataclasses.field(default_factory=Options)
    seed: int = 0
    size: int = DEFAULT_SIZE
    precision: int = 3
    layers: LayerStyle = "inkscape"
    groups: GroupKind = "thing"
    cutout: bool = False
    trap: float = 0.5
    swatches: bool = False
    start: Drawing | None = None
    lock: Sequence[int] = ()
    masks: Masks | None = None

    def __post_init__(self) -> None:
        for name in ("paths", "seed", "size", "precision"):
            object.__setattr__(self, name, python_number(getattr(self, name)))
        check_type("options", self.options, Options, WANTED_OPTIONS)
        if self.start is not None:
            check_type("start", self.start, Drawing, WANTED_DRAWING)
        parse_schedule(self.schedule, self.paths)
        working_size((1, 1), self.size)
        check_whole("seed", self.seed, 0)
        if self.precision not in range(MAX_PRECISION + 1):
            raise ValueError(f"precision: got {reprlib.repr(self.precision)}, wanted 0 to {MAX_PRECISION} decimals")
        if self.layers not in LAYER_STYLES:
            raise ValueError(f"layers: got {reprlib.repr(self.layers)}, wanted {' or '.join(map(repr, LAYER_STYLES))}")
        if self.groups not in GROUP_KINDS:
            raise ValueError(f"groups: got {reprlib.repr(self.groups)}, wanted {' or '.join(map(repr, GROUP_KINDS))}")
        check_number("trap", self.trap, 0)
        if self.cutout:
            check_cutout()
        if self.masks is not None and (self.start is not None or self.schedule is not None):
            raise ValueError(f"masks: go without {'schedule' if self.start is None else 'start'}")
        if self.start is None and isinstance(self.lock, Collection) and len(self.lock):
            raise ValueError("lock: names layers of a drawing; give the drawing as start")
        num_layers = 0 if self.start is None else self.start.num_layers
        if not isinstance(self.lock, Iterable) or any(layer not in range(num_layers) for layer in self.lock):
            raise ValueError(
                f"lock: got {reprlib.repr(self.lock)}, wanted numbers of the {num_layers} layers of start, from 0 on"
            )
        if self.start is not None and self.options.variant == "released":
            raise ValueError("start: variant 'released' trains the newest paths only, so it starts from nothing")

    @property
    def chooses_paths(self) -> bool:
        """Whether the number of paths is chosen by their gain, as neither number nor schedule is given.

        Not where layers are kept whatever they are worth (`Options.prune` 0, as in the paper).
        """
        nothing_said = self.paths is None and self.schedule is None and self.masks is None
        return nothing_said and (self.start is None or not self.start.num_layers) and self.options.prune > 0

    @property
    def stages(self) -> tuple[int, ...]:
        """Paths that each stage adds; a first stage that refines `start`, or what masks give, adds none."""
        if self.masks is not None:
            return (0,)
        if self.chooses_paths:
            return growing_schedule(MAX_AUTO_PATHS)  # at most; fewer where the picture is not flat
        if self.start is None or not self.start.num_layers:
            return parse_schedule(self.schedule, self.paths)
        more = self.schedule is not None or self.paths is not None
        return (0, *(parse_schedule(self.schedule, self.paths) if more else ()))

    @property
    def fingerprint(self) -> str:
        """A digest that differs where the SVGs of the same picture may: of all values and livecl's version."""
        facts = {
            "version": __version__,
            "options": dataclasses.asdict(self.options),
            "auto": "by the picture" if self.chooses_paths else self.paths == "auto",
            "stages": self.stages,
            "seed": self.seed,
            "size": self.size,
            "precision": self.precision,
            "layers": self.layers,
            "groups": self.groups,
            "cutout": self.trap if self.cutout else None,
            "swatches": self.swatches,
            "start": None if self.start is None else format_svg(self.start, MAX_PRECISION),
            "lock": sorted(map(int, self.lock)),
            "masks": None if self.masks is None else self.masks.digest,
        }
        return hashlib.sha256(json.dumps(facts, sort_keys=True).encode()).hexdigest()

    def start_on(self, size: tuple[int, int]) -> Drawing | None:
        """Return the drawing to start from on a picture's canvas, (height, width) px.

        Raises
        ------
        ValueError
            If the picture has other proportions.
        """
        if self.start is None:
            return None
        (height, width), (start_height, start_width) = size, self.start.size
        if abs(width * start_height - start_width * height) > max(size + self.start.size):
            raise ValueError(
                f"start: a canvas of {start_width}x{start_height} px, wanted the proportions of the picture, "
                f"{width}x{height} px"
            )
        return scaled(self.start, size)

    def vectorize(
        self,
        image: Picture,
        device: int | str | None = None,
        on_step: OnStep | None = None,
        control: Control | None = None,
    ) -> Result:
        """Vectorize a picture; arguments and errors as for :func:`livecl.vectorize`.

        Returns
        -------
        Result
            Drawings in the picture's own coordinates; errors as measured on the pixels that were worked on, see
            `Result.working_size`.
        """
        from livecl.image.background import background_for
        from livecl.image.reading import as_image
        from livecl.run.preparation import Preparation

        pixels = as_image(image)
        size = (pixels.shape[0], pixels.shape[1])
        smaller = working_size_of(pixels, self.size)
        target, start = reduced(pixels, smaller), self.start_on(size)
        ground = background_for(self.options.background, target, None if start is None else start.background)
        preparation = Preparation(target, self.options, ground, device)  # beside imports and the search for structure
        from livecl.run.beginning import Beginning
        from livecl.run.finishing import Finisher
        from livecl.run.result import RunError
        from livecl.run.vectorization import vectorize_pixels

        beginning = Beginning(
            paths=self.paths,
            schedule=self.schedule,
            options=self.options.choosing_paths() if self.chooses_paths else self.options,
            seed=self.seed,
            start=None if start is None else scaled(start, smaller),
            lock=self.lock,
        )
        if self.masks is not None:
            from livecl.run.control import Control
            from livecl.run.guiding import Guided

            guided = Guided(target, self.masks.on(size, smaller), self.masks.names, beginning)
            beginning, control = guided.start(device, Control() if control is None else control)
        finisher = Finisher(target, size, start, self.lock, self.precision, device)
        try:
            result = vectorize_pixels(target, beginning, device, on_step, control, preparation)
            return finisher.finished(result, groups=self.groups == "thing", trap=self.trap if self.cutout else None)
        except RunError as error:
            if error.result is not None:
                error.result = finisher.salvaged(error.result)
            raise

    def svg(self, drawing: Drawing) -> str:
        """Return a drawing as SVG text, as the recipe says."""
        return format_svg(drawing, self.precision, self.layers, groups=self.groups, swatches=self.swatches)


@with_hints
def vectorize(
    image: Picture,
    paths: int | Literal["auto"] | None = None,
    schedule: str | Sequence[int] | None = None,
    options: Options | None = None,
    device: int | str | None = None,
    seed: int = 0,
    on_step: OnStep | None = None,
    start: Drawing | None = None,
    lock: Sequence[int] = (),
    control: Control | None = None,
    size: int = DEFAULT_SIZE,
) -> Result:
    """Turn a picture into a drawing of few closed paths, layer by layer.

    Parameters
    ----------
    image : array_like, path, bytes, binary file or PIL.Image.Image
        Target, see :func:`livecl.image.as_image`. Where it has alpha, the drawing has no background and is to have the
        picture's colour and alpha, unless `Options.background` says otherwise.
    paths : int or "auto", optional
        Number of paths, at most. "auto" goes on as long as further paths gain enough (`Options.path_gain`), to 256.
        Where neither this nor a list of stages is given: none beside those of `start`; else as "auto", to 32 where the
        picture is not flat; 8 where `Options.prune` is 0, as in the paper.
    schedule : "exp" or sequence of int, optional
        Paths that each stage adds, see :func:`livecl.schedule.parse_schedule`.
    options : Options, optional
        Parameters of the method.
    device : int, str or None
        OpenCL device, see :func:`livecl.opencl.device.choose_device`.
    seed : int
        Seed of whatever is random.
    on_step : callable, optional
        Called with a :class:`livecl.Step` after each iteration; where it returns true the run stops there. If it has a
        method ``on_stage``, ``on_stage(step, kept)`` is called at the end of each stage: `kept` is False where the run
        goes on with the drawing before it.
    start : Drawing, optional
        Drawing to start from, stretched to the picture's canvas: a first stage refines it, then the paths asked for are
        added. The result is never worse than it.
    lock : sequence of int
        Layers of `start` that stay as they are.
    control : Control, optional
        A time limit, and checkpoints to go on from.
    size : int
        Larger pictures are reduced to as many pixels as a square of this side, px, has; 0 to work on all pixels. The
        drawing has the picture's own coordinates all the same.

    Returns
    -------
    Result

    Raises
    ------
    ValueError
        If an argument is not usable; the message names it.
    DeviceError, KernelBuildError
        If the device cannot be had.
    CheckpointError
        If the run cannot go on from the checkpoint that `control` names.
    RunError
        If the run fails when it is under way: the loss stops being finite, the device fails or memory runs out. What
        was good before is in its `result`.

    Examples
    --------
    >>> import numpy as np
    >>> picture = np.ones((24, 24, 3))
    >>> picture[6:18, 4:20] = 0.8, 0.2, 0.1
    >>> result = vectorize(picture, paths=1)
    >>> result.drawing.labels, result.mse < 1e-4
    (('red rectangle center',), True)
    """
    recipe = Recipe(
        paths=paths,
        schedule=schedule,
        options=Options() if options is None else options,
        seed=seed,
        size=size,
        start=start,
        lock=lock,
    )
    return recipe.vectorize(image, device, on_step, control)
