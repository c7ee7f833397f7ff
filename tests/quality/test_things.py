# SPDX-License-Identifier: Apache-2.0
"""Things of layers: parts drawn alone, and how they are matched."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from support.drawings import build, rectangle

from livecl.drawing.fills import Fills
from livecl.quality import draw_things, score_drawing, score_things, things_of_drawing, things_sheet
from livecl.quality.things import match_things, things_of

RED, BLUE = (0.9, 0.1, 0.1), (0.1, 0.1, 0.9)


def masks(*boxes: tuple[int, int, int, int], size: int = 20) -> NDArray[np.float64]:
    """Return coverages of boxes (left, top, right, bottom): (N, size, 30)."""
    layers = np.zeros((len(boxes), size, 30))
    for layer, (left, top, right, bottom) in zip(layers, boxes, strict=True):
        layer[top:bottom, left:right] = 1
    return layers


def test_parts_of_a_layer_are_things_and_hidden_parts_count() -> None:
    layers = np.zeros((2, 20, 30))
    layers[0, 2:12, 2:12] = layers[0, 2:12, 20:28] = 1
    layers[1, 2:12, 7:15] = 1
    things = things_of(layers, np.array([RED, BLUE]))
    assert len(things) == 3 and sorted(things.layers.tolist()) == [0, 0, 1]
    assert sorted(things.masks.sum(axis=(1, 2)).tolist()) == [80, 80, 100]
    assert things.hidden.max() == pytest.approx(0.5) and np.count_nonzero(things.hidden) == 1


def test_things_of_another_color_or_place_do_not_match() -> None:
    layers = np.zeros((2, 20, 30))
    layers[0, 2:12, 2:12] = layers[1, 2:12, 16:26] = 1
    true = things_of(layers, np.array([RED, BLUE]))
    scores, partners = match_things(true, things_of(layers[:, :, ::1], np.array([RED, RED])))
    assert scores.tolist() == [1.0, 0.0] and partners.tolist() == [0, -1]


def test_scores_of_two_squares_and_what_covers_one() -> None:
    true = things_of(
        masks((2, 2, 12, 12), (8, 2, 18, 12), (20, 2, 26, 8)),  # the first: 4 of 10 columns lie beneath the second
        np.array([RED, BLUE, RED]),
    )
    drawn = things_of(
        masks((2, 2, 8, 12), (8, 2, 18, 12), (2, 15, 8, 19)),  # the visible part of the first, the second, one too many
        np.array([RED, BLUE, RED]),
    )
    scores = score_things(true, drawn)
    assert (scores.things, scores.drawn, scores.hidden) == (3, 3, 1)
    assert scores.overlap == pytest.approx((60 / 100 + 1 + 0) / 3)
    assert (scores.found, scores.hidden_overlap) == (1, pytest.approx(0.6))
    assert (scores.missed, scores.extra) == (1, 1)


def test_a_match_of_less_than_half_is_none() -> None:
    true, drawn = (things_of(masks(box), np.array([RED])) for box in ((2, 2, 12, 12), (2, 2, 12, 6)))
    scores = score_things(true, drawn)
    assert (scores.overlap, scores.found, scores.missed, scores.extra) == (pytest.approx(0.4), 0, 1, 1)
    none = things_of(np.zeros((0, 20, 30)), np.zeros((0, 4)))
    assert (score_things(true, none).missed, score_things(none, true).extra) == (1, 1)
    assert score_things(none, none).overlap == 0


def test_a_true_drawing_of_another_size_is_stretched() -> None:
    true = build([([rectangle(2, 2, 8, 8)], (*RED, 1.0))], (12, 16))
    twice = build([([rectangle(4, 4, 16, 16)], (*RED, 1.0))], (24, 32))
    assert score_drawing(true, twice).overlap == pytest.approx(1)
    assert score_drawing(true, twice.replace(colors=[(*BLUE, 1.0)])).missed == 1


def test_a_gradient_counts_by_its_mean_within_the_thing() -> None:
    # From black at x = 0 to red at x = 16: within columns 8 to 15 the mean red is that of their centres, .75.
    fills = Fills.linear((0, 4), (16, 4), [(0, 0, 0, 0.5), (1, 0, 0, 0.5)])
    drawing = build([([rectangle(8, 0, 16, 8)], (0.0, 0.0, 0.0, 1.0))], (8, 16)).replace(fills=fills)
    assert things_of_drawing(drawing).colors[0] == pytest.approx([0.75, 0, 0], abs=1e-6)


def test_picture_of_things_has_pairs_under_each_other_and_the_rest_at_the_end() -> None:
    side = things_sheet.CELL + things_sheet.MARGIN
    true = things_of(masks((0, 0, 10, 30), (14, 0, 30, 30), size=30), np.array([BLUE, RED]))
    drawn = things_of(masks((14, 0, 30, 30), (0, 20, 30, 30), size=30), np.array([RED, (0, 1, 0)]))
    pixels = np.asarray(draw_things(true, drawn, "title"), dtype=float) / 255
    top, left = things_sheet.LINE + things_sheet.MARGIN, things_sheet.MARGIN

    def cell(row: int, column: int, x: float, y: float) -> list[float]:
        inside = int(things_sheet.CELL * y), int(things_sheet.CELL * x)
        color: list[float] = pixels[top + row * side + inside[0], left + column * side + inside[1]].round(1).tolist()
        return color

    # The matched pair comes first, then the true blue one over nothing, then the green one under nothing.
    assert cell(0, 0, 0.8, 0.5) == cell(1, 0, 0.8, 0.5) == list(RED)
    assert cell(0, 1, 0.1, 0.5) == list(BLUE) and cell(1, 1, 0.1, 0.5) == [1, 1, 1]
    assert cell(0, 2, 0.5, 0.9) == [1, 1, 1] and cell(1, 2, 0.5, 0.9) == [0, 1, 0]

    grey = np.full((20, 30, 3), 0.5, np.float32)
    wider = draw_things(true, drawn, "title", [grey, grey])
    assert wider.width == draw_things(true, drawn, "title").width + side + 2 * things_sheet.MARGIN
    assert wider.getpixel((left + 9, top + side // 2)) == (128, 128, 128)
