# SPDX-License-Identifier: Apache-2.0
"""Lines of other kinds: pale ones, pens that change, dots on lines, lines beneath others, scans; and few pens."""

from __future__ import annotations

import numpy as np
import pytest
from support.found import find_strokes
from support.line_art import BLACK, BLUE, RED, SIZE, arc, drawing, line, match
from support.line_drawings import DRAWINGS, GRAY, disturbed

from livecl import Drawing, Options, Rasterizer, render, vectorize
from livecl.layering.context import Context
from livecl.layering.segmentation.paper import paper_of, without_shading
from livecl.layering.strokes.inks import inks_of
from livecl.layering.strokes.lines import find_lines, find_traces
from livecl.layering.strokes.pens import with_fewer_pens

WHITE = np.ones(3)


def _found(image: np.ndarray) -> Drawing:
    context = Context(Rasterizer(image.shape[:2]), image, Options(strokes="only"))
    return find_strokes(context, WHITE)


@pytest.mark.parametrize("name", DRAWINGS)
@pytest.mark.parametrize(
    "kind", ["clean", *(pytest.param(kind, marks=pytest.mark.slow) for kind in ("noise", "paper"))]
)
def test_lines_of_other_kinds_are_found_before_training(name: str, kind: str) -> None:
    true = DRAWINGS[name]

    result = match(_found(disturbed(render(true), kind)), true)

    assert result.distance < 0.5
    assert result.width < (0.25 if name == "music" else 0.1)  # in a thin pen's drawing no pixel is all ink
    assert result.nodes < 1.9


@pytest.mark.slow
@pytest.mark.parametrize("name", ["map", "bicycle", "floor plan"])
@pytest.mark.parametrize("kind", ["clean", "noise"])
def test_training_finds_lines_of_other_kinds(name: str, kind: str) -> None:
    true = DRAWINGS[name]

    drawn = vectorize(disturbed(render(true), kind), options=Options(strokes="only", background="#ffffff")).drawing

    result = match(drawn, true)
    assert result.distance < 0.2
    assert result.width < 0.05
    assert result.nodes <= 1.3


def test_pale_lines_beside_dark_ones_keep_their_width_and_colour() -> None:
    true = drawing((BLACK, 4, [line((20, 40), (140, 40))]), (GRAY, 1.8, [line((20, 80), (140, 100))]))

    found = _found(render(true))

    assert found.num_layers == 2
    np.testing.assert_allclose(sorted(found.strokes.widths), [1.8, 4], rtol=0.05)
    pale = found.colors[np.argmin(found.strokes.widths), :3]
    np.testing.assert_allclose(pale, GRAY, atol=0.1)


def test_a_line_ends_where_its_width_changes() -> None:
    true = drawing((BLACK, 9, [line((20, 80), (80, 80))]), (BLACK, 3, [line((80, 80), (140, 80))]), cap=0)

    found = _found(render(true))

    assert match(found, true).width < 0.1
    assert found.num_layers == 2


@pytest.mark.parametrize("width", [8, 14, 20])
def test_ends_lead_into_no_corner(width: float) -> None:
    """A circle in a corner of a straight end, of .8 of the radius, has its centre .2 radii off the axis."""
    start, end = np.array([30, 60]), np.array([130, 95])
    true = drawing((BLACK, width, [line((30, 60), (130, 95))]), cap=0)

    (trace,), _ = find_traces((1 - render(true)[..., 0].astype(np.float64)) / (1 - BLACK[0]))

    across = np.array([start[1] - end[1], end[0] - start[0]]) / np.hypot(*(end - start))
    assert np.abs((trace.points - start) @ across).max() < 0.1 * width + 0.5


@pytest.mark.parametrize("length", [16, 20, 30])
def test_compact_shapes_are_no_lines(length: int) -> None:
    true = drawing(((0, 0, 0), 16, [line((60, 80), (60 + length, 80))]), cap=0)

    assert all(found.is_spot for found in find_lines(1 - render(true)[..., 0].astype(np.float64)))


def test_dots_on_lines_are_dots() -> None:
    true = drawing(
        (BLACK, 3, [line((20, 80), (140, 80))]), (BLACK, 12, [line((60, 80), (60, 80)), line((98, 78), (102, 82))])
    )

    found = _found(render(true))

    result = match(found, true)
    assert result.distance < 0.5
    assert result.width < 0.1
    assert found.num_segments == true.num_segments


def test_crossings_are_no_dots() -> None:
    true = drawing((BLACK, 4, [line((20, 30), (140, 130)), line((20, 130), (140, 30))]))

    assert _found(render(true)).num_segments == true.num_segments


def test_a_line_beneath_another_is_one_line() -> None:
    true = drawing((RED, 5, [line((20, 30), (140, 130))]), (BLUE, 8, [line((80, 10), (80, 150)), arc(110, 105, 14)]))

    found = _found(render(true))

    assert found.num_layers == 2
    np.testing.assert_allclose(found.colors[0, :3], RED, atol=0.05)  # it lies below
    assert len(found.subpaths(0)) == 1
    assert match(found, true).distance < 0.3


def test_shaded_paper_is_of_one_colour() -> None:
    true = DRAWINGS["cat"]
    image = disturbed(render(true), "paper").astype(np.float64)

    flat = without_shading(image, paper_of(image))

    paper = render(true)[..., 0] > 0.99
    assert np.ptp(image[paper], axis=0).max() > 0.15
    assert flat[paper].std() < 0.02
    clean = render(true).astype(np.float64)
    assert without_shading(clean, paper_of(clean)) is clean


def test_thin_ink_has_the_colour_of_its_wide_lines() -> None:
    true = drawing(
        (BLACK, 1.4, [line((10, y + 0.5), (150, y)) for y in (20, 40, 60, 80, 100)]),
        (BLACK, 8, [line((20, 130), (90, 130))]),
    )
    image = render(true).astype(np.float64)

    (ink,) = inks_of(image, paper_of(image))

    np.testing.assert_allclose(ink.color, BLACK, atol=0.02)
    thin = [found for found in find_lines(ink.coverage) if found.width < 4]
    np.testing.assert_allclose([found.width for found in thin], 1.4, rtol=0.1)


def test_pens_alike_become_one_and_needless_lines_go() -> None:
    lines = [line((20, 40), (140, 40)), line((20, 80), (140, 90)), arc(80, 120, 20)]
    true = drawing((BLACK, 4, lines), (RED, 4, [line((20, 20), (140, 20))]))
    found = drawing(
        (BLACK, 4.05, lines[:1]),
        (RED, 4, [line((20, 20), (140, 20))]),
        ((0.1, 0.11, 0.1), 3.96, lines[1:]),
        (BLACK, 1.5, [line((60, 40), (64, 40))]),
    )
    context = Context(Rasterizer(SIZE), render(true), Options())

    fewer, sources = with_fewer_pens(context, found)

    assert fewer.num_layers == 2
    assert sorted(sources.tolist()) == [0, 1]
    assert fewer.num_segments == true.num_segments
    assert np.mean((render(fewer) - render(true)) ** 2) < 1e-5
    assert with_fewer_pens(context, true)[0] is true


def test_solid_shapes_beside_lines_are_no_line_art() -> None:
    """What lines leave of a shape is not explained; where only lines are wanted, it is left out."""
    true = drawing((BLACK, 4, [line((20, 20), (140, 20)), line((20, 140), (140, 140))]))
    image = render(true)
    rows, columns = np.indices(SIZE)
    image[(np.abs(rows - 80) < 22) & (np.abs(columns - 80) < 40)] = BLACK
    for strokes, count in (("auto", 0), ("only", 1)):
        context = Context(Rasterizer(SIZE), image, Options(strokes=strokes))  # type: ignore[arg-type]
        assert (find_strokes(context, WHITE).num_layers > 0) == bool(count)


@pytest.mark.parametrize("name", ["map", "cat", "circuit"])
def test_line_art_of_other_kinds_is_kept_where_fills_may_be(name: str) -> None:
    image = render(DRAWINGS[name])

    assert find_strokes(Context(Rasterizer(image.shape[:2]), image, Options(strokes="auto")), WHITE).num_layers > 0
