# SPDX-License-Identifier: Apache-2.0
"""Closed-form fits of fills: gradients are found again from pixels, of as few stops as there are, at their price."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from livecl.drawing import LINEAR, RADIAL, SOLID, Fills
from livecl.layering.fills.ramps import LAYER_NUMBERS, STOP_NUMBERS, Paint, fit_paint

WARM, COOL, DARK = (0.9, 0.2, 0.1, 1.0), (0.1, 0.3, 0.8, 1.0), (0.2, 0.1, 0.1, 1.0)
#: Price of a number where a layer costs a pixel that is wrong in one channel.
PRICE = 1 / LAYER_NUMBERS


def disc() -> NDArray[np.float64]:
    """Return the pixel centres of an ellipse of 110 x 70 px."""
    rows, columns = np.mgrid[:80, :120] + 0.5
    inside = (columns - 60) ** 2 / 55**2 + (rows - 40) ** 2 / 35**2 < 1
    return np.column_stack([columns[inside], rows[inside]])


def rounded(fills: Fills, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the colours of a gradient as 8 bits have them."""
    return np.round(fills.colors_at(0, points) * 255) / 255


def fit(fills: Fills, price: float = PRICE) -> tuple[Paint, float]:
    """Return the fit to a gradient's pixels, and its error for each pixel and channel, in levels squared."""
    points = disc()
    paint = fit_paint(points, rounded(fills, points), np.ones(len(points)), price)
    return paint, paint.error / len(points) / 3 * 255**2


@pytest.mark.parametrize(
    ("fills", "kind", "stops"),
    [
        (Fills.linear((4, 0), (130, 70), [WARM, COOL]), LINEAR, 2),
        (Fills.linear((0, 20), (120, 60), [WARM, COOL, DARK], [0, 0.4, 1]), LINEAR, 3),
        (Fills.radial((50, 35), (125, 35), (50, 110), [WARM, COOL]), RADIAL, 2),
        (Fills.radial((-20, -10), (130, -10), (-20, 140), [WARM, COOL]), RADIAL, 2),
        (Fills.radial((60, 40), (130, 75), (42, 76), [WARM, COOL]), RADIAL, 2),
    ],
    ids=["linear", "linear of three stops", "radial", "radial from outside", "elliptic"],
)
def test_gradients_are_found_again(fills: Fills, kind: int, stops: int) -> None:
    paint, error = fit(fills)
    assert paint.kind == kind
    assert len(paint.stops) in (stops, stops + 1)  # another one where the search ends a little beside the geometry
    # Rounding alone leaves 1/12; fits are not pursued below `NOISE`, a fifth, and a stop costs some error.
    assert error < 0.2 + STOP_NUMBERS * PRICE / len(disc()) / 3 * 255**2


def test_a_fill_of_one_colour_stays_one() -> None:
    points = disc()
    noise = np.random.default_rng(0).normal(0, 2 / 255, (len(points), 4))
    colors = np.broadcast_to(WARM, (len(points), 4)) + noise * (1, 1, 1, 0)
    paint = fit_paint(points, np.clip(colors, 0, 1), np.ones(len(points)), PRICE)
    assert paint.kind == SOLID
    np.testing.assert_allclose(paint.color, WARM, atol=5 * 2 / 255 / np.sqrt(len(points)))


def test_gradients_and_stops_are_taken_for_their_worth() -> None:
    fills = Fills.linear((4, 0), (130, 70), [WARM, COOL, WARM])
    assert len(fit(fills)[0].stops) == 3
    solid = fit(fills, price=1e9)[0]
    assert solid.kind == SOLID


@pytest.mark.parametrize(("share", "kind"), [(0.9, LINEAR), (1.1, SOLID)])
def test_a_gradient_is_taken_up_to_its_worth(share: float, kind: int) -> None:
    points = disc()
    colors = rounded(Fills.linear((4, 0), (130, 70), [WARM, COOL]), points)
    solid, linear = (fit_paint(points, colors, np.ones(len(points)), PRICE, kinds) for kinds in ((), ("linear",)))
    assert len(linear.stops) == 2
    worth = (solid.error - linear.error) / (linear.numbers - solid.numbers)
    assert fit_paint(points, colors, np.ones(len(points)), share * worth, ("linear",)).kind == kind


def test_other_kinds_are_left_out() -> None:
    points = disc()
    colors = rounded(Fills.radial((50, 35), (125, 35), (50, 110), [WARM, COOL]), points)
    kinds = [fit_paint(points, colors, np.ones(len(points)), PRICE, some).kind for some in ((), ("linear",))]
    assert kinds == [SOLID, LINEAR]


def test_degenerate_pixels_have_a_fill() -> None:
    for points in (np.array([[3.5, 4.5]]), np.column_stack([np.arange(30) + 0.5, np.full(30, 2.5)])):
        colors = np.column_stack([points[:, 0] / 40, *[points[:, 1] / 40] * 2, np.ones(len(points))])
        paint = fit_paint(points, colors, np.ones(len(points)), 0.0)
        assert np.isfinite(paint.error) and np.isfinite(paint.at(points)).all()
        assert paint.error < 1e-3 * len(points)


def test_level_lines_of_a_turned_ellipse_are_followed_from_its_middle_outwards() -> None:
    """Colours that rise with a quadratic form have ellipses of its axes as level lines, whatever their scale."""
    points, turn = disc(), np.deg2rad(30)
    axes = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    along = (points - (50, 30)) @ axes.T / (80, 40)
    level = np.square(along).sum(axis=1)[:, None]
    colors = np.array(WARM) + np.clip(level / 2, 0, 1) * (np.array(COOL) - np.array(WARM))
    paint = fit_paint(points, colors, np.ones(len(points)), PRICE)
    assert paint.kind == RADIAL
    center, *ends = paint.geometry
    np.testing.assert_allclose(center, (50, 30), atol=0.5)
    arms = np.array(ends) - center
    longer, shorter = arms[np.argsort(-np.linalg.norm(arms, axis=1))]
    assert np.linalg.norm(longer) / np.linalg.norm(shorter) == pytest.approx(2, rel=0.03)
    assert abs(longer @ axes[1]) < np.sin(np.deg2rad(2)) * np.linalg.norm(longer)


def test_a_radial_gradient_pays_for_its_further_numbers() -> None:
    """A ramp is a line's, though circles from far away bend less than the rounding of colours shows."""
    points = disc()
    colors = rounded(Fills.radial((-2000, 40), (2300, 40), (-2000, 4340), [WARM, COOL], [0.46, 0.5]), points)
    linear = fit_paint(points, colors, np.ones(len(points)), PRICE, ("linear",))
    radial = fit_paint(points, colors, np.ones(len(points)), 0.0, ("radial",))
    worth = (linear.error - radial.error) / (radial.numbers - linear.numbers)
    assert worth > 0
    assert fit_paint(points, colors, np.ones(len(points)), 2 * worth).kind == LINEAR
