# SPDX-License-Identifier: Apache-2.0
"""`Result` of a run: the drawing and its stages; `RunError`, which carries that of a failed run."""

from __future__ import annotations

import dataclasses
import os

from livecl.drawing.drawing import Drawing
from livecl.errors import LiveclError
from livecl.options import Options
from livecl.svg import GroupKind, LayerStyle, format_svg, save_svg


@dataclasses.dataclass(frozen=True)
class Stage:
    """Outcome of a stage: the drawing as saved, its mean squared error, steps, and seconds, placement included.

    The error is NaN if it is unknown, as after a failure of the device.
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
        The drawing as saved: 8-bit colours, rounded coordinates.
    mse : float
        Mean squared difference of the rasterizer's image from the target over pixels and channels: RGB, or
        premultiplied RGBA if the drawing has no background.
    stages : tuple of Stage
        Outcome of each stage.
    seconds, compile_seconds : float
        Time of the stages, and of building the kernels before.
    device : str
        OpenCL device used.
    options : Options
        Parameters of the method.
    working_size : (int, int) or None
        Height and width of the reduced picture on which the run worked and errors are measured, px; None if it was not
        reduced.
    stopped : str or None
        Why the run was stopped: "time limit", "callback", the reason of `Control.stop`, or the message of an error. The
        drawing is then the best so far. None if the run was finished.
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
    """A run failed after it had begun; `__cause__` is the original error.

    Attributes
    ----------
    result : Result or None
        The last good result, or None.
    """

    def __init__(self, message: str, result: Result | None) -> None:
        super().__init__(message)
        self.result = result
