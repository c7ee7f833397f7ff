# SPDX-License-Identifier: Apache-2.0
"""Compile the kernels in a background thread while the host prepares the run."""

from __future__ import annotations

import threading

import numpy as np
from numpy.typing import NDArray

from livecl import interruption
from livecl.drawing.drawing import Drawing
from livecl.errors import LiveclError
from livecl.geometry.outlines import circle
from livecl.options import Options
from livecl.rendering.rasterizer import Rasterizer
from livecl.training.objective import Objective

_prepared: set[tuple[object, ...]] = set()


def warm_up(rasterizer: Rasterizer, objective: Objective, options: Options, background: object) -> None:
    """Compile the kernels of a step: runtimes compile a kernel when it is first launched."""
    height, width = rasterizer.size
    outline = [circle((width / 2, height / 2), min(height, width) / 4, 4)]
    disc = Drawing.from_outlines([outline], (0, 0, 0, 1), rasterizer.size)
    rasterizer.coverages(disc)
    objective.warm_up(disc.replace(background=background), options)


class Preparation:
    """Compiles the kernels of a run in a thread, once for each device, number of channels and loss.

    Compilers run without the interpreter's lock. Errors here are ignored: they occur again when the run uses the
    kernels.

    Parameters
    ----------
    image : (H, W, 3) or (H, W, 4) float32
        The picture at its working size.
    options : Options
        Parameters of the method.
    background : (3,) or None
        Background of the drawing.
    device : int, str or None
        OpenCL device.
    """

    def __init__(
        self, image: NDArray[np.float32], options: Options, background: object, device: int | str | None
    ) -> None:
        kind = device, background is None, options.loss, options.variant
        self._thread = threading.Thread(target=self._run, args=(image.shape[:2], options, background, device))
        if kind not in _prepared:
            _prepared.add(kind)
            self._thread.start()

    def wait(self) -> None:
        """Wait until all is compiled; an interruption ends the waiting, not the compiler."""
        while self._thread.is_alive():
            self._thread.join(interruption.PATIENCE)
            interruption.check()

    @staticmethod
    def _run(size: tuple[int, int], options: Options, background: object, device: int | str | None) -> None:
        try:
            rasterizer = Rasterizer(size, device)
            target = np.zeros((*size, 3 if background is not None else 4), np.float32)
            warm_up(rasterizer, Objective(rasterizer, target), options, background)
        except (LiveclError, MemoryError, ValueError):
            pass
