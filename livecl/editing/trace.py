# SPDX-License-Identifier: Apache-2.0
"""`SampledOutline`: a closed outline resampled by arc length, with its corners and candidate nodes."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from livecl.arrays import FloatArray, IntArray
from livecl.geometry import bezier, cyclic
from livecl.geometry.polylines import lengths_along, points_at, unit

#: Sampling step, px; fewest and most samples.
STEP, LEAST, MOST = 0.5, 48, 4000
#: Length, px, of the two chords whose angle is the turning at a sample; largest share of the outline's length.
REACH, SHARE = 1.5, 1 / 24
#: Least turning, radians, of a corner, and of a corner that is a node in any case.
TURNING, SURE = 0.4, 0.6
#: Standard deviation, px, of the Gaussian that smooths an outline, and of the stronger one used to find corners.
EVENED, CORNERS_EVENED = 0.35, 0.6
#: An extreme is farther out than the samples at this distance, px, by so much, px.
BEND_REACH, BENT = 3.0, 0.04
#: Most candidate nodes beside corners, anchors and extremes; their spacing, px.
PLACES, SPACING = 40, 2.0
#: Shortest straight side, px; reach of the chord whose sagitta tells a bend, px, and largest sagitta, and largest
#: distance of a side from its chord, px.
SHORTEST_SIDE, SIDE_REACH, SAGITTA, STRAIGHT = 5.0, 2.0, 0.03, 0.05


@dataclasses.dataclass(frozen=True)
class SampledOutline:
    """A closed outline resampled by arc length."""

    points: FloatArray  # (P, 2), samples, px
    step: float  # sampling step along the outline, px
    weights: FloatArray  # (P,), weights of the samples: 1 where visible
    corners: IntArray  # (K,), samples at which the outline may have a corner, rising
    turning: FloatArray  # (K,), by how much it turns there, radians
    places: IntArray  # (Q,), samples at which a smooth node may stand, rising
    extreme: NDArray[np.bool_]  # (P,), samples next to which the outline is level or plumb at its outermost
    sides: IntArray  # (S, 2), first and last samples of its straight sides, counted on past the last sample

    def tangent(self, samples: IntArray, reach: float = 1.0) -> FloatArray:
        """Return unit tangents at samples (n,): of the chord from `reach` px before to as much after, (n, 2)."""
        k, count = max(1, round(reach / self.step)), len(self.points)
        chord = self.points[(samples + k) % count] - self.points[(samples - k) % count]
        return unit(chord)

    def side(self, sample: int, direction: int) -> tuple[FloatArray, FloatArray]:
        """Return a point and the unit direction of travel of the outline beside a corner, behind its rounding."""
        near, far = round(0.75 / self.step), max(round(0.75 / self.step) + 2, round(2.5 / self.step))
        beside = self.points[(sample + direction * np.arange(near, far + 1)) % len(self.points)]
        return beside.mean(axis=0), direction * unit(beside[-1] - beside[0])


def sampled(cubics: FloatArray) -> SampledOutline | None:
    """Resample a closed outline of cubics (m, 4, 2) by arc length; None if it is too short to have a shape."""
    polygon = bezier.flatten(cubics, 0.002)
    corners, counts = polygon.corners, polygon.counts
    closed = np.concatenate([corners, corners[:1]])
    lengths = lengths_along(closed)
    total = float(lengths[-1])
    if total < 4 * STEP:
        return None
    count = int(np.clip(round(total / STEP), LEAST, MOST))
    points = points_at(np.arange(count, dtype=np.float64) * (total / count), closed, lengths)
    anchors = lengths[np.concatenate([[0], np.cumsum(counts)[:-1]])]
    step = total / count
    sharp = np.abs(turning(points, 1))
    sharp = np.max([np.roll(sharp, shift) for shift in (-1, 0, 1)], axis=0) > SURE
    bends, turns = _corners(_evened(points, CORNERS_EVENED / step), step)
    points = _evened(points, EVENED / step)
    extremes = _extremes(points, step)
    sides = _sides(points, step)
    spaced = np.arange(0, count, max(SPACING / step, count / PLACES)).astype(np.int64)
    near = np.rint(anchors / step).astype(np.int64) % count
    places = np.unique(np.concatenate([near, np.flatnonzero(extremes), spaced, bends, sides.ravel() % count]))
    # Evened, a corner would pass for a bend: one that turns within a step is no smooth node.
    places = np.setdiff1d(places, bends[sharp[bends] & (turns > SURE)])
    return SampledOutline(points, step, np.ones(count), bends, turns, places, extremes, sides)


def _evened(points: FloatArray, deviation: float) -> FloatArray:
    """Smooth a closed trace by a Gaussian with a standard deviation in samples: (P, 2)."""
    frequency = 2 * np.pi * np.fft.rfftfreq(len(points))
    spectrum = np.fft.rfft(points, axis=0) * np.exp(-0.5 * (deviation * frequency) ** 2)[:, None]
    return np.asarray(np.fft.irfft(spectrum, len(points), axis=0))


def turning(points: FloatArray, reach: int) -> FloatArray:
    """Return the angle between the chords of `reach` samples before and after each sample, radians: (P,)."""
    z = points[:, 0] + 1j * points[:, 1]
    after, before = np.roll(z, -reach) - z, z - np.roll(z, reach)
    return np.asarray(np.angle(after * np.conj(before)))


def _corners(points: FloatArray, step: float) -> tuple[IntArray, FloatArray]:
    """Return the samples of locally largest turning, and their turning, radians."""
    reach = max(1, round(min(REACH, SHARE * step * len(points)) / step))
    angles = np.abs(turning(points, reach))
    corner = angles > TURNING
    for shift in range(1, reach + 1):
        corner &= (angles >= np.roll(angles, shift)) & (angles > np.roll(angles, -shift))
    found = np.flatnonzero(corner)
    return found, angles[found]


def _extremes(points: FloatArray, step: float) -> NDArray[np.bool_]:
    """Return the samples where a coordinate is farthest out, by a bend and not along a side: (P,)."""
    reach = max(1, round(BEND_REACH / step))
    outward = [points - np.roll(points, shift, axis=0) for shift in (-reach, reach)]
    far = (outward[0] * outward[1] > 0) & (np.minimum(*np.abs(outward)) > BENT)
    turns = (points - cyclic.preceding(points)) * (cyclic.following(points) - points) <= 0
    return np.asarray((far & turns).any(axis=1))


def _sides(points: FloatArray, step: float) -> IntArray:
    """Return the first and last samples of the straight sides of a closed trace, (S, 2)."""
    z, count = points @ (1, 1j), len(points)
    reach = max(1, round(SIDE_REACH / step))
    chord = np.roll(z, -reach) - np.roll(z, reach)
    off = ((z - np.roll(z, reach)) * chord.conj()).imag / np.maximum(np.abs(chord), 1e-9)
    flat = np.abs(off) <= SAGITTA
    if flat.all() or not flat.any():
        return np.zeros((0, 2), np.int64)
    starts = np.flatnonzero(flat & ~cyclic.preceding(flat))
    ends = np.flatnonzero(flat & ~cyclic.following(flat))
    ends = ends if ends[0] >= starts[0] else cyclic.following(ends)
    ends = np.where(ends < starts, ends + count, ends)
    kept = []
    for a, b in zip(starts, ends, strict=True):
        run = z[np.arange(a, b + 1) % count]
        way = run[-1] - run[0]
        if abs(way) >= SHORTEST_SIDE and np.abs(((run - run[0]) * way.conjugate()).imag).max() <= STRAIGHT * abs(way):
            kept.append((a, b))
    return np.array(kept, np.int64).reshape(-1, 2)
