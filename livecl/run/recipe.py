# SPDX-License-Identifier: Apache-2.0
"""`Recipe`: all settings that determine the SVG of a picture, apart from the picture and the device."""

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

#: Styles of layers, and kinds of groups.
LAYER_STYLES, GROUP_KINDS = get_args(LayerStyle), get_args(GroupKind)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Recipe:
    """Paths, options, size and seed, for any number of pictures.

    The same recipe, picture and device give the same SVG, to the last byte: in this process, in a worker, or on another
    machine with the same kind of processor and the same versions.

    Parameters
    ----------
    paths : int, "auto" or None
        Maximum number of paths, as for :func:`livecl.vectorize`.
    schedule : "exp", sequence of int, text or None
        Paths added by each stage, as for :func:`livecl.vectorize`.
    options : Options
        Parameters of the method.
    seed : int
        Seed of all random choices.
    size : int
        Larger pictures are reduced to the area of a square of this side, px; 0 to keep all pixels. The drawing has the
        picture's own coordinates in any case.
    precision : int
        Decimals kept of coordinates, px of the picture.
    layers : "inkscape" or "plain"
        Style of layers, see :func:`livecl.svg.writer.format_svg`.
    groups : "thing", "stage" or "none"
        Layers that form groups: a layer and those inside it (a run from `start` keeps that drawing's groups); those of
        one stage; none.
    cutout : bool
        Whether layers are cut by those above them, see :func:`livecl.editing.cut_out`.
    trap : float
        How far cut layers extend below those above them, px of the picture.
    swatches : bool
        Whether colours are written as Inkscape swatches, which can be edited for all layers at once.
    start : Drawing, optional
        Drawing to start from, stretched to the picture's canvas, which must have the same proportions.
    lock : sequence of int
        Layers of `start` that are not changed.
    masks : Masks, optional
        Masks of things, of the picture's size: each becomes a group of at most `paths` paths, one along the mask and
        others within it.

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
        """Whether the number of paths is chosen by their gain: without number and schedule, and if layers are pruned.

        With `Options.prune` 0, as in the paper, layers are kept whatever they gain.
        """
        nothing_said = self.paths is None and self.schedule is None and self.masks is None
        return nothing_said and (self.start is None or not self.start.num_layers) and self.options.prune > 0

    @property
    def stages(self) -> tuple[int, ...]:
        """Paths added by each stage; a first stage that refines `start` or the layers of masks adds none."""
        if self.masks is not None:
            return (0,)
        if self.chooses_paths:
            return growing_schedule(MAX_AUTO_PATHS)  # fewer if the picture is not flat
        if self.start is None or not self.start.num_layers:
            return parse_schedule(self.schedule, self.paths)
        more = self.schedule is not None or self.paths is not None
        return (0, *(parse_schedule(self.schedule, self.paths) if more else ()))

    @property
    def fingerprint(self) -> str:
        """Digest of all values and livecl's version: equal only if SVGs of the same picture are equal."""
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
            If the picture has different proportions.
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
            Drawings in the picture's own coordinates; errors are measured at `Result.working_size`.
        """
        from livecl.image.background import background_for
        from livecl.image.reading import as_image
        from livecl.run.preparation import Preparation

        pixels = as_image(image)
        size = (pixels.shape[0], pixels.shape[1])
        smaller = working_size_of(pixels, self.size)
        target, start = reduced(pixels, smaller), self.start_on(size)
        ground = background_for(self.options.background, target, None if start is None else start.background)
        preparation = Preparation(target, self.options, ground, device)  # in parallel with imports and structure search
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
        """Format a drawing as SVG with the recipe's settings."""
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
        Target, see :func:`livecl.image.as_image`. If it has alpha, the drawing has no background and is fitted to
        colour and alpha, unless `Options.background` says otherwise.
    paths : int or "auto", optional
        Maximum number of paths. "auto" adds paths as long as they gain enough (`Options.path_gain`), up to 256. Without
        `paths` and `schedule`: none if there is a `start`; else as "auto", up to 32 if the picture is not flat; 8 if
        `Options.prune` is 0, as in the paper.
    schedule : "exp" or sequence of int, optional
        Paths added by each stage, see :func:`livecl.schedule.parse_schedule`.
    options : Options, optional
        Parameters of the method.
    device : int, str or None
        OpenCL device, see :func:`livecl.opencl.device.choose_device`.
    seed : int
        Seed of all random choices.
    on_step : callable, optional
        Called with a :class:`livecl.Step` after each iteration; if it returns true, the run stops. If it has a method
        ``on_stage``, ``on_stage(step, kept)`` is called at the end of each stage: `kept` is False if the run returns to
        the drawing before it.
    start : Drawing, optional
        Drawing to start from, stretched to the picture's canvas: a first stage refines it, then `paths` are added. The
        result is never worse than it.
    lock : sequence of int
        Layers of `start` that are not changed.
    control : Control, optional
        Time limit, and a checkpoint to resume from.
    size : int
        Larger pictures are reduced to the area of a square of this side, px; 0 to keep all pixels. The drawing has the
        picture's own coordinates in any case.

    Returns
    -------
    Result

    Raises
    ------
    ValueError
        If an argument is not usable; the message names it.
    DeviceError, KernelBuildError
        If the device is not available.
    CheckpointError
        If the run cannot be resumed from the checkpoint of `control`.
    RunError
        If the run fails after it has begun: the loss is no longer finite, the device fails or memory runs out. The last
        good state is its `result`.

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
