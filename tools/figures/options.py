# SPDX-License-Identifier: Apache-2.0
"""Figures of the options: the same picture, with one option changed."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
import skimage.data
from numpy.typing import NDArray

import livecl
from figures.strip import Cell, save_strip, shown
from livecl.image.reading import as_image
from livecl.options import PRESETS
from livecl.run.recipe import Recipe
from livecl.run.result import Result

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


@functools.cache
def example(name: str) -> NDArray[Any]:
    """Return a sample picture, or scikit-image's astronaut."""
    if name == "astronaut":
        return as_image(skimage.data.astronaut())
    return as_image(livecl.read_image(EXAMPLES / f"{name}.png"))


def run(name: str, paths: int | str = 8, preset: str = "draft", size: int = 512, **changes: Any) -> Result:
    """Vectorize a picture as the command line does."""
    schedule = [int(paths)] if preset == "diffvg" else None
    recipe = Recipe(paths=paths, schedule=schedule, size=size, options=PRESETS[preset](**changes))  # type: ignore[arg-type]
    return recipe.vectorize(example(name))


def strip(cases: Iterable[tuple[str, Callable[[], Result]]]) -> list[Cell]:
    """Return a cell for each run: its picture, its options, and its result."""
    cells = []
    for caption, make in cases:
        result = make()
        count = result.drawing.num_layers
        outcome = f"{count} path{'' if count == 1 else 's'}, MSE {result.mse:.2g}"
        cells.append((shown(result.drawing), caption, outcome))
    return cells


def varied(option: str, name: str, values: Iterable[Any], **others: Any) -> Callable[[Path], None]:
    """Return a function that makes the figure of several values of one option."""

    def make(file: Path) -> None:
        key = option.replace(" ", "_")
        cases = [(f"{option} {value}", functools.partial(run, name, **{**others, key: value})) for value in values]
        save_strip(file, strip(cases))

    return make


def presets(file: Path) -> None:
    """The presets on the portrait, except those that differ in the number of paths only."""
    names = ("default", "draft", "icon", "paper", "released", "diffvg")
    save_strip(file, strip((f"preset {name}", functools.partial(run, "portrait", preset=name)) for name in names))


def placement(file: Path) -> None:
    """The starts of new paths, and their shapes, two rows: after no and after all training."""
    kinds = (
        ("region", "outline"),
        ("component", "outline"),
        ("component", "circle"),
        ("random", "circle"),
        ("random", "random"),
    )
    cells = []
    for iterations in (1, 60):
        for where, shape in kinds:
            changes = {"placement": where, "shape": shape, "iterations": iterations, "prune": 0.0}
            ((picture, _, outcome),) = strip([("", functools.partial(run, "badge", 6, **changes))])
            cells.append((picture, f"{where}, {shape}", f"{iterations} it., {outcome.partition(', ')[2]}"))
    save_strip(file, cells, columns=len(kinds))


def holes(file: Path) -> None:
    """The layers of the face, bottom first, with holes and without."""
    cells: list[Cell] = []
    columns = 6
    for option, opened in (("with holes", True), ("without", False)):
        drawing = run("face", preset="default", placement="region", holes=opened).drawing
        for layer, label in enumerate(drawing.labels):
            alone = drawing.layer_subset([layer]).replace(background=(0.93, 0.93, 0.93))
            cells.append((shown(alone), label.partition(" ")[2], option if layer == 0 else ""))
        cells += [(np.ones((150, 150, 3)), "", "")] * (-len(cells) % columns)
    save_strip(file, cells, columns=columns)


def loss(file: Path) -> None:
    """Both losses where paths start as circles, as in the paper, on two pictures."""
    circles = {"placement": "component", "shape": "circle", "iterations": 200}
    cells = []
    for name in ("fruit", "portrait"):
        cases = [(f"loss {value}", functools.partial(run, name, loss=value, **circles)) for value in ("mse", "udf")]
        cells += strip(cases)
    save_strip(file, cells)


FIGURES: dict[str, Callable[[Path], None]] = {
    "options-paths": varied("paths", "scene", (2, 4, 8, 16, 32, 64)),
    "options-preset": presets,
    "options-iterations": varied("iterations", "fruit", (5, 20, 60, 200, 500)),
    "options-loss": loss,
    "options-placement": placement,
    "options-holes": holes,
    "options-background": varied("background", "soft", ("picture", "white", "auto", "#203040", "train"), paths=12),
    "options-fills": varied("fills", "sunset", ("solid", "linear", "radial", "auto"), preset="default"),
    "options-xing-weight": varied("xing weight", "portrait", (0.0, 0.01, 0.1, 1.0), preset="paper"),
    "options-max-segments": varied("max segments", "letter", (4, 8, 12, 16, 24), paths=1),
    "options-size": varied("size", "astronaut", (64, 128, 256, 512), paths=32),
}
