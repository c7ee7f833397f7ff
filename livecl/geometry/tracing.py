# SPDX-License-Identifier: Apache-2.0
"""Trace an outline as a person would draw it: an ellipse, or lines and curves between few anchors."""

from __future__ import annotations

import dataclasses

import numpy as np

from livecl.arrays import FloatArray
from livecl.geometry import cyclic
from livecl.geometry.bezier import signed_area
from livecl.geometry.corners import CorneredOutline, find_corners
from livecl.geometry.crossings import CROSSING_AREA, crossing_area, polygon_crossing_area
from livecl.geometry.ellipses import ellipses_of
from livecl.geometry.least_path import SegmentPrices
from livecl.geometry.refinement import STEPS, refined
from livecl.geometry.simplest import Draft, MeasuredOutline, simplest_path, without_anchors
from livecl.geometry.untangle import untangle


@dataclasses.dataclass(frozen=True, kw_only=True)
class TracingPrices:
    """Prices of a traced path."""

    #: A segment, in px^3: it is worth as much as this integral of the squared distance along the outline.
    segment: float = 0.05
    curve: float = 1.5  # a cubic, in prices of a straight segment
    #: A segment in a noisy picture, in variances of the points across the outline (px^2, at steps of 1 px): a cubic has
    #: six coordinates more, which fit noise of as many variances.
    noise: float = 12.0


TRACING_PRICES = TracingPrices()
#: Largest area, px^2, by which cutting out its loops may change a path that crosses itself; number of lower prices
#: tried where it is more, and their ratio.
MOST_LOST, TRIALS, CHEAPER = 3.0, 2, 4.0
#: Number of failed removals of anchors after which a path counts as simple; largest rise in price without an anchor, in
#: prices of a cubic, at which the removal is tried; and steps of the refinement of such a path.
MOST_FAILURES, MOST_RISE, TRIAL_STEPS = 3, 20.0, 3
#: Parameters of a cubic that joins the one before smoothly: anchor, direction, two handles' lengths.
CURVE_NUMBERS = 5


def traced_path(
    points: FloatArray, noise: float, prices: TracingPrices = TRACING_PRICES, waves: float = 0.0
) -> FloatArray:
    """Return the closed path (s, 3, 2) of the smallest price along a polyline (n, 2), px, at steps of about 1 px.

    If it crosses itself, small loops are cut out. Instead of cutting large ones, segments are made cheaper, so that the
    path follows both sides of a neck closely; if that fails, the path keeps them unless the polyline crosses itself.

    Parameters
    ----------
    points : (n, 2) float64
        Closed outline; the path has its direction.
    noise : float
        Standard deviation of the points across the outline, px.
    prices : TracingPrices
        Prices of segments.
    waves : float
        The same at long waves, which curves follow (:func:`noise_of` with a width), if larger; it sets the price.
    """
    outline = find_corners(points, noise)
    price = prices.segment + prices.noise * max(noise, waves) ** 2
    cubics = _cheapest(points, outline, SegmentPrices(line=price, curve=prices.curve * price))
    if crossing_area(cubics) <= CROSSING_AREA:
        return np.asarray(cubics[:, :3])
    untangled, simple = untangle([cubics])[0], polygon_crossing_area(points) <= CROSSING_AREA
    first, trials = cubics if simple else untangled, 0
    while abs(signed_area(untangled) - signed_area(cubics)) > MOST_LOST and trials < TRIALS and simple:
        price /= CHEAPER
        trials += 1
        cubics = _cheapest(points, outline, SegmentPrices(line=price, curve=prices.curve * price))
        untangled = untangle([cubics])[0]
    lost = abs(signed_area(untangled) - signed_area(cubics)) > MOST_LOST
    return np.asarray((first if lost else untangled)[:, :3])


def _cheapest(points: FloatArray, outline: CorneredOutline, prices: SegmentPrices) -> FloatArray:
    """Return the cubics (s, 4, 2) of the ellipse or the path that costs least."""
    ellipse, cubics = _best_ellipse(points, prices)
    if cubics is not None and ellipse <= 2 * prices.curve and not len(outline.corners):  # no loop of curves costs less
        return cubics
    measured = MeasuredOutline(outline)
    draft, path, price = _refined(measured, simplest_path(measured, prices), prices)
    vain: set[float] = set()
    while len(vain) < MOST_FAILURES:
        for place, rise, less in without_anchors(measured, draft, prices):
            if place in vain or rise > MOST_RISE * prices.curve:
                continue
            found = _refined(measured, less, prices, TRIAL_STEPS)
            if found[2] < price:
                draft, path, price = found
                break
            vain.add(place)
            if len(vain) >= MOST_FAILURES:
                break
        else:
            break
    if cubics is not None and (ellipse < price or (draft.straight.all() and len(path) < 3)):
        return cubics
    return path


def _refined(
    measured: MeasuredOutline, draft: Draft, prices: SegmentPrices, steps: int = STEPS
) -> tuple[Draft, FloatArray, float]:
    """Return a draft with the refined path, that path's cubics, and its price.

    A join becomes a corner if the error of the segments beside it exceeds a segment's price.
    """
    found = refined(measured, draft, steps)
    far = found.smooth & (found.errors + cyclic.preceding(found.errors) > prices.line)
    if far.any():
        bent = dataclasses.replace(draft, corners=draft.corners | far)
        again = refined(measured, bent, steps)
        if again.error + prices.line < found.error:
            draft, found = bent, again
    price = found.error + float(np.where(draft.straight, prices.line, prices.curve).sum())
    return dataclasses.replace(draft, cubics=found.cubics), found.cubics, price


def _best_ellipse(points: FloatArray, prices: SegmentPrices) -> tuple[float, FloatArray | None]:
    """Return the price and the cubics of the cheapest ellipse along an outline."""
    sizes = np.hypot(*(cyclic.following(points) - points).T)
    weights = (sizes + cyclic.preceding(sizes)) / 2
    best: tuple[float, FloatArray | None] = np.inf, None
    for ellipse in ellipses_of(points):
        error = float((weights * ellipse.distances(points) ** 2).sum())
        price = error + ellipse.numbers / CURVE_NUMBERS * prices.curve
        if price < best[0]:
            best = price, ellipse.cubics()
    return best
