# SPDX-License-Identifier: Apache-2.0
"""Centre line scores: distances, widths and nodes of strokes that are known to be off."""

from __future__ import annotations

import numpy as np
import pytest
from support.line_art import BLACK, drawing, line

from livecl import quality


def test_lines_off_by_a_known_distance_and_width() -> None:
    true = drawing((BLACK, 4, [line((20, 40), (140, 40))]))
    found = drawing((BLACK, 5, [line((20, 41), (80, 41), (140, 41))]))

    scores = quality.score_lines(true, found)

    assert scores.line_distance == pytest.approx(1, abs=0.05)
    assert scores.line_width_off == pytest.approx(0.25)
    assert scores.line_nodes == 1.5  # the end of an open line is a node


def test_drawings_without_strokes_have_no_distance() -> None:
    true = drawing((BLACK, 4, [line((20, 40), (140, 40))]))

    scores = quality.score_lines(true, true.layer_subset(np.zeros(0, np.int64)))

    assert scores.line_distance is None
    assert scores.line_width_off is None
