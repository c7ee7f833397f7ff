# SPDX-License-Identifier: Apache-2.0
"""Result of a run: the drawing and its stages; also of one that fails."""

from __future__ import annotations

import dataclasses
import os

from livecl.drawing.drawing import Drawing
from livecl.errors import LiveclError
from livecl.options import Options
from livecl.svg import GroupKind, LayerStyle, format_svg, save_svg


@dataclasses.dataclass(frozen=True)
class Stage:
    """Outcome of a stage: the drawing as it would be saved, its mean squared error, steps, seconds with placement.

    The error is NaN where it is not known, of a drawing that was saved from a device that failed.
    """

    drawing: Drawing
    mse: float
    iterations: int
    seconds: float

    @property
    def paths(self) -> int:
        """Layers of the drawing."""
        return self.drawing.num_layers


@dataclasses.dataclass(frozen=True)
class Result:
    """Outcome of a run.

    Attributes
    ----------
    drawing : Drawing
        The drawing as it is saved: colours of 8 bits, coordinates rounded.
    mse : float
        Mean of the squared difference from the target, in the program's own render, over pixels and channels: RGB, or
        premultiplied RGBA where the drawing has no background.
    stages : tuple of Stage
        Outcome of each stage.
    seconds, compile_seconds : float
        Time of the stages, and of making the kernels ready before.
    device : str
        The device that was used.
    options : Options
        Parameters of the method.
    working_size : (int, int) or None
        Height and width, px, of the pixels that were worked on and that all errors are measured on; None where they are
        the drawing's own.
    stopped : str or None
        Why the run ended before its end, in a few words: "time limit", "callback", the reason of `Control.stop`, or the
        message of the error that it failed with; None where it did not. The drawing is then the best that there was.
    """

    drawing: Drawing
    mse: float
    stages: tuple[Stage, ...]
    seconds: float
    compile_seconds: float
    device: str
    options: Options
    working_size: tuple[int, int] | None = None
    stopped: str | None = None

    @property
    def svg(self) -> str:
        """The drawing as SVG text."""
        return format_svg(self.drawing)

    def save_svg(
        self,
        path: str | os.PathLike[str],
        precision: int = 3,
        layers: LayerStyle = "inkscape",
        groups: GroupKind | None = None,
    ) -> None:
        """Write the drawing as SVG, replacing an existing file atomically; see :func:`livecl.svg.format_svg`."""
        save_svg(self.drawing, path, precision, layers, groups=groups)

    def __str__(self) -> str:
        """Summary in three lines: the drawing, its error, the time."""
        layers, (height, width) = self.drawing.num_layers, self.drawing.size
        worked = self.working_size
        at = "" if worked in (None, self.drawing.size) else f" at {worked[1]} x {worked[0]} px"
        return (
            f"drawing of {layers} layers, {self.drawing.num_segments} segments, {width} x {height} px\n"
            f"MSE {self.mse:.3g}{at}{'' if self.stopped is None else f'; stopped: {self.stopped}'}\n"
            f"{self.seconds:.1f} s on {self.device}"
        )

    def _repr_svg_(self) -> str:
        return self.svg


class RunError(LiveclError):
    """A run failed when it was under way; `__cause__` is the error itself.

    Attributes
    ----------
    result : Result or None
        The last good result, or None.
    """

    def __init__(self, message: str, result: Result | None) -> None:
        super().__init__(message)
        self.result = result
