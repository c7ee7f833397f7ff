# SPDX-License-Identifier: Apache-2.0
"""The slack of edges is measured on the picture: none of exact coverages, half a step of a renderer that samples."""

from __future__ import annotations

import numpy as np
import pytest
from support.line_art import DRAWINGS

from livecl import Drawing, Options, Rasterizer, render
from livecl.layering.context import Context
from livecl.layering.outlines.edges import edge_polylines
from livecl.layering.slack import MOST, edge_offset, edge_slack
from livecl.layering.strokes.line_work import edge_offset_of


def _disc(samples: int) -> np.ndarray:
    """Return the coverage (80, 80) of a disc, sampled `samples` x `samples` times a pixel."""
    y, x = (np.indices((80 * samples, 80 * samples)) + 0.5) / samples
    inside = np.hypot(x - 40.3, y - 39.8) < 28.7
    return inside.reshape(80, samples, 80, samples).mean(axis=(1, 3))


@pytest.mark.parametrize(("samples", "low", "high"), [(2, 0.15, 0.25), (4, 0.04, 0.1), (16, 0.0, 0.02)])
def test_the_offset_of_edges_is_about_half_a_step(samples: int, low: float, high: float) -> None:
    cover = _disc(samples)

    assert low <= edge_offset(edge_polylines(cover, cover)) <= high <= MOST


@pytest.mark.parametrize("name", ["house", "letter", "star", "flower"])
def test_exact_pictures_have_next_to_none(name: str) -> None:
    image = render(DRAWINGS[name])
    context = Context(Rasterizer(image.shape[:2]), image, Options(strokes="auto"))

    assert edge_offset_of(context, np.ones(3), 64) < 0.02


def test_slack_lies_at_edges_by_their_contrast() -> None:
    target = np.zeros((9, 9, 3))
    target[:, 5:] = (1.0, 0.5, 0.0)

    slack = edge_slack(target, 0.1)

    np.testing.assert_allclose(slack[4, 4], [0.1, 0.05, 0])
    assert not slack[:, :3].any() and not slack[:, 7:].any()
    assert not edge_slack(target, 0.0).any()


def test_errors_within_the_slack_have_no_price() -> None:
    class Uncertain(Context):
        @property
        def edge_offset(self) -> float:
            return 0.1

    def square(side: float) -> Drawing:
        corners = np.array([(10, 10), (side, 10), (side, 40), (10, 40)], dtype=float)
        steps = np.roll(corners, -1, axis=0) - corners
        rows = np.stack([corners, corners + steps / 3, corners + 2 * steps / 3], axis=1)
        return Drawing.from_outlines([[rows]], (0, 0, 0, 1), (50, 50))

    target = np.asarray(render(square(40)))
    exact, uncertain = (of(Rasterizer((50, 50)), target, Options()) for of in (Context, Uncertain))

    assert uncertain.priced_error(square(40.08)) == pytest.approx(0, abs=1e-6)
    assert exact.priced_error(square(40.08)) == pytest.approx(3 * 30 * 0.08**2, rel=0.01)
    assert uncertain.priced_error(square(40.5)) == pytest.approx(3 * 30 * 0.4**2, rel=0.01)
