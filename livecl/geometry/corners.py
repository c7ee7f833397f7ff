# SPDX-License-Identifier: Apache-2.0
"""Corner detection on closed polylines traced from pixels, with points about 1 px apart.

An outline traced from coverages cuts corners: within about a pixel of one, it runs across it. So the directions before
and after a point are fitted to points farther away ("arms"); where they differ is a corner, and it lies where the two
arms meet.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from livecl.arrays import ComplexArray, FloatArray, IntArray
from livecl.geometry import cyclic

#: Arms, in order of preference: the first point after the corner, the number of points, and the degree of the
#: polynomial fitted to them.
ARMS = ((2, 8, 1), (2, 8, 2), (2, 5, 1), (2, 3, 1), (1, 3, 1), (1, 2, 1))
#: Least bend of a corner, radians; least bend as a multiple of its standard error; length of short arms, in points, and
#: the least bend between these: circles down to a radius of 2.5 px bend less.
LEAST_BEND, LEAST_RATIO, SHORT_REACH, LEAST_SHORT_BEND = 0.5, 4.0, 5, 1.2
#: Largest root mean square distance, px, of an arm from points without noise, by its degree: less for parabolas, which
#: could follow the end of a line and the beginning of an arc.
ARM_MISS = {1: 0.04, 2: 0.02}
#: Largest distance, px, of the traced outline from a corner: for each unit of the tangent of half the bend (0.3 to 0.75
#: at right angles; corners rounded at a radius of 2 px have 0.88 and more), and for any corner.
CUT_OFF, MOST_CUT_OFF = 0.75, 3.0
#: Penalty of an arm, px, divided by its number of points: of two arms that fit equally well the longer is more precise.
SHORTNESS = 0.1
#: Median of the size of a standard normal variable.
MEDIAN_SIZE = 0.6745
#: Third difference, px, up to which points are on one line.
EXACT = 1e-3
#: Third difference, px, from which points are a corner: noise as large has a deviation of .13 px.
CORNERED = 0.6
#: Distance, px, from a corner up to which points of the outline are left out.
CUT = 1.25


@dataclasses.dataclass(frozen=True, eq=False)
class CorneredOutline:
    """A closed polyline with its corners."""

    points: FloatArray  # (n, 2), (x, y) px; corners are points of it
    corners: IntArray  # (k,), which points are corners, ascending


@dataclasses.dataclass(frozen=True, eq=False)
class _Arms:
    """Arms of all points of an outline in one direction of travel.

    A point and a unit direction, its standard error; the distance of the fit, and its last point.
    """

    at: ComplexArray
    way: ComplexArray
    error: FloatArray
    miss: FloatArray
    reach: IntArray


def find_corners(points: FloatArray, noise: float) -> CorneredOutline:
    """Return a closed polyline with corners where its sides meet, in place of the points next to them.

    Parameters
    ----------
    points : (n, 2) float64
        (x, y) px, about 1 px apart.
    noise : float
        Standard deviation of the points across the outline, px, see :func:`noise_of`.
    """
    z = points[:, 0] + 1j * points[:, 1]
    count = len(z)
    if count < 8:
        return CorneredOutline(points, np.zeros(0, np.int64))
    ahead, behind = _arms(z, noise), _arms(z[::-1], noise)
    back, back_at, back_error = behind.way[::-1], behind.at[::-1], behind.error[::-1]
    bends = np.abs(np.angle(-ahead.way / back))
    error = np.hypot(ahead.error, back_error)
    # Where the two lines meet: back_at + a * back = ahead.at + b * ahead.way.
    determinant = (back.conj() * ahead.way).imag
    gap = ahead.at - back_at
    meet = back_at + back * (gap.conj() * ahead.way).imag / np.where(np.abs(determinant) < 0.05, np.inf, determinant)
    reach = np.minimum(ahead.reach, behind.reach[::-1])
    sharp = (
        (bends > np.where(reach > SHORT_REACH, LEAST_BEND, LEAST_SHORT_BEND))
        & (bends > LEAST_RATIO * error)
        & (np.abs(determinant) > 0.05)
    )
    away = np.abs(meet - z)
    before, after = _distance(meet, cyclic.preceding(z), z), _distance(meet, z, cyclic.following(z))
    sharp &= np.minimum(before, after) < np.minimum(CUT_OFF * np.tan(bends / 2) + 2 * noise, MOST_CUT_OFF)
    # Of the points whose arms meet at one corner, the one that fits best is kept; no arm extends across a corner.
    misses = ahead.miss + behind.miss[::-1]
    score = np.where(sharp, -misses / max(ARM_MISS[1], 3 * noise) - error - away, -np.inf)
    order = np.argsort(-score, kind="stable")
    chosen: list[int] = []
    reach_back = behind.reach[::-1]
    for i in order[: int(sharp.sum())]:
        others = np.array(chosen, np.int64)
        ahead_of, behind_of = (others - i) % count, (i - others) % count
        if not ((ahead_of < max(3, ahead.reach[i])) | (behind_of < max(3, reach_back[i]))).any():
            chosen.append(int(i))
    return _with_corners(z, np.array(sorted(chosen), np.int64), meet)


def noise_of(polylines: Sequence[FloatArray], width: int = 1) -> float:
    """Return the standard deviation of the points of closed polylines (n, 2) across them, px.

    From the median of third differences, which neither corners nor bends change much.

    Parameters
    ----------
    polylines : sequence of (n, 2) float64
        Closed, points about 1 px apart.
    width : int
        Number of neighbours averaged first. For uncorrelated noise the result does not depend on it: means deviate less
        by its square root, which is multiplied back. For correlated noise, as of JPEG's blocks, it rises with the
        width: the power of the noise at long waves, which curves follow.
    """
    return _median_noise(_third_differences(polylines, width))


def jitter_of(polylines: Sequence[FloatArray], width: int = 2) -> float:
    """Return the noise of closed polylines as :func:`noise_of` does, of the parts that show some: 0 without any.

    Along a straight edge on the grid of pixels all crossings are alike, however far a renderer sets it off. Corners,
    which then would be most of what is left, are left out.
    """
    found = [np.zeros(0)]
    for points in polylines:
        sizes = _third_differences([points], width)
        if len(sizes):
            near = np.convolve(np.concatenate([sizes[-3:], sizes, sizes[:3]]) > CORNERED, np.ones(7), "valid") > 0
            found.append(sizes[(sizes > EXACT) & ~near])
    return _median_noise(np.concatenate(found))


def _median_noise(differences: FloatArray) -> float:
    """Return the standard deviation of points whose third differences have these sizes, (n,)."""
    return float(np.median(differences) / MEDIAN_SIZE / np.sqrt(1 + 9 + 9 + 1)) if len(differences) else 0.0


def _third_differences(polylines: Sequence[FloatArray], width: int) -> FloatArray:
    """Return the sizes (n,), px, of the third differences of closed polylines, across them; see :func:`noise_of`."""
    found = [np.zeros(0)]
    for points in polylines:
        if len(points) >= 8 * width:
            means = points[: len(points) // width * width].reshape(-1, width, 2).mean(axis=1)
            z = np.sqrt(width) * (means[:, 0] + 1j * means[:, 1])
            third = np.roll(z, -2) - 3 * cyclic.following(z) + 3 * z - cyclic.preceding(z)
            along = cyclic.following(z) - z
            found.append(np.abs((along.conj() * third).imag) / np.maximum(np.abs(along), 1e-9))
    return np.concatenate(found)


def _distance(z: ComplexArray, start: ComplexArray, end: ComplexArray) -> FloatArray:
    """Distance of points from lines between two points each."""
    along = end - start
    square = np.maximum(np.abs(along) ** 2, 1e-12)
    t = np.clip(((z - start) * along.conj()).real / square, 0, 1)
    return np.asarray(np.abs(z - start - t * along))


def _arms(z: ComplexArray, noise: float) -> _Arms:
    """Fit to the points after each one the first arm that is close enough."""
    count = len(z)
    at, way = z.copy(), cyclic.following(z) - z
    error, misses, reach = np.ones(count), np.ones(count), np.ones(count, np.int64)
    open_ = np.ones(count, bool)
    for first, number, degree in ARMS:
        if first + number > count // 3 and (first, number, degree) != ARMS[-1]:
            continue
        k = first + np.arange(number)
        basis = np.vander(k, degree + 1, increasing=True).astype(np.float64)
        solve = np.linalg.pinv(basis)
        runs = z[(np.arange(count)[:, None] + k) % count]
        fit = runs @ solve.T
        slope, start = fit[:, 1], fit[:, 0]
        unit = slope / np.maximum(np.abs(slope), 1e-9)
        across = ((runs - fit @ basis.T) * unit.conj()[:, None]).imag
        miss = np.sqrt((across**2).sum(axis=1) / max(1, number - degree - 1))
        # Over an arc, a parabola or line is off by the arc's curvature as well: no arm.
        good = open_ & (miss <= max(ARM_MISS[degree], 3 * noise)) & (np.abs(slope) > 0.3)
        if (first, number, degree) == ARMS[-1]:
            good = open_ & (np.abs(slope) > 0.1)
        at[good], way[good] = start[good], unit[good]
        error[good] = max(noise, 0.01) * np.sqrt((solve[1] ** 2).sum())
        misses[good] = miss[good] + SHORTNESS / number
        reach[good] = first + number - 1
        open_ &= ~good
    way = way / np.maximum(np.abs(way), 1e-9)
    return _Arms(at, way, error, misses, reach)


def _with_corners(z: ComplexArray, chosen: IntArray, meet: ComplexArray) -> CorneredOutline:
    """Replace the points next to each corner, which arms leave out, by the corner."""
    count = len(z)
    kept = np.ones(count, bool)
    placed = z.copy()
    placed[chosen] = meet[chosen]
    for step in (-2, -1, 1, 2):
        near = (chosen + step) % count
        kept[near[(np.abs(z[near] - meet[chosen]) < CUT) | (abs(step) == 1)]] = False
    kept[chosen] = True
    numbers = np.cumsum(kept) - 1
    points = np.stack([placed.real, placed.imag], axis=1)[kept]
    return CorneredOutline(points, numbers[chosen])
