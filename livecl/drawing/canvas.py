# SPDX-License-Identifier: Apache-2.0
"""Canvases of drawings."""

from __future__ import annotations

from collections.abc import Sequence

from livecl.drawing.drawing import Drawing


def check_canvases(drawings: Sequence[Drawing]) -> None:
    """Raise ValueError unless there are drawings, and all on canvases of one size."""
    if not drawings:
        raise ValueError("drawings: got none, wanted at least one")
    for index, drawing in enumerate(drawings):
        if drawing.size != drawings[0].size:
            raise ValueError(f"drawings: {index} has a canvas of {drawing.size} px, wanted {drawings[0].size} as 0 has")
