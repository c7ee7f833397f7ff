# SPDX-License-Identifier: Apache-2.0
"""Regions of smoothly changing colour: cut where colour jumps, not where it drifts."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from support.shapes import rectangle

import livecl
from livecl.drawing import LINEAR, RADIAL, SOLID, Drawing, Fills
from livecl.drawing.fills import concatenate_fills
from livecl.geometry.outlines import circle
from livecl.layering.fills.ramps import LAYER_NUMBERS
from livecl.layering.segmentation.cores import straight
from livecl.layering.segmentation.smooth import SmoothRegions, smooth_regions
from livecl.rendering.rasterizer import Rasterizer

KINDS = ("linear", "radial")
#: A layer costs a pixel that is wrong in one channel.
PRICE = 1 / LAYER_NUMBERS
WARM, COOL = (0.9, 0.2, 0.1, 1.0), (0.1, 0.3, 0.8, 1.0)


def picture(drawing: Drawing, device: int) -> NDArray[np.float64]:
    """Return a drawing as a picture of 8 bits has it."""
    return np.round(livecl.render(drawing, device).astype(np.float64) * 255) / 255


def kinds_of(regions: SmoothRegions) -> list[int]:
    return [regions.paint(frozenset((k,))).kind for k in range(len(regions.sizes))]


def test_a_disc_on_a_ramp_is_two_regions(device: int) -> None:
    outlines = [[rectangle(0, 0, 96, 80)], [circle(np.array([50.0, 40.0]), 25.0, 4)]]
    fills = Fills(
        kinds=[LINEAR, RADIAL],
        geometry=[[(0, 0), (96, 40), (0, 0)], [(45, 35), (85, 35), (45, 75)]],
        stop_offsets=[0, 2, 4],
        stop_positions=[0, 1, 0, 1],
        stop_colors=[WARM, (0.9, 0.8, 0.1, 1), (0.6, 0.9, 0.9, 1), COOL],
    )
    drawing = Drawing.from_outlines(outlines, WARM, (80, 96), fills=fills)
    regions = smooth_regions(picture(drawing, device), PRICE, KINDS)
    assert sorted(kinds_of(regions)) == [LINEAR, RADIAL]
    area = float(Rasterizer(drawing.size, device).coverages(drawing)[1].sum())
    assert abs(int(regions.sizes.min()) - area) < 0.02 * area
    assert np.mean(regions.miss[regions.inner] < 3 / 255) > 0.99


def test_flat_colours_are_solid(device: int) -> None:
    outlines = [[rectangle(8, 8, 60, 50)], [circle(np.array([50.0, 40.0]), 18.0, 4)]]
    drawing = Drawing.from_outlines(outlines, [WARM, COOL], (80, 96))
    regions = smooth_regions(picture(drawing, device), PRICE, KINDS)
    assert kinds_of(regions) == [SOLID] * 3


def test_what_fades_into_its_ground_is_cut_from_it(device: int) -> None:
    fade = Fills.linear((10, 0), (90, 0), [COOL, (*COOL[:3], 0.0)])
    drawing = Drawing.from_outlines([[rectangle(10, 20, 90, 60)]], COOL, (80, 96), fills=fade)
    regions = smooth_regions(picture(drawing, device), PRICE, KINDS)
    assert sorted(kinds_of(regions)) == [SOLID, LINEAR]
    assert abs(int(regions.sizes.min()) - 80 * 40) < 0.1 * 80 * 40


def test_parts_of_one_ramp_are_alike_and_others_are_not(device: int) -> None:
    ramp = Fills.linear((0, 0), (96, 0), [WARM, COOL])
    parts = [rectangle(8, 8, 40, 30), rectangle(50, 8, 90, 30)]
    drawing = Drawing.from_outlines(
        [parts, [rectangle(8, 45, 90, 70)]], COOL, (80, 96), fills=ramp_and(ramp, COOL, WARM)
    )
    regions = smooth_regions(picture(drawing, device), PRICE, KINDS)
    left, right, turned = (int(regions.labels[row, column]) for row, column in ((20, 20), (20, 70), (60, 50)))
    assert regions.alike(left, right)
    assert not regions.alike(left, turned)
    assert not regions.alike(right, turned)


def test_two_flat_colours_have_no_ramp_between_them(device: int) -> None:
    """One ramp would show both, as no pixel lies between."""
    parts = [[rectangle(8, 8, 40, 60)], [rectangle(50, 8, 90, 60)], [rectangle(8, 66, 90, 76)]]
    ramp = concatenate_fills([Fills.solid(2), Fills.linear((0, 0), (96, 0), [WARM, COOL])])
    drawing = Drawing.from_outlines(parts, [WARM, COOL, WARM], (80, 96), fills=ramp)
    regions = smooth_regions(picture(drawing, device), PRICE, KINDS)
    left, right = (frozenset((int(regions.labels[30, column]),)) for column in (20, 70))
    assert regions.rise(left, right) == np.inf
    assert regions.rise(left, left) == 0


def test_a_ramp_goes_on_in_flat_colour_only_where_it_ends(device: int) -> None:
    """What lies beyond the last stop has its colour."""
    parts = [[rectangle(4, 8, 40, 30)], [rectangle(60, 8, 92, 30)], [rectangle(60, 45, 92, 70)]]
    ramp = Fills.linear((10, 0), (36, 0), [WARM, COOL])
    fills = concatenate_fills([ramp, Fills.solid(2)])
    drawing = Drawing.from_outlines(parts, [WARM, COOL, (0.9, 0.8, 0.1, 1.0)], (80, 96), fills=fills)
    regions = smooth_regions(picture(drawing, device), PRICE, KINDS)
    shaded, end, other = (
        frozenset((int(regions.labels[row, column]),)) for row, column in ((20, 20), (20, 76), (60, 76))
    )
    assert regions.rise(shaded, end) <= 0
    assert regions.rise(other, shaded) > 10


def ramp_and(ramp: Fills, start: tuple[float, ...], end: tuple[float, ...]) -> Fills:
    """Return a fill, and one that runs the other way."""
    return concatenate_fills([ramp, Fills.linear((0, 0), (96, 0), [start, end])])


def test_straight_colours_of_premultiplied_ones() -> None:
    pixels = np.array([[0.2, 0.1, 0.0, 0.5], [0.0, 0.0, 0.0, 0.0]])
    np.testing.assert_allclose(straight(pixels), [[0.4, 0.2, 0.0, 0.5], [0, 0, 0, 0]])
    np.testing.assert_allclose(straight(pixels[:, :3])[:, 3], 1)
