# SPDX-License-Identifier: Apache-2.0
"""Branches of a skeleton: runs of pixels between its ends and junctions."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from livecl import interruption
from livecl.arrays import FloatArray, IntArray


@dataclasses.dataclass(eq=False)
class Branch:
    """Points (n, 2) as (row, column) from one node to another, by number; a loop has no nodes."""

    points: FloatArray
    nodes: tuple[int, int] | None


def branches_of(skeleton: NDArray[np.bool_]) -> tuple[list[Branch], list[FloatArray]]:
    """Return the branches of a skeleton, and the place (row, column) of each node, an end or a junction.

    Clusters of pixels with three neighbours or more are junctions; the remaining pixels form the branches.
    """
    around = np.ones((3, 3), np.int64)
    count = ndimage.convolve(skeleton.astype(np.int64), around, mode="constant") - 1
    interruption.check()
    junctions, num_junctions = ndimage.label(skeleton & (count >= 3), around)
    parts, num_parts = ndimage.label(skeleton & (junctions == 0), around)
    interruption.check()
    inner = ndimage.convolve((parts > 0).astype(np.int64), around, mode="constant") - 1
    interruption.check()
    at = np.argwhere(junctions)
    sums = np.stack([np.bincount(junctions[tuple(at.T)] - 1, side, num_junctions) for side in at.T], axis=1)
    places = list(sums / np.bincount(junctions[tuple(at.T)] - 1, minlength=num_junctions)[:, None])
    branches = []
    for box, number in zip(ndimage.find_objects(parts), range(1, num_parts + 1), strict=True):
        interruption.check()
        corner = np.array([box[0].start, box[1].start])
        pixels = _in_order(np.argwhere(parts[box] == number) + corner, inner)
        if len(pixels) > 2 and inner[tuple(pixels[0])] == 2:
            branches.append(Branch(pixels.astype(np.float64), None))
            continue
        touched = [_junctions_at(junctions, pixels[0]), _junctions_at(junctions, pixels[-1])]
        if len(pixels) == 1 and len(touched[0]) > 1:
            touched = [touched[0][:1], touched[0][1:]]
        elif len(pixels) == 1:
            touched[1] = []
        nodes = []
        for side, pixel in zip(touched, (pixels[0], pixels[-1]), strict=True):
            if not side:
                places.append(pixel.astype(np.float64))
            nodes.append(side[0] - 1 if side else len(places) - 1)
        branches.append(Branch(pixels.astype(np.float64), (nodes[0], nodes[1])))
    return branches, places


def _in_order(pixels: IntArray, inner: IntArray) -> IntArray:
    """Return the pixels of a branch from one end to the other, or around a loop."""
    left = {(int(row), int(column)) for row, column in pixels}
    start = min((at for at in left if inner[at] < 2), default=min(left))
    run = [start]
    left.discard(start)
    while left:
        row, column = run[-1]
        steps = ((0, 1), (1, 0), (0, -1), (-1, 0), (1, 1), (1, -1), (-1, -1), (-1, 1))
        following = next(((row + i, column + j) for i, j in steps if (row + i, column + j) in left), None)
        if following is None:
            break
        run.append(following)
        left.discard(following)
    return np.array(run)


def _junctions_at(junctions: NDArray[np.integer], pixel: IntArray) -> list[int]:
    """Return the junctions that a pixel touches."""
    row, column = pixel
    near = junctions[max(row - 1, 0) : row + 2, max(column - 1, 0) : column + 2]
    return [int(number) for number in np.unique(near[near > 0])]
