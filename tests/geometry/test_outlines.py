# SPDX-License-Identifier: Apache-2.0
"""Outlines of new layers: circles, random ones, regions' borders, and paths fitted to them."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.ndimage import binary_fill_holes
from scipy.spatial import cKDTree
from skimage.measure import label, points_in_poly

from livecl.geometry.bezier import evaluate, signed_area
from livecl.geometry.fitting import PLACES, fit_outlines
from livecl.geometry.outlines import circle, random_outline
from livecl.layering.componentwise.masks import border

FloatArray = NDArray[np.float64]


def _cubics(path: FloatArray) -> FloatArray:
    return np.concatenate([path, np.roll(path[:, :1], -1, axis=0)], axis=1)


def _fitted(polyline: FloatArray, segments: int) -> FloatArray:
    return fit_outlines(polyline, segments)[-1]


def _points(path: FloatArray, steps: int = 65) -> FloatArray:
    return evaluate(_cubics(path), np.linspace(0, 1, steps)).reshape(-1, 2)


def _polygon_area(polyline: FloatArray) -> float:
    x, y = polyline.T
    return float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) / 2)


def _mask(*rows: str) -> NDArray[np.bool_]:
    return np.array([[letter == "#" for letter in row] for row in rows])


def _ellipse(count: int, a: float, b: float) -> FloatArray:
    angle = 2 * np.pi * np.arange(count) / count
    return np.stack([50 + a * np.cos(angle), 40 + b * np.sin(angle)], axis=1)


@pytest.mark.parametrize("segments", [1, 2, 3, 4, 9])
def test_circle_has_its_control_points_on_it(segments: int) -> None:
    path = circle((7.5, -3.25), 5.0, segments)
    assert path.shape == (segments, 3, 2)
    offsets = path.reshape(-1, 2) - (7.5, -3.25)
    np.testing.assert_allclose(np.hypot(*offsets.T), 5.0, rtol=1e-14)
    angles = np.unwrap(np.arctan2(offsets[:, 1], offsets[:, 0]))
    np.testing.assert_allclose(np.diff(angles), 2 * np.pi / (3 * segments), rtol=1e-12)


def test_random_outline_walks_from_the_center() -> None:
    size = (40, 200)
    path = random_outline((30.0, 20.0), 50, size, np.random.default_rng(0))
    assert path.shape == (50, 3, 2)
    assert path[0, 0].tolist() == [30.0, 20.0]
    steps = np.abs(np.diff(path.reshape(-1, 2), axis=0))
    largest = 0.025 * np.array([200, 40])
    assert np.all(steps <= largest)
    assert np.all(steps.max(axis=0) > 0.9 * largest)  # of 149 uniform steps, the largest is that near the limit
    again = random_outline((30.0, 20.0), 50, size, np.random.default_rng(0))
    other = random_outline((30.0, 20.0), 50, size, np.random.default_rng(1))
    assert np.array_equal(path, again) and not np.array_equal(path, other)


def test_border_of_one_pixel_surrounds_its_center() -> None:
    for size, pixel in [((1, 1), (0, 0)), ((5, 9), (3, 0)), ((5, 9), (4, 8))]:
        mask = np.zeros(size, dtype=bool)
        mask[pixel] = True
        polyline = border(mask)
        np.testing.assert_allclose(polyline.mean(axis=0), (pixel[1] + 0.5, pixel[0] + 0.5), atol=1e-12)
        np.testing.assert_allclose(np.abs(polyline - polyline.mean(axis=0)).sum(axis=1), 0.5, atol=1e-12)


# The border runs halfway between pixel centres inside and outside. On straight parts that is the pixels' border; a
# convex corner loses the triangle between the halves of two sides, 1/8 px^2, and a concave one gains it.
@pytest.mark.parametrize(
    ("mask", "area"),
    [
        (_mask("#"), 1 - 4 / 8),
        (_mask("....", ".##.", ".##.", "...."), 4 - 4 / 8),
        (_mask("#####", "#####", "#####"), 15 - 4 / 8),
        (_mask("##", "##", "#."), 5 - 5 / 8 + 1 / 8),
        (_mask("#####", "#...#", "#.#.#", "#...#", "#####"), 25 - 4 / 8),  # holes are filled with their content
        (_mask("......", ".####.", ".#..#.", ".####.", "......"), 12 - 4 / 8),
        (_mask(".##", "#.#", "###"), 8 - 5 / 8 + 1 / 8),  # a hole that meets the outside in a corner only
    ],
)
def test_border_has_the_region_s_area_less_its_corners(mask: NDArray[np.bool_], area: float) -> None:
    assert _polygon_area(border(mask)) == pytest.approx(area, rel=1e-12)


def test_border_turns_as_circles_do_and_separates_the_pixels() -> None:
    rng = np.random.default_rng(3)
    seen = 0
    for _ in range(12):
        labels = label(rng.uniform(size=(14, 17)) < 0.62, connectivity=1)
        for region in range(1, labels.max() + 1):
            mask = labels == region
            polyline = border(mask)
            assert _polygon_area(polyline) > 0
            assert signed_area(_cubics(circle((0, 0), 1, 4))) > 0
            assert not np.array_equal(polyline[0], polyline[-1])
            rows, columns = np.indices(mask.shape)
            centers = np.stack([columns.ravel(), rows.ravel()], axis=1) + 0.5
            assert np.array_equal(points_in_poly(centers, polyline), binary_fill_holes(mask).ravel())
            seen += 1
    assert seen > 50


@pytest.mark.parametrize("segments", [3, 4, 6, 8])
@pytest.mark.parametrize(("a", "b"), [(10.0, 10.0), (20.0, 16.0), (6.0, 9.0)])
def test_fit_follows_an_ellipse_within_the_cubic_s_remainder(a: float, b: float, segments: int) -> None:
    # A curve P of length s is met by the cubic through four evenly spaced points of a segment of length l to within
    # l^4 max|P''''| / 24 max|u (u - 1/3) (u - 2/3) (u - 1)|, and that last maximum is 1/81. Least squares
    # comes closer than this cubic in the mean, and with so smooth a curve everywhere. The polyline is off by the height
    # of its chords.
    dense = _ellipse(20000, a, b)
    length = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(dense, axis=0, append=dense[:1]).T))])
    angle = CubicSpline(length, 2 * np.pi * np.arange(20001) / 20000)(np.arange(256) / 256 * length[-1])
    curve = np.stack([a * np.cos(angle), b * np.sin(angle)], axis=1)
    frequency = 2j * np.pi * np.fft.fftfreq(256, length[-1] / 256)
    fourth = np.fft.ifft(np.fft.fft(curve, axis=0) * frequency[:, None] ** 4, axis=0).real
    remainder = (length[-1] / segments) ** 4 * np.hypot(*fourth.T).max() / 24 / 81
    chord = length[-1] / 256
    tolerance = remainder + chord**2 * max(a / b**2, b / a**2) / 8

    path = _fitted(_ellipse(256, a, b), segments)
    assert path.shape == (segments, 3, 2)
    distances, _ = cKDTree(dense).query(_points(path))
    assert distances.max() <= tolerance + np.pi * max(a, b) / 20000


def test_fit_follows_the_border_of_a_disc_within_half_a_pixel() -> None:
    # Each point of the border lies midway between a pixel centre within the disc and one without, 1 px apart, so the
    # circle passes it within 0.5 px; the fit averages over them, and adds a remainder of less than 0.02 px there.
    rows, columns = np.indices((40, 48)) + 0.5
    path = _fitted(border(np.hypot(columns - 23.2, rows - 19.6) < 14.3), 4)
    radii = np.hypot(*(_points(path) - (23.2, 19.6)).T)
    assert np.all(np.abs(radii - 14.3) <= 0.52)
    assert signed_area(_cubics(path)) == pytest.approx(np.pi * 14.3**2, rel=0.01)


@pytest.mark.parametrize("start", [0.0, 0.25, 0.5, 11 / 12])
def test_fit_finds_the_corners_of_a_square_wherever_the_polyline_starts(start: float) -> None:
    # Starts are tried at every twelfth of the first segment, so one of them is a corner and the sides are straight.
    corners = np.array([(3.0, 4.0), (27.0, 4.0), (27.0, 28.0), (3.0, 28.0)])
    first = corners[0] + start * (corners[1] - corners[0])
    polyline = np.concatenate([first[None], corners[1:], corners[:1]]) if start else corners
    path = _fitted(polyline, 4)
    assert cKDTree(path[:, 0]).query(corners)[0].max() < 1e-9
    assert signed_area(_cubics(path)) == pytest.approx(24**2, rel=1e-12)


def test_anchors_lie_on_the_polyline() -> None:
    path = _fitted(_ellipse(1000, 12.0, 12.0), 5)
    np.testing.assert_allclose(np.hypot(*(path[:, 0] - (50, 40)).T), 12, rtol=1e-4)


def test_anchors_go_to_corners_however_unevenly_they_lie() -> None:
    corners = np.array([(0.0, 0.0), (48.0, 0.0), (48.0, 6.0), (6.0, 6.0), (6.0, 42.0), (0.0, 42.0)])
    paths = fit_outlines(corners, 6)
    # An anchor takes one of the two places about a corner, which are the outline's length / PLACES apart.
    length = float(np.hypot(*(np.roll(corners, -1, axis=0) - corners).T).sum())
    assert cKDTree(paths[-1][:, 0]).query(corners)[0].max() <= length / PLACES
    assert signed_area(_cubics(paths[-1])) == pytest.approx(48 * 6 + 6 * 36, rel=0.02)
    assert [len(path) for path in paths] == [1, 2, 3, 4, 5, 6]


@pytest.mark.parametrize("segments", [1, 2, 4, 9])
def test_fit_of_the_smallest_region_stays_on_its_pixel(segments: int) -> None:
    path = _fitted(border(_mask("...", ".#.", "...")), segments)
    assert path.shape == (segments, 3, 2)
    assert np.all(np.abs(_points(path) - 1.5) <= 0.75)


def test_fit_keeps_the_direction_and_does_not_depend_on_the_place() -> None:
    polyline = border(_mask("..###..", ".#####.", "###.###", ".#####.", "...##.."))
    path = _fitted(polyline, 4)
    assert signed_area(_cubics(path)) > 0
    assert signed_area(_cubics(_fitted(polyline[::-1], 4))) < 0
    np.testing.assert_allclose(_fitted(polyline + np.array((100, -50)), 4), path + np.array((100, -50)), atol=1e-10)
