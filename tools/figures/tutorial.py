# SPDX-License-Identifier: Apache-2.0
"""Figures of the README and the tutorial: results of their commands."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import livecl
from figures.strip import save_small, save_strip, shown
from livecl.views.sheet import resized, stage_sheet

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
#: Side of the README's pictures, px.
SIDE = 120


def sheet(file: Path) -> None:
    """The stages of the cherries: --preset draft --paths 16 --background auto."""
    image = livecl.read_image(EXAMPLES / "fruit.png")
    options = livecl.options.PRESETS["draft"](background="auto")
    result = livecl.vectorize(image, paths=16, options=options)
    save_small(file, np.rint(255 * stage_sheet(image, result, cell=150)))


def face(file: Path) -> None:
    """The face beside its drawing after each of six stages."""
    image = livecl.read_image(EXAMPLES / "face.png")
    result = livecl.vectorize(image, schedule=(1,) * 6)
    pictures = [image, *(shown(stage.drawing, 2 * SIDE) for stage in result.stages)]
    save_small(file, np.concatenate([np.asarray(resized(picture, (SIDE, SIDE))) for picture in pictures], axis=1))


def edit(file: Path) -> None:
    """The face, without a cheek, and with it drawn again while the head is locked."""
    image = livecl.read_image(EXAMPLES / "face.png")
    first = livecl.vectorize(image, options=livecl.Options(holes=False)).drawing
    cheek = first.select("orange circle left")
    edited = first.layer_subset(np.setdiff1d(np.arange(first.num_layers), cheek))
    again = livecl.vectorize(image, paths=1, start=edited, lock=[0]).drawing
    cells = [(first, "face.svg", ""), (edited, "edited.svg", ""), (again, "again.svg", "")]
    save_strip(file, [(shown(drawing), name, text) for drawing, name, text in cells])


FIGURES = {"face": face, "tutorial-sheet": sheet, "tutorial-edit": edit}
