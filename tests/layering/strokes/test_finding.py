# SPDX-License-Identifier: Apache-2.0
"""Line art becomes strokes: centre lines, widths and caps of known drawings; other pictures have none."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import ndimage
from support.found import find_strokes
from support.line_art import BLACK, DRAWINGS, arc, drawing, line, match

from livecl import Control, Drawing, Options, Rasterizer, render, vectorize
from livecl.layering.context import Context

WHITE = np.ones(3)


def _context(image: np.ndarray, strokes: str = "auto") -> Context:
    return Context(Rasterizer(image.shape[:2]), image, Options(strokes=strokes))  # type: ignore[arg-type]


def _noisy(image: np.ndarray, sigma: float) -> np.ndarray:
    noise = np.random.default_rng(0).normal(0, sigma / 255, image.shape)
    return np.clip(image + noise, 0, 1).astype(np.float32)


@pytest.mark.parametrize("name", DRAWINGS)
@pytest.mark.parametrize("sigma", [0, pytest.param(10, marks=pytest.mark.slow)])
def test_strokes_are_found_before_training(name: str, sigma: float) -> None:
    true = DRAWINGS[name]

    found = find_strokes(_context(_noisy(render(true), sigma)), WHITE)

    result = match(found, true)
    assert result.distance < 0.5
    assert result.width < 0.25  # training finds the rest
    assert result.nodes < 1.6


@pytest.mark.parametrize("name", ["star", "cup"])
def test_training_finds_lines_and_widths(name: str) -> None:
    true = DRAWINGS[name]

    result = vectorize(render(true), options=Options(strokes="only", background="#ffffff"))

    found = match(result.drawing, true)
    assert found.distance < 0.2
    assert found.width < 0.01
    assert result.mse < 1e-4
    assert result.drawing.strokes.widths.all()


def test_colours_are_the_inks() -> None:
    found = find_strokes(_context(render(DRAWINGS["waves"])), WHITE)

    colors = {tuple(color) for color in np.round(found.colors[:, :3], 2).tolist()}
    assert colors == {(0.1, 0.1, 0.1), (0.1, 0.25, 0.75), (0.8, 0.15, 0.1)}


def test_filled_pictures_have_no_strokes() -> None:
    disc = np.ones((64, 64, 3), np.float32)
    y, x = np.indices((64, 64))
    disc[np.hypot(x - 32, y - 32) < 20] = (0.8, 0.1, 0.1)

    assert find_strokes(_context(disc), WHITE).num_layers == 0
    assert find_strokes(_context(np.ones((32, 32, 3), np.float32)), WHITE).num_layers == 0


def test_paper_of_another_colour_than_the_ground_is_no_line_art() -> None:
    image = render(DRAWINGS["star"].replace(background=(0.5, 0.8, 0.5)))

    assert find_strokes(_context(image), WHITE).num_layers == 0
    assert find_strokes(_context(image), np.array([0.5, 0.8, 0.5])).num_layers == 1


@pytest.mark.parametrize("fills", ["solid", "auto"])
def test_runs_end_where_strokes_leave_nothing_to_fill(fills: str) -> None:
    """Once no path is worth placing, all stages are behind the run, those that draw strokes among them."""
    true = DRAWINGS["star"]
    names: list[str] = []
    options = Options(strokes="auto", fills=fills, background="#ffffff", iterations=60)  # type: ignore[arg-type]

    result = vectorize(
        render(true),
        schedule=[1, 1],
        options=options,
        on_step=lambda step: names.append(step.name),
        control=Control(time_limit=60),
    )

    assert result.stopped is None
    assert (result.drawing.strokes.widths > 0).tolist() == [True]
    assert set(names) == {"stage 1/4", "stage 2/4"}  # lines, and lines drawn anew


def _found(true: Drawing, strokes: str = "auto") -> Drawing:
    return find_strokes(_context(render(true), strokes), WHITE)


def test_dots_are_lines_without_length() -> None:
    true = drawing((BLACK, 6, [line((20, 40), (140, 40)), line((50, 100), (50, 100)), line((90, 100), (94, 104))]))

    found = _found(true)

    assert match(found, true).distance < 0.3
    assert found.num_segments == true.num_segments
    assert np.mean((render(found) - render(true)) ** 2) < 9e-4  # less than one dot of 28 px left out


def test_dots_alone_are_strokes_where_nothing_else_is_wanted() -> None:
    dots = drawing((BLACK, 20, [line((40, 80), (40, 80)), line((80, 80), (80, 80)), line((120, 80), (120, 80))]))

    assert _found(dots).num_layers == 0
    assert len(_found(dots, "only").subpaths()) == 3


def test_large_discs_beside_lines_are_no_dots() -> None:
    true = drawing(
        (BLACK, 4, [line((10, 20), (150, 20)), line((10, 35), (150, 35))]), (BLACK, 30, [line((80, 90), (80, 90))])
    )

    assert match(_found(true, "only"), true).distance < 0.3
    assert all(width < 10 for width in _found(true).strokes.widths)


def test_short_branches_are_lines() -> None:
    """An arrow whose head's strokes are two widths long, all ending in one place."""
    true = drawing((BLACK, 12, [line((20, 80), (130, 80)), line((104, 54), (130, 80), (104, 106))]))

    found = _found(true)

    assert match(found, true).distance < 0.8
    assert len(found.subpaths()) >= 2


def test_loops_with_a_stem_are_ellipses() -> None:
    true = drawing((BLACK, 8, [arc(60, 80, 24), line((84, 80), (150, 80))]))

    found = _found(true)

    closed = ~found.strokes.is_open
    assert closed.tolist().count(True) == 1
    loop = found.subpaths()[int(np.flatnonzero(closed)[0])]
    assert loop.stop - loop.start == 4
    np.testing.assert_allclose(found.points[loop, 0].mean(axis=0), (60, 80), atol=0.3)


def test_lines_that_touch_the_border_are_whole() -> None:
    true = drawing((BLACK, 12, [line((100, 60), (154, 114)), line((154, 60), (100, 114))]))

    assert match(_found(true), true).distance < 0.5


@pytest.mark.parametrize("name", ["house", "cup"])
def test_redrawing_saves_nodes(name: str) -> None:
    true = DRAWINGS[name]

    result = vectorize(render(true), options=Options(strokes="only", background="#ffffff"))

    nodes = match(result.drawing, true).nodes
    assert nodes <= 1.3
    assert nodes < match(result.stages[0].drawing, true).nodes


def _scanned(true: Drawing) -> np.ndarray:
    """Return a drawing as a scan: paper with texture (5/255, over some pixels), light off by 12 %, noise of 3/255."""
    rows, columns = np.indices(true.size)
    light = 0.97 - 0.12 * (rows + columns)[..., None] / sum(true.size)
    texture = ndimage.gaussian_filter(np.random.default_rng(1).normal(0, 1, true.size), 1.5)[..., None]
    return _noisy(render(true) * light + 5 / 255 * texture / texture.std(), 3)


def test_a_scan_in_auto_is_strokes_and_one_sheet() -> None:
    """Nothing is added for light, texture and noise: the paper is one rectangle, that no pixel moves."""
    size = (72, 72)
    true = drawing((BLACK, 4, [line((12, 14), (60, 22)), line((14, 58), (36, 34), (58, 58))]), size=size)

    result = vectorize(_scanned(true), options=Options(strokes="auto", background="#ffffff", iterations=20))

    stroked = result.drawing.strokes.widths > 0
    assert stroked.tolist() == [False, True]  # the sheet lies below
    assert result.drawing.segment_offsets[1] == 4
    np.testing.assert_allclose(Rasterizer(size).coverages(result.drawing)[0], 1, atol=1e-6)
    found = match(result.drawing.layer_subset(stroked), true)
    assert found.distance < 0.2
    assert found.width < 0.05
    assert found.nodes <= 1.3
