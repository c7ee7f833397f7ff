# SPDX-License-Identifier: Apache-2.0
"""Groups by containment: what lies inside what, in an order that paints the same picture."""

from __future__ import annotations

import numpy as np
import pytest
from support import drawings, shapes

from livecl.drawing import Drawing, Strokes, empty_drawing
from livecl.drawing.borders import border_pairs
from livecl.layering.groups import MOST, containment, grouped
from livecl.rendering import Rasterizer, render

YELLOW, BROWN, RED, WHITE = (1, 0.8, 0.1, 1), (0.3, 0.15, 0.05, 1), (1, 0, 0, 1), (1, 1, 1, 1)


def disc(x: float, y: float, radius: float, color: tuple[float, ...]) -> tuple[list[np.ndarray], tuple[float, ...]]:
    return [shapes.circle((x, y), radius)], color


def in_groups(drawing: Drawing) -> Drawing:
    return grouped(drawing, Rasterizer(drawing.size).coverages(drawing))


def test_what_lies_inside_forms_a_group_and_the_picture_stays() -> None:
    """Two heads, then both heads' eyes: the first head's eyes move below the second head, which they do not touch."""
    layers = [disc(30, 45, 20, YELLOW), disc(90, 45, 20, RED), disc(24, 45, 5, BROWN), disc(96, 45, 5, BROWN)]
    layers += [disc(24, 45, 2, WHITE), disc(60, 80, 5, BROWN)]
    drawing = drawings.build(layers, (100, 120))
    result = in_groups(drawing)
    head, other = "yellow circle left group", "red circle right group"
    assert result.groups == (
        (head,),
        (head, "dark brown circle left group"),
        (head, "dark brown circle left group"),
        (other,),
        (other,),
        (),
    )
    assert result.labels[2] == "white circle left"
    np.testing.assert_array_equal(render(result), render(drawing))
    assert in_groups(result) is result


def test_a_layer_that_something_else_covers_on_the_way_stays_outside() -> None:
    """The last disc lies inside the first one, but on a bar that reaches out of it: moved below the bar it would be
    hidden."""
    bar = ([drawings.rectangle(5, 25, 95, 35)], RED)
    drawing = drawings.build([disc(50, 30, 20, YELLOW), bar, disc(50, 30, 3, BROWN)], (60, 100))
    coverages = Rasterizer(drawing.size).coverages(drawing)
    parents, order = containment(coverages, np.ones(3, bool))
    assert order == [0, 1, 2] and parents == [-1, -1, 1]
    np.testing.assert_array_equal(render(in_groups(drawing)), render(drawing))


def test_what_joins_a_group_late_comes_after_all_that_lies_in_it() -> None:
    """A disc in a disc in a disc, then another in the outermost, which may not part the two inner ones."""
    layers = [disc(40, 30, 24, YELLOW), disc(32, 30, 9, BROWN), disc(32, 30, 4, WHITE), disc(80, 30, 5, BROWN)]
    drawing = drawings.build([*layers, disc(54, 30, 4, RED)], (60, 100))
    parents, order = containment(Rasterizer(drawing.size).coverages(drawing), np.ones(5, bool))
    assert parents == [-1, 0, 1, -1, 0] and order == [0, 1, 2, 4, 3]


def test_grounds_and_lines_hold_nothing() -> None:
    ground = ([drawings.rectangle(0, 0, 60, 60)], YELLOW)
    assert not any(in_groups(drawings.build([ground, disc(30, 30, 9, RED)], (60, 60))).groups)
    coverages = Rasterizer((60, 60)).coverages(
        drawings.build([disc(30, 30, 20, RED), disc(30, 30, 9, WHITE)], (60, 60))
    )
    assert containment(coverages, np.array([False, True]))[0] == [-1, -1]
    assert containment(coverages, np.array([True, True]))[0] == [-1, 0]


@pytest.mark.parametrize("seed", range(6))
def test_any_drawing_paints_the_same_picture_in_its_groups(seed: int) -> None:
    rng = np.random.default_rng(seed)
    layers = [disc(*rng.uniform(0, 60, 2), rng.uniform(1, 25), (*rng.random(3), 0.7)) for _ in range(30)]
    drawing = drawings.build(layers, (60, 60))
    result = in_groups(drawing)
    assert any(result.groups) and sorted(result.colors.tolist()) == sorted(drawing.colors.tolist())
    np.testing.assert_allclose(render(result), render(drawing), atol=2 / 512)  # of layers that touch by less
    firsts = [path for k, path in enumerate(result.groups) if k == 0 or path != result.groups[k - 1]]
    runs = [path[:1] for k, path in enumerate(firsts) if k == 0 or path[:1] != firsts[k - 1][:1]]
    named = [path for path in runs if path]
    assert len(named) == len(set(named))  # each group is one run of layers


def test_many_layers_and_own_groups_stay() -> None:
    drawing = drawings.build((MOST + 1) * [disc(5, 5, 3, RED)], (10, 10))
    assert grouped(drawing, np.zeros((MOST + 1, 1, 1))) is drawing
    assert grouped(empty_drawing((9, 9)), np.zeros((0, 1, 1))).num_layers == 0


def test_a_fill_and_its_stroke_stay_together_around_what_lies_in_them() -> None:
    """A disc with an outline, beside it a plain one, then an eye in the first, which moves above its outline."""
    layers = [disc(30, 45, 20, YELLOW), disc(30, 45, 20, BROWN), disc(90, 45, 20, RED), disc(24, 45, 5, BROWN)]
    strokes = Strokes(widths=[0, 4, 0, 0], is_open=np.zeros(4, bool))
    drawing = drawings.build(layers, (100, 120)).replace(strokes=strokes)

    result = in_groups(drawing)

    head = "yellow circle left group"
    assert result.groups == ((head,), (head,), (head,), ())
    assert border_pairs(result).tolist() == [[0, 1]]
    np.testing.assert_array_equal(render(result), render(drawing))
