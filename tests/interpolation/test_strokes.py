# SPDX-License-Identifier: Apache-2.0
"""Strokes are neither interpolated nor animated: both refuse them by name instead of filling them."""

from __future__ import annotations

import pytest
from support.line_art import DRAWINGS

import livecl
from livecl.svg import format_animated_svg


def test_strokes_are_refused_by_name() -> None:
    stroked = DRAWINGS["star"]
    filled = stroked.replace(strokes=None)

    with pytest.raises(ValueError, match=r"^b: has stroked layers"):
        livecl.interpolate(filled, stroked, 0.5)
    with pytest.raises(ValueError, match=r"^drawings: 1 has stroked layers"):
        format_animated_svg([filled, stroked])
    livecl.interpolate(filled, filled, 0.5)
