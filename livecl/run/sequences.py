# SPDX-License-Identifier: Apache-2.0
"""Vectorize consecutive pictures into drawings whose layers keep their identity."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from livecl.drawing.assembly import concatenate, scaled
from livecl.drawing.checks import check_whole, python_number
from livecl.drawing.drawing import Drawing
from livecl.errors import check_type
from livecl.image.background import NONE
from livecl.image.reading import Picture, as_image
from livecl.image.resizing import DEFAULT_SIZE, reduced, working_size
from livecl.interpolation.blending import collapsed
from livecl.options import WANTED_OPTIONS, Options
from livecl.run.beginning import Beginning
from livecl.run.hints import with_hints
from livecl.run.result import Result
from livecl.run.vectorization import vectorize_pixels
from livecl.svg import quantize

#: Factor of the learning rate of points, which start near their places: they slide along outlines less, and errors end
#: lower.
REFINING_RATE = 0.5
#: Iterations for each picture but the first, as a multiple of those of a stage: there is one stage only, in place of
#: several stages and revisions.
REFINING_STAGES = 2
#: Paths may be added if the error exceeds this multiple of the first picture's, and by this difference.
POOR_RATIO, POOR_RISE = 1.2, 1e-5
#: Added paths are kept if they lower the error to this share.
GOOD_RATIO = 0.8


@dataclasses.dataclass(frozen=True)
class SequenceResult:
    """Outcome of a sequence.

    Attributes
    ----------
    drawings : tuple of Drawing
        One for each picture, as saved, all with the same layers and segments: layer n of each is the same thing.
    mse : tuple of float
        Their mean squared errors, as of :attr:`livecl.Result.mse`.
    seconds : tuple of float
        Time of each, without building kernels.
    device : str
        OpenCL device used.
    """

    drawings: tuple[Drawing, ...]
    mse: tuple[float, ...]
    seconds: tuple[float, ...]
    device: str


@with_hints
def vectorize_sequence(
    images: Iterable[Picture],
    *,
    paths: int | Literal["auto"] | None = None,
    schedule: str | Sequence[int] | None = None,
    options: Options | None = None,
    refine_iterations: int | None = None,
    add_paths: int = 1,
    device: int | str | None = None,
    seed: int = 0,
    start: Drawing | None = None,
    on_frame: Callable[[int, Result], bool | None] | None = None,
    size: int = DEFAULT_SIZE,
) -> SequenceResult:
    """Turn consecutive pictures into drawings, each of which starts from the one before.

    The first picture is vectorized as by :func:`livecl.vectorize`. For each of the others, the drawing before is
    refined in one stage: no layer is dropped or moved in paint order. If that does not suffice, paths may be added; in
    the drawings of earlier pictures, these are points without area.

    Parameters
    ----------
    images : iterable of pictures
        Targets of one size, each as for :func:`livecl.image.as_image`; the iterable is read one by one.
    paths, schedule, options, device, seed
        As in :func:`livecl.vectorize`; `paths` and `schedule` are those of the first picture.
    refine_iterations : int, optional
        Iterations for each picture but the first (default: twice `options.iterations`).
    add_paths : int
        Paths that may be added for each picture whose error, after refinement, exceeds that of the first by a fifth and
        by 1e-5; they are kept if they lower it by a fifth.
    start : Drawing, optional
        Drawing from which the first picture starts.
    on_frame : callable, optional
        Called with the index, from 0, and the result of each picture; if it returns true, the sequence ends.
    size : int
        Larger pictures are reduced to the area of a square of this side, px; 0 to keep all pixels. The drawings have
        the pictures' own coordinates in any case.

    Returns
    -------
    SequenceResult

    Raises
    ------
    ValueError
        If there are no pictures, their sizes differ, or an argument is not usable; the message names it.
    ImageError, DeviceError, KernelBuildError, LiveclError
        As :func:`livecl.vectorize`.

    Examples
    --------
    >>> import numpy as np
    >>> picture = np.ones((24, 24, 3))
    >>> picture[6:18, 4:12] = 0.8, 0.2, 0.1
    >>> moved = [np.roll(picture, columns, axis=1) for columns in (0, 1, 2)]
    >>> result = vectorize_sequence(moved, paths=1, options=Options(iterations=60))
    >>> [drawing.num_layers for drawing in result.drawings], max(result.mse) < 1e-3
    ([1, 1, 1], True)
    """
    options = Options() if options is None else options
    check_type("options", options, Options, WANTED_OPTIONS)
    paths, seed, add_paths, size = map(python_number, (paths, seed, add_paths, size))
    refine_iterations = python_number(refine_iterations)
    check_whole("add_paths", add_paths, 0)
    iterations = REFINING_STAGES * options.iterations if refine_iterations is None else refine_iterations
    follower = _Follower(_refining(options, iterations), options.prune, add_paths, seed, device)
    results: list[Result] = []
    canvas = (0, 0)
    for index, image in enumerate(images):
        pixels = as_image(image)
        if not results:
            canvas = pixels.shape[0], pixels.shape[1]
            if start is not None and start.size != canvas:
                raise ValueError(f"start: a canvas of {start.size} px, wanted the pictures' {canvas}")
        elif pixels.shape[:2] != canvas:
            raise ValueError(f"images: {index} is of {pixels.shape[:2]} px, wanted {canvas} as 0 has")
        smaller = working_size(canvas, size)
        target = reduced(pixels, smaller)
        if results:
            result = follower.result(target, results[-1].drawing, results[0].mse)
        else:
            scaled_start = None if start is None else scaled(start, smaller)
            beginning = Beginning(paths=paths, schedule=schedule, options=options, seed=seed, start=scaled_start)
            result = vectorize_pixels(target, beginning, device)
            if not result.drawing.num_layers:
                raise ValueError("images: 0 has the background's colour only, so there is no layer to continue with")
        results.append(result)
        if on_frame is not None and on_frame(index, _enlarged(result, canvas)):
            break
    if not results:
        raise ValueError("images: got none, wanted at least one")
    return SequenceResult(
        drawings=tuple(_on_canvas(drawing, canvas) for drawing in _padded([result.drawing for result in results])),
        mse=tuple(result.mse for result in results),
        seconds=tuple(result.seconds for result in results),
        device=results[0].device,
    )


@dataclasses.dataclass(frozen=True)
class _Follower:
    """Vectorizes a picture from the drawing of the one before; added paths are pruned below `prune`."""

    refining: Options
    prune: float
    add_paths: int
    seed: int
    device: int | str | None

    def result(self, target: NDArray[np.float32], before: Drawing, first_mse: float) -> Result:
        """Refine the drawing before, on the canvas of `target`; add paths if the error is far above the first one's."""
        options = self.refining
        if before.background is None:
            options = dataclasses.replace(options, background=NONE)
        beginning = Beginning(options=options, seed=self.seed, start=before)
        refined = vectorize_pixels(target, beginning, self.device)
        if not self.add_paths or refined.mse < max(POOR_RATIO * first_mse, first_mse + POOR_RISE):
            return refined
        more = dataclasses.replace(
            beginning,
            schedule=str(self.add_paths),
            options=dataclasses.replace(options, prune=self.prune),
            start=refined.drawing,
        )
        return _better(refined, vectorize_pixels(target, more, self.device))


def _enlarged(result: Result, canvas: tuple[int, int]) -> Result:
    """Return a result with drawings on the pictures' canvas; its errors are those at the working size."""
    stages = tuple(dataclasses.replace(stage, drawing=_on_canvas(stage.drawing, canvas)) for stage in result.stages)
    drawing = _on_canvas(result.drawing, canvas)
    return dataclasses.replace(result, drawing=drawing, stages=stages, working_size=result.drawing.size)


def _on_canvas(drawing: Drawing, canvas: tuple[int, int]) -> Drawing:
    """Return a drawing stretched to a canvas, with coordinates rounded as saved."""
    return drawing if drawing.size == canvas else quantize(scaled(drawing, canvas))


def _refining(options: Options, iterations: int) -> Options:
    """Return options that keep all layers and take smaller steps."""
    return dataclasses.replace(
        options,
        iterations=iterations,
        learning_rate=REFINING_RATE * options.learning_rate,
        revisions=0,
        merge=False,
        simplify=False,  # keeps the segments of the drawing before
        primitives=False,
        prune=0.0,
        path_gain=0.0,
        target_mse=0.0,
    )


def _better(refined: Result, added: Result) -> Result:
    """Return the result with added paths if it is enough better, else the one before; with the time of both."""
    kept = added if added.mse <= GOOD_RATIO * refined.mse else refined
    return dataclasses.replace(kept, seconds=refined.seconds + added.seconds)


def _padded(drawings: Sequence[Drawing]) -> tuple[Drawing, ...]:
    """Give all drawings the layers of the last; each has the layers of the one before and possibly more.

    New layers are recognized by a later stage than all earlier ones; the others keep their order.
    """
    padded = [drawings[0]]
    for drawing in drawings[1:]:
        before = padded[-1]
        if drawing.num_layers > before.num_layers:
            new = drawing.stages > before.stages.max()
            lone = drawing.layer_subset(new)
            places = iter(range(before.num_layers, drawing.num_layers)), iter(range(before.num_layers))
            order = [next(places[0] if is_new else places[1]) for is_new in new]
            padded = [concatenate(earlier, collapsed(lone)).layer_subset(order) for earlier in padded]
        padded.append(drawing)
    return tuple(padded)
