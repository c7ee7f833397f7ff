# SPDX-License-Identifier: Apache-2.0
"""Fill rules: even-odd outlines become nonzero ones, or are named."""

from __future__ import annotations

import numpy as np
import pytest
from support.svg_documents import (
    SQUARE,
    assert_points,
    left_out,
    lines,
    read,
    read_path,
)

from livecl.geometry import bezier

RING = "M0 0H40V40H0z M10 10{}z"


@pytest.mark.parametrize(("inner", "layers_area"), [("H30V30H10", 1200), ("V30H30V10", 1200)])
def test_even_odd_rings_become_nonzero_rings(inner: str, layers_area: float) -> None:
    drawing = read(f'<path fill-rule="evenodd" d="{RING.format(inner)}"/>')
    assert drawing.subpath_offsets.tolist() == [0, 4, 8]
    assert abs(bezier.signed_area(drawing.cubics)) == pytest.approx(layers_area)
    nonzero = read(f'<path d="{RING.format(inner)}"/>')
    assert abs(bezier.signed_area(nonzero.cubics)) == pytest.approx(2000 if inner[0] == "H" else 1200)


def test_even_odd_islands_and_separate_shapes() -> None:
    island = read('<path fill-rule="evenodd" d="M0 0H50V50H0z M10 10H40V40H10z M20 20H30V30H20z"/>')
    assert abs(bezier.signed_area(island.cubics)) == pytest.approx(2500 - 900 + 100)
    apart = read('<path fill-rule="evenodd" d="M1 2h3v4h-3z m10 0v4h3v-4z"/>')
    assert_points(apart, SQUARE, lines((11, 2), (11, 6), (14, 6), (14, 2)))


@pytest.mark.parametrize("data", ["M0 0H40V40H0z M20 20H60V60H20z M10 30H50V50H10z", "M50 5L80 95L5 35H95L20 95z"])
def test_even_odd_of_crossing_outlines_is_named(data: str) -> None:
    drawing, names = left_out(f'<path style="fill-rule:evenodd" d="{data}"/>')
    assert names == "even-odd fills of crossing outlines (1)"
    np.testing.assert_array_equal(drawing.points, read_path(data).points)
