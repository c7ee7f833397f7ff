# SPDX-License-Identifier: Apache-2.0
"""Pairs of a fill and a stroke of one outline are seen in the drawing; all else is two layers."""

from __future__ import annotations

import numpy as np
import pytest
from support.line_art import polygon

from livecl.drawing import Drawing, Strokes
from livecl.drawing.borders import border_pairs, paired_rows
from livecl.svg import format_svg, read_svg

SQUARE = polygon((10, 10), (30, 10), (30, 30), (10, 30))[0]
TRIANGLE = polygon((40, 10), (60, 10), (50, 30))[0]


def _drawing(*layers: tuple[np.ndarray, float], is_open: bool = False) -> Drawing:
    return Drawing.from_outlines(
        [[rows] for rows, _ in layers],
        [[0.5, 0.2, 0.1, 1]] * len(layers),
        (64, 64),
        strokes=Strokes(
            widths=[width for _, width in layers], is_open=np.array([is_open and width > 0 for _, width in layers])
        ),
    )


def test_a_stroke_lies_above_its_fill_or_beneath_it() -> None:
    drawing = _drawing((SQUARE, 0), (SQUARE, 3), (TRIANGLE, 2), (TRIANGLE, 0))

    pairs = border_pairs(drawing)

    assert pairs.tolist() == [[0, 1], [3, 2]]
    fills, strokes = paired_rows(drawing, pairs)
    assert fills.tolist() == [0, 1, 2, 3, 11, 12, 13]
    assert strokes.tolist() == [4, 5, 6, 7, 8, 9, 10]


def test_a_layer_is_of_one_pair() -> None:
    assert border_pairs(_drawing((SQUARE, 0), (SQUARE, 3), (SQUARE, 0))).tolist() == [[0, 1]]
    assert border_pairs(_drawing((SQUARE, 3), (SQUARE, 0), (SQUARE, 3))).tolist() == [[1, 0]]


@pytest.mark.parametrize(
    "drawing",
    [
        _drawing((SQUARE, 0), (SQUARE, 0)),
        _drawing((SQUARE, 2), (SQUARE, 3)),
        _drawing((SQUARE, 0), (SQUARE + 0.001, 3)),
        _drawing((SQUARE, 0), (TRIANGLE, 0), (SQUARE, 3)),
        _drawing((SQUARE, 0), (SQUARE, 3), is_open=True),
        _drawing((SQUARE, 0), (SQUARE, 3)).replace(colors=[[1, 0, 0, 1], [0, 0, 1, 0]]),
        _drawing((SQUARE, 0), (SQUARE, 3)).replace(names=["a", "b"]),
        _drawing((SQUARE, 0), (SQUARE, 3)).replace(stages=[0, 1]),
        _drawing((SQUARE, 0), (SQUARE, 3)).replace(groups=[("a",), ()]),
    ],
)
def test_other_layers_are_no_pairs(drawing: Drawing) -> None:
    assert len(border_pairs(drawing)) == 0


def test_both_layers_have_the_label_that_is_written() -> None:
    drawing = _drawing((SQUARE, 0), (SQUARE, 3), (TRIANGLE, 0))
    drawing = drawing.replace(colors=[[1, 0, 0, 1], [0, 0, 1, 1], [0, 0, 1, 1]])

    fill, stroke, other = drawing.labels

    assert fill == stroke != other
    assert read_svg(format_svg(drawing).encode()).labels == drawing.labels
