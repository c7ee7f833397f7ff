# SPDX-License-Identifier: Apache-2.0
"""What tests of batches share: small pictures, a quick recipe, and recipes whose workers die or tell."""

from __future__ import annotations

import os
import signal
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from livecl.errors import LiveclError
from livecl.image.reading import save_image
from livecl.options import Options
from livecl.run.recipe import Recipe
from livecl.run.result import Result

#: A run that takes a moment, and one that takes long enough for its worker to be killed in it.
QUICK = Recipe(paths=2, options=Options(iterations=5, revisions=0))
SLOW = Recipe(paths=3, options=Options(iterations=150, revisions=0))


def make_pictures(folder: Path, count: int) -> list[Path]:
    """Write pictures of 48x48 px, each with a square of another colour and size."""
    folder.mkdir(exist_ok=True)
    files = []
    for index in range(count):
        image = np.ones((48, 48, 3))
        image[10 : 20 + 3 * index, 12:36] = (0.8, 0.1 * index, 0.3)
        files.append(folder / f"picture-{index}.png")
        save_image(files[-1], image)
    return files


def single_runs(files: list[Path], recipe: Recipe) -> dict[str, bytes]:
    """Return the SVG of each picture as made in this process, by the picture's name."""
    return {file.stem: recipe.svg(recipe.vectorize(file).drawing).encode() for file in files}


def svgs(folder: Path) -> dict[str, bytes]:
    """Return the SVGs in a folder by name."""
    return {file.stem: file.read_bytes() for file in folder.glob("*.svg")}


class Deadly(Recipe):
    """A recipe that kills the process which applies it to the first of the pictures above."""

    def vectorize(self, image: Any, *arguments: Any) -> Result:
        if is_first(image):
            os.kill(os.getpid(), signal.SIGKILL)
        return super().vectorize(image, *arguments)


class TellsThreads(Recipe):
    """A recipe that fails with what PoCL is told about threads."""

    def vectorize(self, *_: Any) -> Any:
        raise LiveclError(f"threads: {os.environ['POCL_MAX_PTHREAD_COUNT']}")


class NeverArriving(Recipe):
    """A recipe that ends the process which receives it."""

    def __reduce__(self) -> Any:
        return os._exit, (3,)


def is_first(image: NDArray[np.float32]) -> bool:
    return bool(image[15, 15, 1] < 0.05)
