# SPDX-License-Identifier: Apache-2.0
"""Corner detection on closed polylines traced from pixels, with points about 1 px apart.

Pixels cut corners: within about a pixel of one, an outline found from coverages runs across it. A corner is where the
directions in which the outline arrives and leaves, each fitted to points that are not so near, differ; and it lies
where the two lines meet.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
ComplexArray = NDArray[np.complex128]

#: Points of the arms that directions are fitted to, the longest that is followed first: the first of them, their number
#: and the polynomial's degree.
ARMS = ((2, 8, 1), (2, 8, 2), (2, 5, 1), (2, 3, 1), (1, 3, 1), (1, 2, 1))
#: Least bend of a corner, radians, and least bend as a multiple of its standard error. Between short arms, up to a
#: reach in points, circles down to a radius of 2.5 px bend by less than the other bound.
LEAST_BEND, LEAST_RATIO, SHORT_REACH, LEAST_SHORT_BEND = 0.5, 4.0, 5, 1.2
#: Largest root mean square, px, by which an arm may miss its points where these are free from noise, by its degree: a
#: parabola would follow the end of a line and the begin of an arc.
ARM_MISS = {1: 0.04, 2: 0.02}
#: What pixels cut off a corner at most, px, for each unit of the tangent of half its bend: 0.3 to 0.75 at right angles.
#: Corners rounded at a radius of 2 px are cut by 0.88 and more. And the most that is cut off any corner.
CUT_OFF, MOST_CUT_OFF = 0.75, 3.0
#: Miss of an arm, px, for its number of points: of two arms that are followed alike the longer one is better known.
SHORTNESS = 0.1
#: Median of the size of a standard normal variable.
MEDIAN_SIZE = 0.6745
#: Distance, px, from a corner up to which points of the outline are left out.
CUT = 1.25


@dataclasses.dataclass(frozen=True, eq=False)
class CorneredOutline:
    """A closed polyline with its corners."""

    points: FloatArray  # (n, 2), (x, y) px; corners are points of it
    corners: IntArray  # (k,), which points are corners, ascending


@dataclasses.dataclass(frozen=True, eq=False)
class _Arms:
    """Lines in which an outline leaves each of its points, one way.

    A point and a unit direction, its standard error; the miss of the fit, and its last point.
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
    before, after = _distance(meet, np.roll(z, 1), z), _distance(meet, z, np.roll(z, -1))
    sharp &= np.minimum(before, after) < np.minimum(CUT_OFF * np.tan(bends / 2) + 2 * noise, MOST_CUT_OFF)
    # Of points that see one corner, the one that sees it best stands for it; none looks across a corner.
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
        Neighbours that are averaged first. Of noise without correlation the result is the same for each width: means
        deviate less by the square root of it, which is multiplied back. Where neighbours deviate alike, as the blocks
        of JPEG make them, it rises with the width up to their number: the power of the noise at long waves, which
        curves follow.
    """
    found = []
    for points in polylines:
        if len(points) >= 8 * width:
            means = points[: len(points) // width * width].reshape(-1, width, 2).mean(axis=1)
            z = np.sqrt(width) * (means[:, 0] + 1j * means[:, 1])
            third = np.roll(z, -2) - 3 * np.roll(z, -1) + 3 * z - np.roll(z, 1)
            along = np.roll(z, -1) - z
            found.append(np.abs((along.conj() * third).imag) / np.maximum(np.abs(along), 1e-9))
    if not found:
        return 0.0
    return float(np.median(np.concatenate(found)) / MEDIAN_SIZE / np.sqrt(1 + 9 + 9 + 1))


def _distance(z: ComplexArray, start: ComplexArray, end: ComplexArray) -> FloatArray:
    """Distance of points from lines between two points each."""
    along = end - start
    square = np.maximum(np.abs(along) ** 2, 1e-12)
    t = np.clip(((z - start) * along.conj()).real / square, 0, 1)
    return np.asarray(np.abs(z - start - t * along))


def _arms(z: ComplexArray, noise: float) -> _Arms:
    """Fit the longest arm that the points after each one follow, as seen from where it starts."""
    count = len(z)
    at, way = z.copy(), np.roll(z, -1) - z
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
        # The miss of a parabola or line over an arc is its bend, too: a stretch that is not followed closely is no arm.
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
    """Put corners in the place of the points next to them, which arms leave out."""
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
