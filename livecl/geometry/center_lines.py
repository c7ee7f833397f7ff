# SPDX-License-Identifier: Apache-2.0
"""Centre lines of strokes: polylines with the direction, length and neighbours of each line."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import ArrayLike, NDArray

from livecl.arrays import FloatArray, IntArray

#: Distance, px, from the preceding vertex below which a vertex has no direction of its own.
MIN_LENGTH = 1e-6


@dataclasses.dataclass(frozen=True)
class CenterLines:
    """Polylines without repeated vertices; line i leads from vertex i to vertex next[i]."""

    vertices: FloatArray
    strokes: IntArray
    kept: IntArray  # index of each vertex among those given
    num_given: int
    next: IntArray
    previous: IntArray
    is_first: NDArray[np.bool_]  # ends of open strokes
    is_last: NDArray[np.bool_]
    angles: FloatArray
    lengths: FloatArray
    perpendicular: FloatArray  # d angle / d (line's vector)
    smooth: NDArray[np.bool_]

    @classmethod
    def of(
        cls, vertices: FloatArray, offsets: IntArray, closed: NDArray[np.bool_], smooth: ArrayLike | None
    ) -> CenterLines:
        """Leave out repeated vertices and connect the others; arguments as of :func:`.strokes.outline_strokes`."""
        strokes = np.repeat(np.arange(len(offsets) - 1), np.diff(offsets))
        is_start = np.diff(strokes, prepend=-1) != 0
        steps = np.linalg.norm(np.diff(vertices, axis=0, prepend=vertices[:1]), axis=1)
        keep = is_start | (steps > MIN_LENGTH)
        first_of = offsets[:-1][strokes]
        back = np.linalg.norm(vertices - vertices[first_of], axis=1) <= MIN_LENGTH
        for stroke in np.flatnonzero(closed):  # the end of a closed stroke may repeat its beginning
            at = offsets[stroke + 1] - 1
            while at > offsets[stroke] and (back[at] or not keep[at]):
                keep[at] = False
                at -= 1
        kept = np.flatnonzero(keep)
        strokes = strokes[kept]
        num = len(kept)
        starts = np.flatnonzero(np.diff(strokes, prepend=-1))
        ends = np.append(starts[1:], num) - 1
        following, previous = np.arange(1, num + 1), np.arange(-1, num - 1)
        following[ends], previous[starts] = starts, ends
        is_open = ~closed | (ends == starts)
        is_first, is_last = np.zeros(num, bool), np.zeros(num, bool)
        is_first[starts[is_open]] = is_last[ends[is_open]] = True
        points = vertices[kept]
        vectors = points[following] - points
        lengths = np.linalg.norm(vectors, axis=1)
        angles = np.arctan2(vectors[:, 1], vectors[:, 0])
        square = np.where(lengths > 0, lengths, np.inf)[:, None] ** 2
        perpendicular = np.stack([-vectors[:, 1], vectors[:, 0]], axis=1) / square
        curved = np.zeros(num, bool) if smooth is None else np.asarray(smooth, bool)[kept]
        return cls(
            points,
            strokes,
            kept,
            len(vertices),
            following,
            previous,
            is_first,
            is_last,
            angles,
            lengths,
            perpendicular,
            curved,
        )

    def turns(self, before: IntArray, after: IntArray) -> FloatArray:
        """Return the angle from one line to another, in (-pi, pi]."""
        return np.asarray(np.pi - (np.pi - self.angles[after] + self.angles[before]) % (2 * np.pi))
