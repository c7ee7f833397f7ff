# SPDX-License-Identifier: Apache-2.0
"""Runs guided by masks: groups, counts of paths, the outside, and refusals."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from support import drawings, shapes

from livecl import cli
from livecl.drawing import Drawing
from livecl.image.masks import Masks
from livecl.options import Options
from livecl.rendering import Rasterizer, render
from livecl.run.control import Control
from livecl.run.recipe import Recipe
from livecl.svg import read_svg

QUICK = Options(iterations=10, fills="solid")
YELLOW, BROWN, RED, BLUE = (1, 0.8, 0.1, 1), (0.3, 0.15, 0.05, 1), (0.9, 0.1, 0.1, 1), (0.1, 0.2, 0.8, 1)


def face() -> Drawing:
    """A head with two eyes and a mouth, a hat over its top, and a ball beside it."""
    layers = [
        ([shapes.circle((40, 45), 28)], YELLOW),
        ([shapes.circle((30, 45), 5)], BROWN),
        ([shapes.circle((50, 45), 5)], BROWN),
        ([drawings.rectangle(30, 57, 50, 63)], RED),
        ([drawings.rectangle(20, 5, 60, 26)], BLUE),
        ([shapes.circle((88, 20), 8)], RED),
    ]
    return drawings.build(layers, (80, 104), (1.0, 1.0, 1.0))


def masks() -> Masks:
    """Whole head and hat; not the ball."""
    drawing = face()
    return Masks(("hat", "head"), np.clip(Rasterizer(drawing.size).coverages(drawing), 0, 1)[[4, 0]])


def test_a_group_for_each_mask_with_what_lies_within_it() -> None:
    result = Recipe(options=QUICK, masks=masks()).vectorize(render(face()))
    drawing = result.drawing
    assert drawing.groups == ((), ("head",), ("head",), ("head",), ("head",), ("hat",))
    assert result.mse < 3e-4
    head = Rasterizer(drawing.size).coverages(drawing)[1]
    whole = masks().pixels[1]
    assert np.minimum(head, whole).sum() > 0.96 * np.maximum(head, whole).sum()  # below the hat as well


@pytest.mark.parametrize(("paths", "heads"), [(1, 1), (2, 2), (3, 3), ("auto", 4)])
def test_paths_of_each_mask_are_counted_or_automatic(paths: int, heads: int) -> None:
    drawing = Recipe(paths=paths, options=QUICK, masks=masks()).vectorize(render(face())).drawing
    assert drawing.groups.count(("head",)) == heads
    assert drawing.groups.count(("hat",)) == 1


def test_pictures_with_alpha_and_labels(tmp_path: Path) -> None:
    image = render(face().replace(background=None))
    Image.fromarray(np.rint(image * 255).astype(np.uint8)).save(tmp_path / "in.png")
    labels = np.zeros((80, 104), np.uint8)
    for value, mask in zip((5, 2), masks().pixels, strict=True):
        labels[(mask >= 0.5) & (labels == 0)] = value
    Image.fromarray(labels).save(tmp_path / "labels.png")
    arguments = [str(tmp_path / "in.png"), "-o", str(tmp_path / "out.svg"), "--iterations", "10", "-q"]
    assert cli.main([*arguments, "--masks", str(tmp_path / "labels.png")]) == 0
    drawing = read_svg(tmp_path / "out.svg")
    assert {"mask 1", "mask 2"} == {path[0] for path in drawing.groups if path}
    shown = render(drawing)
    assert float(np.mean(np.square(shown - image))) < 2e-3


def test_what_does_not_go_together_is_refused_in_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Image.new("RGB", (30, 20), "red").save(tmp_path / "in.png")
    folder = tmp_path / "masks"
    folder.mkdir()
    Image.new("L", (31, 20), 255).save(folder / "a.png")
    base = [str(tmp_path / "in.png"), "-o", str(tmp_path / "out.svg"), "--masks", str(folder)]
    for words, reason in (
        ([], "masks: 31x20 px, wanted the picture's 30x20 px"),
        (["--schedule", "1,2"], "masks: go without schedule"),
        ([str(tmp_path / "in.png")], "--masks: goes with one picture"),
        (["--masks", str(tmp_path / "nowhere")], "nowhere"),
    ):
        assert cli.main([*base, *words]) == 2
        said = capsys.readouterr().err
        assert reason in said and said.count("\n") == 1
    with pytest.raises(ValueError, match="masks: go without start"):
        Recipe(start=face(), masks=masks())
    assert not (tmp_path / "out.svg").exists()


def test_the_time_limit_is_that_of_the_whole() -> None:
    begin = time.monotonic()
    recipe = Recipe(options=Options(iterations=10_000, fills="solid", end_early=False), masks=masks())
    result = recipe.vectorize(render(face()), control=Control(time_limit=4.0))
    assert result.stopped == "time limit" and time.monotonic() - begin < 12
    assert {("head",), ("hat",)} <= set(result.drawing.groups)


def test_masks_are_part_of_the_fingerprint() -> None:
    assert Recipe().fingerprint != Recipe(masks=masks()).fingerprint
