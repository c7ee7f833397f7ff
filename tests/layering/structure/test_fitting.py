# SPDX-License-Identifier: Apache-2.0
"""Paths fitted to the outlines of known shapes in anti-aliased pictures: few nodes, where a person puts them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from skimage.measure import points_in_poly
from support.found import flat_regions

from livecl.geometry.bezier import cross, evaluate, signed_area
from livecl.geometry.corners import noise_of
from livecl.geometry.crossings import CROSSING_AREA, crossing_area
from livecl.layering.outlines import contours
from livecl.layering.outlines.contours import Outlines
from livecl.layering.structure.layers import Layer
from livecl.layering.structure.placing import fitted_layer

FloatArray = NDArray[np.float64]
Shape = Callable[[FloatArray, FloatArray], NDArray[np.bool_]]

FINE = 16  # samples of a pixel's side, so that areas are right to 1/256 px^2
PAINT, GROUND = np.array((0.9, 0.2, 0.2)), np.ones(3)
CENTER = np.array((31.3, 32.8))


def rendered(shape: Shape, size: tuple[int, int] = (64, 64)) -> FloatArray:
    """A shape on white, at 8 bits, each pixel the mean of its samples."""
    rows, columns = np.indices((FINE * size[0], FINE * size[1]))
    inside = shape((columns + 0.5) / FINE, (rows + 0.5) / FINE)
    cover = inside.reshape(size[0], FINE, size[1], FINE).mean(axis=(1, 3))[..., None]
    image = cover * PAINT + (1 - cover) * GROUND
    return np.asarray(np.round(255 * image) / 255)


def outline_of(image: FloatArray) -> FloatArray:
    """The outer outline of the largest region of the paint."""
    outlines = Outlines(flat_regions(image))
    regions = outlines.regions
    painted = np.flatnonzero(np.abs(regions.colors - PAINT).max(axis=1) < 0.1)
    return outlines.outer(int(painted[np.argmax(regions.sizes[painted])])).points


def fitted(shape: Shape, size: tuple[int, int] = (64, 64)) -> FloatArray:
    """The cubics (s, 4, 2) fitted to a shape's outline; they do not cross themselves."""
    points = outline_of(rendered(shape, size))
    (path,) = fitted_layer(Layer([points], PAINT), noise_of([points]))
    cubics = np.concatenate([path, np.roll(path[:, :1], -1, axis=0)], axis=1)
    assert crossing_area(cubics) <= CROSSING_AREA
    return cubics


def samples(cubics: FloatArray) -> FloatArray:
    return evaluate(cubics, np.linspace(0, 1, 33)).reshape(-1, 2)


def straight(cubics: FloatArray) -> NDArray[np.bool_]:
    """Which segments are lines with their handles at a third and two thirds."""
    thirds = np.array([[2, 1], [1, 2]]) / 3 @ cubics[:, [0, 3]]
    return np.asarray(np.abs(cubics[:, 1:3] - thirds).max(axis=(1, 2)) < 1e-9)


def bends(cubics: FloatArray) -> FloatArray:
    """Angles between the handles at the beginning of each segment, radians."""
    out = cubics[:, 1] - cubics[:, 0]
    back = np.roll(cubics[:, 3] - cubics[:, 2], 1, axis=0)
    return np.asarray(np.abs(np.arctan2(cross(back, out), (back * out).sum(axis=1))))


def disc(radius: float) -> Shape:
    return lambda x, y: np.hypot(x - CENTER[0], y - CENTER[1]) < radius


def box(half: tuple[float, float], turn: float = 0.0, rounding: float = 0.0) -> Shape:
    """A rectangle of half sides, turned, with rounded corners."""

    def shape(x: FloatArray, y: FloatArray) -> NDArray[np.bool_]:
        u = np.abs((x - CENTER[0]) * np.cos(turn) + (y - CENTER[1]) * np.sin(turn)) - half[0] + rounding
        v = np.abs((y - CENTER[1]) * np.cos(turn) - (x - CENTER[0]) * np.sin(turn)) - half[1] + rounding
        if rounding == 0:
            return np.asarray((u < 0) & (v < 0))
        return np.asarray(np.hypot(np.maximum(u, 0), np.maximum(v, 0)) < rounding)

    return shape


def corners_of(half: tuple[float, float], turn: float) -> FloatArray:
    signs = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)])
    rotation = np.array([(np.cos(turn), np.sin(turn)), (-np.sin(turn), np.cos(turn))])
    return np.asarray(CENTER + signs * half @ rotation)


def polygon(corners: FloatArray) -> Shape:
    return lambda x, y: points_in_poly(np.stack([x.ravel(), y.ravel()], axis=1), corners).reshape(x.shape)


def star(points: int = 5, inner: float = 11.0, outer: float = 26.0) -> FloatArray:
    angles = np.arange(2 * points) * np.pi / points + 0.1
    radii = np.where(np.arange(2 * points) % 2, inner, outer)
    return np.asarray(CENTER + radii[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1))


@pytest.mark.parametrize(("radius", "inside"), [(5.0, 0.08), (12.0, 0.04), (25.0, 0.02)])
def test_outlines_are_known_to_hundredths_of_a_pixel(radius: float, inside: float) -> None:
    # Chords of 1 px between points at the middle of rows run inside the arc by up to (1 / 8 + 1 / 24) px^2 / radius,
    # and 8 bits add 1/255; interpolated between pixels' centres, edges are off by up to 0.09 px.
    distances = np.hypot(*(outline_of(rendered(disc(radius))) - CENTER).T) - radius
    assert np.sqrt(np.mean(distances**2)) < 0.2 / radius + 0.004
    assert np.abs(distances).max() < inside + 0.04


@pytest.mark.parametrize("radius", [5.0, 12.0, 25.0])
def test_a_circle_is_four_cubics(radius: float) -> None:
    cubics = fitted(disc(radius))
    assert len(cubics) == 4
    assert np.abs(np.hypot(*(samples(cubics) - CENTER).T) - radius).max() < 0.1
    away = cubics[:, 0] - CENTER
    assert np.abs(away).min(axis=1).max() < 0.2  # anchors at its extremes
    assert bends(cubics).max() < 1e-9


def test_a_turned_ellipse_is_four_cubics_from_the_ends_of_its_axes() -> None:
    def shape(x: FloatArray, y: FloatArray) -> NDArray[np.bool_]:
        u, v = (x - CENTER[0]) * 0.8 + (y - CENTER[1]) * 0.6, (y - CENTER[1]) * 0.8 - (x - CENTER[0]) * 0.6
        return np.asarray((u / 24) ** 2 + (v / 9) ** 2 < 1)

    cubics = fitted(shape)
    assert len(cubics) == 4
    ends = CENTER + np.array([(24 * 0.8, 24 * 0.6), (-9 * 0.6, 9 * 0.8)])
    assert cKDTree(cubics[:, 0]).query(ends)[0].max() < 0.2
    assert abs(signed_area(cubics)) == pytest.approx(np.pi * 24 * 9, rel=0.005)


@pytest.mark.parametrize("turn", [0.0, 0.1, 0.35, 0.7])
@pytest.mark.parametrize("half", [(18.3, 11.6), (26.0, 4.2)])
def test_a_rectangle_is_four_lines(half: tuple[float, float], turn: float) -> None:
    cubics = fitted(box(half, turn))
    assert len(cubics) == 4 and straight(cubics).all()
    assert cKDTree(cubics[:, 0]).query(corners_of(half, turn))[0].max() < 0.15


@pytest.mark.parametrize("rounding", [3.0, 4.0, 8.0])
def test_a_rounded_rectangle_is_four_lines_and_four_smooth_arcs(rounding: float) -> None:
    cubics = fitted(box((20.0, 15.0), 0.0, rounding))
    assert len(cubics) == 8 and straight(cubics).sum() == 4
    assert bends(cubics).max() < 1e-6
    away = np.abs(samples(cubics) - CENTER) - (20 - rounding, 15 - rounding)
    distance = np.hypot(*np.maximum(away, 0).T) + np.minimum(away.max(axis=1), 0) - rounding
    assert np.abs(distance).max() < 0.12


def test_a_star_has_straight_sides_and_sharp_corners() -> None:
    corners = star()
    cubics = fitted(polygon(corners))
    assert len(cubics) == 10 and straight(cubics).all()
    assert cKDTree(cubics[:, 0]).query(corners)[0].max() < 0.15


def test_a_rectangle_in_a_picture_of_24_by_37_pixels() -> None:
    cubics = fitted(lambda x, y: (np.abs(x - 12.3) < 7.4) & (np.abs(y - 17.6) < 11.2), (37, 24))
    assert len(cubics) == 4 and straight(cubics).all()
    wanted = np.array([(4.9, 6.4), (19.7, 6.4), (19.7, 28.8), (4.9, 28.8)])
    assert cKDTree(cubics[:, 0]).query(wanted)[0].max() < 0.1


def test_a_crescent_keeps_its_tips() -> None:
    cubics = fitted(lambda x, y: (np.hypot(x - 31, y - 32) < 22) & (np.hypot(x - 38, y - 32) > 20))
    assert 3 <= len(cubics) <= 5
    tips = np.array([(40.5, 32 - 19.84), (40.5, 32 + 19.84)])  # where the two circles meet
    distance, tip = cKDTree(cubics[:, 0]).query(tips)
    # The last 3 px of a tip are less than a pixel wide: its sides there are hardly seen.
    assert distance.max() < 1 and bends(cubics)[tip].min() > 2
    points = samples(cubics)
    off = np.minimum(np.abs(np.hypot(*(points - (31, 32)).T) - 22), np.abs(np.hypot(*(points - (38, 32)).T) - 20))
    assert off.max() < 0.3


def test_a_shape_that_touches_itself_does_not_cross_itself() -> None:
    # Two discs that touch, and a ring that is all but closed: two strands of the outline 0.6 px apart.
    two = fitted(lambda x, y: (np.hypot(x - 20, y - 32) < 11.6) | (np.hypot(x - 43, y - 32) < 11.6))
    assert abs(signed_area(two)) == pytest.approx(2 * np.pi * 11.6**2, rel=0.02)

    def ring(x: FloatArray, y: FloatArray) -> NDArray[np.bool_]:
        radius = np.hypot(x - 32, y - 32)
        return np.asarray((radius < 24) & (radius > 15) & ~((np.abs(y - 32) < 0.8) & (x > 32)))

    area = np.pi * (24**2 - 15**2) - 9 * 1.6
    assert abs(signed_area(fitted(ring))) == pytest.approx(area, rel=0.03)


@pytest.mark.parametrize(("shape", "segments"), [(disc(20.0), 4), (box((18.3, 11.6), 0.35), 4), (polygon(star()), 10)])
def test_noise_buys_no_segments(shape: Shape, segments: int) -> None:
    points = outline_of(rendered(shape))
    points = points + 0.06 * np.random.default_rng(1).normal(size=points.shape)
    (path,) = fitted_layer(Layer([points], PAINT), noise_of([points]))
    assert len(path) == segments


def test_loops_of_a_mixed_pixel_are_no_outlines(monkeypatch: pytest.MonkeyPatch) -> None:
    def polylines(soft: FloatArray, cover: FloatArray) -> list[FloatArray]:
        angles = 2 * np.pi * np.arange(12) / 12
        unit = np.stack([np.cos(angles), np.sin(angles)], axis=1)
        return [30 + radius * unit for radius in (12.0, 0.7, 1.0)]  # of 1.5 and 3 px^2 beside the largest

    regions = flat_regions(rendered(disc(12.0)))
    monkeypatch.setattr(contours, "edge_polylines", polylines)
    assert [round(abs(contour.area)) for contour in Outlines(regions).of((0,))] == [432, 3]
