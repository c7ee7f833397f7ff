# SPDX-License-Identifier: Apache-2.0
"""`Recipe`: all that makes an SVG of a picture, apart from the picture and the device."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Literal

from numpy.typing import ArrayLike

from livecl import __version__
from livecl.options import Options
from livecl.scaling import DEFAULT_SIZE, reduced, scaled, working_size
from livecl.schedule import parse_schedule

if TYPE_CHECKING:
    from livecl.drawing import Drawing
    from livecl.result import Result
    from livecl.vectorizer import Step


@dataclasses.dataclass(frozen=True, kw_only=True)
class Recipe:
    """What is to be done to each of any number of pictures.

    The same recipe, picture and device give the same SVG, to the last byte, wherever they meet: in this process, in a
    worker, on another machine.

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
        Longer side, px, that larger pictures are reduced to for the work; 0 to work on all pixels. The drawing has the
        picture's own coordinates all the same.
    precision : int
        Decimals kept of coordinates, px of the picture.

    Raises
    ------
    ValueError
        If a value is not usable; the message names it.
    """

    paths: int | Literal["auto"] | None = None
    schedule: str | Sequence[int] | None = None
    options: Options = dataclasses.field(default_factory=Options)
    seed: int = 0
    size: int = DEFAULT_SIZE
    precision: int = 3

    def __post_init__(self) -> None:
        parse_schedule(self.schedule, self.paths)
        working_size((1, 1), self.size)
        if isinstance(self.seed, bool) or not isinstance(self.seed, int) or self.seed < 0:
            raise ValueError(f"seed: got {self.seed!r}, wanted a whole number of at least 0")
        if self.precision not in range(10):
            raise ValueError(f"precision: got {self.precision!r}, wanted 0 to 9 decimals")

    @property
    def stages(self) -> tuple[int, ...]:
        """Paths that each stage adds."""
        return parse_schedule(self.schedule, self.paths)

    @property
    def fingerprint(self) -> str:
        """A digest that differs where the SVGs of the same picture may: of all values and livecl's version."""
        facts = {
            **dataclasses.asdict(self),
            "schedule": self.stages,
            "paths": "auto" if self.paths == "auto" else sum(self.stages),
            "version": __version__,
        }
        return hashlib.sha256(json.dumps(facts, sort_keys=True).encode()).hexdigest()

    def vectorize(
        self,
        image: ArrayLike,
        device: int | str | None = None,
        on_step: Callable[[Step], bool | None] | None = None,
    ) -> Result:
        """Vectorize a picture; arguments and errors as for :func:`livecl.vectorize`.

        Returns
        -------
        Result
            Drawings in the picture's own coordinates; errors as measured on the pixels that were worked on, see
            `Result.working_size`.
        """
        from livecl.image import as_image
        from livecl.vectorizer import vectorize

        target = as_image(image)
        size = (target.shape[0], target.shape[1])
        smaller = working_size(size, self.size)
        result = vectorize(
            reduced(target, smaller),
            paths=self.paths,
            schedule=self.schedule,
            options=self.options,
            device=device,
            seed=self.seed,
            on_step=on_step,
        )
        return dataclasses.replace(
            result,
            drawing=self._finished(result.drawing, size),
            stages=tuple(
                dataclasses.replace(stage, drawing=self._finished(stage.drawing, size)) for stage in result.stages
            ),
            working_size=smaller,
        )

    def svg(self, drawing: Drawing) -> str:
        """Return a drawing as SVG text, as the recipe says."""
        from livecl.svg import format_svg

        return format_svg(drawing, self.precision)

    def _finished(self, drawing: Drawing, size: tuple[int, int]) -> Drawing:
        """Return a drawing as it is saved, on the picture's canvas."""
        from livecl.svg import quantize

        return quantize(scaled(drawing, size), self.precision)
