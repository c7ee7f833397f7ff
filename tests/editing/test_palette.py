# SPDX-License-Identifier: Apache-2.0
"""Colours of layers: nearest of a palette, few of least error, equal where nobody sees a difference."""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
import pytest

from livecl.cli.method import palette_text
from livecl.drawing import Drawing
from livecl.editing import with_few_colors
from livecl.editing.palette import clustered, nearest_colors, palette_of, without_twins
from livecl.layering.context import Context
from livecl.options import Options
from livecl.rendering.rasterizer import Rasterizer
from livecl.svg import quantize
from livecl.svg.primitives import rectangle

SIZE = (40, 60)


def bars(colors: list[tuple[float, float, float]], background: tuple[float, ...] | None = (1.0, 1.0, 1.0)) -> Drawing:
    shapes = [
        rectangle(np.array([2.0 + 8 * k, 3.0]), np.array([9.0 + 8 * k, 30.0 - 2 * k])) for k in range(len(colors))
    ]
    outlines = [[shape.points] for shape in shapes if shape is not None]
    return Drawing.from_outlines(outlines, [(*color, 1.0) for color in colors], SIZE, background)


def changed(drawing: Drawing, free: list[bool] | None = None, **options: object) -> Drawing:
    rasterizer = Rasterizer(SIZE)
    context = Context(rasterizer, rasterizer.forward(drawing), Options(**options))  # type: ignore[arg-type]
    return with_few_colors(context, drawing, np.array(free or [True] * drawing.num_layers))


SEVEN = [
    (0.9, 0.1, 0.1),
    (0.85, 0.2, 0.1),
    (0.1, 0.2, 0.8),
    (0.2, 0.1, 0.9),
    (0.1, 0.7, 0.2),
    (0, 0, 0),
    (0.95, 0.9, 1),
]


@pytest.mark.parametrize("count", range(1, 9))
def test_as_many_colors_as_asked_for_background_included(count: int) -> None:
    found = changed(bars(SEVEN), colors=count)
    written = np.unique(np.concatenate([found.colors[:, :3], [[1, 1, 1]]]), axis=0)
    assert len(written) == count
    np.testing.assert_array_equal(quantize(found).colors, found.colors)


def test_a_background_that_is_covered_everywhere_is_none_of_the_colors() -> None:
    drawing = bars(SEVEN)
    page = rectangle(np.array([0.0, 0.0]), np.array([float(SIZE[1]), float(SIZE[0])]))
    assert page is not None
    outlines = [[page.points], *([shape] for shape in np.split(drawing.points, drawing.segment_offsets[1:-1]))]
    covered = Drawing.from_outlines(outlines, np.concatenate([[(0.3, 0.4, 0.5, 1)], drawing.colors]), SIZE, (1, 1, 1))
    found = changed(covered, colors=4)
    assert len(np.unique(found.colors[:, :3], axis=0)) == 4
    assert not (found.colors[:, :3] == 1).all(axis=1).any()


def test_clusters_are_no_worse_than_the_best_split() -> None:
    """Of all splits of six weighted colours in two, three and four: within 15 % of the least squared error."""
    rng = np.random.default_rng(0)
    for count in (2, 3, 4):
        for _ in range(10):
            colors, weights = rng.random((6, 3)), rng.uniform(1, 9, 6)
            found = nearest_colors(colors, clustered(colors, weights, np.zeros((0, 3)), count))
            error = float((weights[:, None] * (found - colors) ** 2).sum())
            splits = np.arange(count**6)[:, None] // count ** np.arange(6) % count  # (P, 6): the cluster of each
            own = weights * (splits[:, None] == np.arange(count)[:, None])  # (P, count, 6)
            sums, heavy = own @ colors, np.maximum(own.sum(axis=2), 1e-12)
            # Within a cluster, sum w (c - mean)^2 = sum w c^2 - |sum w c|^2 / sum w.
            best = float((weights @ colors**2).sum() - (sums**2 / heavy[..., None]).sum(axis=(1, 2)).max())
            assert error < 1.15 * best + 0.02


def test_few_colours_are_those_of_least_error_in_the_picture() -> None:
    """Of all splits of five overlapping bars in two and three colours, each with its own best colours."""
    rng = np.random.default_rng(1)
    for count in (2, 3):
        for _ in range(6):
            drawing = bars([tuple(color) for color in rng.random((5, 3))], background=None)
            rasterizer = Rasterizer(SIZE)
            target = rasterizer.forward(drawing)
            context = Context(rasterizer, target, Options(colors=count))
            found = with_few_colors(context, drawing, np.ones(5, bool))
            areas = rasterizer.coverages(drawing).sum(axis=(1, 2))
            best = np.inf
            for code in range(count**5):
                own = (code // count ** np.arange(5)) % count
                colors = drawing.colors.copy()
                for k in np.unique(own):
                    colors[own == k, :3] = np.average(drawing.colors[own == k, :3], axis=0, weights=areas[own == k])
                best = min(best, context.visible_mse(drawing.replace(colors=colors)))
            assert context.visible_mse(found) <= best * 1.1 + 1e-5  # colours of 8 bits; a local minimum


def test_colours_answer_to_what_the_other_layers_leave() -> None:
    """A layer half hidden by a locked one of another colour, in a picture that is darker than the layer: what is seen
    of it has the picture's colour, not the layer's own."""
    drawing = bars([(0.8, 0.8, 0.8), (0.2, 0.2, 0.9)])
    rasterizer = Rasterizer(SIZE)
    target = rasterizer.forward(drawing.replace(colors=[(0.5, 0.3, 0.1, 1), (0.2, 0.2, 0.9, 1)]))
    found = with_few_colors(Context(rasterizer, target, Options(colors=3)), drawing, np.array([True, False]))
    np.testing.assert_allclose(found.colors[0, :3], [0.5, 0.3, 0.1], atol=0.5 / 255 + 1e-6)
    np.testing.assert_array_equal(found.colors[1], drawing.colors[1])


def test_palette_is_kept_to() -> None:
    found = changed(bars(SEVEN), palette="#e01010, navy,white")
    written = {tuple(color) for color in np.rint(found.colors[:, :3] * 255).astype(int).tolist()}
    assert written == {(0xE0, 0x10, 0x10), (0, 0, 0x80), (255, 255, 255)}
    np.testing.assert_allclose(palette_of("#010203,red"), [[1 / 255, 2 / 255, 3 / 255], [1, 0, 0]])


def test_colors_that_nobody_tells_apart_are_one_that_of_the_largest() -> None:
    near = [(0.5, 0.5, 0.5), (0.504, 0.5, 0.5), (0.5, 0.56, 0.5)]
    result = without_twins(np.array(near), np.array([1.0, 5.0, 9.0]))
    np.testing.assert_allclose(result[0], result[1])
    np.testing.assert_allclose(result[1], np.round(np.array(near[1]) * 255) / 255)
    assert np.abs(result[2] - result[1]).max() > 0.05
    assert len(np.unique(changed(bars(near)).colors, axis=0)) == 2
    assert len(np.unique(changed(bars(near), simplify=False).colors, axis=0)) == 3


def test_locked_layers_and_opacities_stay() -> None:
    drawing = bars(SEVEN[:3])
    drawing = drawing.replace(colors=drawing.colors * (1, 1, 1, 0.4))
    found = changed(drawing, [True, False, True], palette="white")
    np.testing.assert_array_equal(found.colors[1], drawing.colors[1])
    np.testing.assert_array_equal(found.colors[[0, 2]], [(1, 1, 1, 0.4)] * 2)


def test_files_of_palettes(tmp_path: Path) -> None:
    css, gimp, empty = tmp_path / "a.css", tmp_path / "a.gpl", tmp_path / "b.txt"
    css.write_text("--ink: #102030; --paper: #fff8e7;\n")
    gimp.write_text("GIMP Palette\nName: two\n#\n  1   2   3 ink\n255 255 255\tpaper\n")
    empty.write_text("nothing")
    assert palette_text(str(css)) == "#102030,#fff8e7"
    np.testing.assert_allclose(palette_of(palette_text(str(gimp))) * 255, [(1, 2, 3), (255, 255, 255)])
    assert palette_text("red,#123456") == "red,#123456"
    with pytest.raises(argparse.ArgumentTypeError, match="holds no colours"):
        palette_text(str(empty))
    with pytest.raises(ValueError, match=r"^palette: got 'blurple'"):
        Options(palette="red,blurple")
