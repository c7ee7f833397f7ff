# SPDX-License-Identifier: Apache-2.0
"""Skeletonize a mask of thin shapes: trace its centre lines, continued straight across junctions.

The skeleton (thinning by Zhang and Suen, Communications of the ACM 27, 1984; scikit-image's) is a graph: branches of
pixels between ends and junctions. Branches that are no longer than the shape is wide there are either spurs, with a
free end, which are dropped, or bridges between two junctions of one crossing, which are contracted. At each junction,
the two branches that continue each other best become one line.
"""

from __future__ import annotations

import dataclasses
import heapq

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from livecl import interruption
from livecl.arrays import FloatArray
from livecl.geometry.branches import Branch, branches_of
from livecl.geometry.extending import extended, meeting_of

#: Largest cosine between the directions of two branches, both pointing away from a junction, that form one line: 140
#: degrees.
MAX_COSINE = -0.77
#: Spurs: length in half widths up to which a branch is one in any case, and up to which it is one if it ends in a
#: corner; there the distance to the border, as a share of the half width, is below these at its end and in its middle.
SHORT, LONG, TAPER, MIDDLE = 1.2, 5.0, 0.6, 0.75
#: Largest radius of a junction when spurs are judged, in usual half widths of the shape: more lines that meet widen it.
WIDEST = 1.2
#: Longest bridge of a crossing at a small angle, half widths.
FLAT_BRIDGE = 8.0
#: Empty pixels added around a mask.
PADDING = 2
#: Largest difference between the cosines of a stem's angles with the two sides of its loop.
STEM = 0.5
#: Radius around a junction, half widths, within which lines are straightened: the skeleton is distorted there.
CLEAR = 1.5
#: Half widths of the shape along which the direction of a branch is measured, beyond the junction itself.
REACH = 3.0


@dataclasses.dataclass(frozen=True)
class CenterLine:
    """A line in the middle of a thin shape."""

    points: FloatArray  # (n, 2), points (x, y) along it, in pixels of the mask, whose centres lie at halves
    radii: FloatArray  # (n,), distance of each point to the border of the shape
    closed: bool

    @property
    def length(self) -> float:
        """Length of the line, px of the mask."""
        steps = np.diff(self.points, axis=0, append=self.points[:1] if self.closed else self.points[-1:])
        return float(np.hypot(*steps.T).sum())


def center_lines(mask: NDArray[np.bool_]) -> list[CenterLine]:
    """Return the centre lines of the thin shapes of a mask (H, W), the longest first."""
    from skimage.morphology import skeletonize

    mask = np.pad(mask, PADDING)  # shapes end at the canvas's border
    skeleton = interruption.apart(lambda: skeletonize(mask))
    radii = interruption.apart(lambda: ndimage.distance_transform_edt(mask))
    branches, places = branches_of(skeleton)
    graph = _Graph(branches, places, radii)
    graph.drop_spurs()
    graph.contract_bridges()
    graph.place_junctions()
    lines = [_center_line(points, closed, radii) for points, closed in graph.joined()]
    return sorted(lines, key=lambda line: -line.length)


class _Graph:
    """The branches between nodes, as they are simplified."""

    def __init__(self, branches: list[Branch], places: list[FloatArray], radii: FloatArray) -> None:
        self.branches = branches
        self.places = places
        self.radii = radii
        self._shapes, num_shapes = ndimage.label(radii > 0, np.ones((3, 3)))
        skeleton = np.concatenate([np.zeros((0, 2)), *(branch.points for branch in branches)]).astype(int)
        numbers, widths = self._shapes[tuple(skeleton.T)], radii[tuple(skeleton.T)]
        self._half_widths = [
            float(np.median(widths[numbers == number])) if (numbers == number).any() else np.inf
            for number in range(num_shapes + 1)
        ]
        self._clear = [CLEAR * self._radius(node) for node in range(len(places))]  # px around each node

    def _radius(self, node: int) -> float:
        row, column = np.rint(self.places[node]).astype(int)
        return float(self.radii[row, column])

    def _half_width(self, node: int) -> float:
        """Return the usual half width of the shape that a node lies in."""
        row, column = np.rint(self.places[node]).astype(int)
        return self._half_widths[int(self._shapes[row, column])]

    def _by_node(self) -> list[list[tuple[Branch, int]]]:
        """Return the ends at each node: branches in their order, and the side of each, 0 or 1."""
        ends: list[list[tuple[Branch, int]]] = [[] for _ in self.places]
        for branch in self.branches:
            for side, node in enumerate(branch.nodes or ()):
                ends[node].append((branch, side))
        return ends

    def drop_spurs(self) -> None:
        """Drop branches that end within the shape's width from a junction, the shortest first."""
        ends, order = self._by_node(), {branch: number for number, branch in enumerate(self.branches)}
        spurs: dict[Branch, tuple[float, int]] = {}

        def look_at(branch: Branch) -> None:
            spurs.pop(branch, None)
            if branch.nodes is None:
                return
            degree = [len(ends[node]) for node in branch.nodes]
            if min(degree) == 1 and max(degree) >= 3 and self._is_spur(branch, branch.nodes[int(np.argmax(degree))]):
                spurs[branch] = _length(branch.points), order[branch]

        for branch in self.branches:
            look_at(branch)
        gone = set()
        while spurs:
            interruption.check()
            shortest = min(spurs, key=lambda branch: spurs[branch])
            gone.add(shortest)
            del spurs[shortest]
            for node in shortest.nodes or ():
                ends[node] = [end for end in ends[node] if end[0] is not shortest]
                for branch, _ in ends[node]:
                    look_at(branch)
        self.branches = [branch for branch in self.branches if branch not in gone]

    def _is_spur(self, branch: Branch, junction: int) -> bool:
        """Whether a branch merely leads from the middle of the shape to a corner of its border."""
        points = branch.points if branch.nodes is not None and branch.nodes[0] == junction else branch.points[::-1]
        length, radius = _length(points), min(self._radius(junction), WIDEST * self._half_width(junction))
        rows, columns = np.rint(points[[len(points) // 2, -2 % len(points), -1]]).astype(int).T
        middle, *end = self.radii[rows, columns]
        tapers = bool(np.mean(end) < TAPER * radius and middle < MIDDLE * radius)
        return length <= SHORT * radius or (tapers and length <= LONG * radius)

    def contract_bridges(self) -> None:
        """Merge the two junctions into which the skeleton splits a crossing.

        After each, only the branches at that junction and at their other ends are tested again.
        """
        ends = self._by_node()
        order, gone = {branch: number for number, branch in enumerate(self.branches)}, set[Branch]()
        left = list(range(len(self.branches)))  # a heap: the first that may be a bridge comes first
        waiting = set(left)
        while left:
            interruption.check()
            number = heapq.heappop(left)
            bridge = self.branches[number]
            waiting.discard(number)
            if bridge in gone or bridge.nodes is None or not self._is_bridge(bridge, ends):
                continue
            kept, other = bridge.nodes
            gone.add(bridge)
            self.places[kept] = (self.places[kept] + self.places[other]) / 2
            self._clear[kept] = max(self._clear[kept], self._clear[other]) + _length(bridge.points) / 2
            ends[kept] = [end for end in ends[kept] + ends[other] if end[0] is not bridge]
            ends[other] = []
            for branch, _ in ends[kept]:
                assert branch.nodes is not None
                first, last = (kept if node == other else node for node in branch.nodes)
                branch.nodes = first, last
                if order[branch] not in waiting:
                    waiting.add(order[branch])
                    heapq.heappush(left, order[branch])
        self.branches = [branch for branch in self.branches if branch not in gone]

    def _is_bridge(self, branch: Branch, ends: list[list[tuple[Branch, int]]]) -> bool:
        """Whether a branch joins two junctions within the shape's width, or of a crossing at a small angle."""
        if branch.nodes is None or branch.nodes[0] == branch.nodes[1]:
            return False
        if min(len(ends[node]) for node in branch.nodes) < 3:
            return False
        length, radius = _length(branch.points), max(self._radius(node) for node in branch.nodes)
        if length <= 2 * radius:
            return True
        if length > FLAT_BRIDGE * radius:
            return False
        along = self.places[branch.nodes[1]] - self.places[branch.nodes[0]]
        along /= max(float(np.hypot(*along)), 1e-9)
        arms = [
            (sign * along) @ self._direction(other, side, node)
            for node, sign in zip(branch.nodes, (-1, 1), strict=True)
            for other, side in ends[node]
            if other is not branch
        ]
        return bool(min(arms) >= -MAX_COSINE)

    def place_junctions(self) -> None:
        """Move each junction to where the lines that end there meet.

        Where lines meet at acute angles, as in the tip of an arrow, their skeletons join behind it. A junction with a
        branch too short to tell where it comes from, or that tapers into a corner, stays.
        """
        for node, ends in enumerate(self._by_node()):
            interruption.check()
            if len(ends) < 3:
                continue
            lines = []
            for branch, side in ends:
                points = branch.points if side == 0 else branch.points[::-1]
                away = np.hypot(*(points - self.places[node]).T)
                near = points[(away > self._clear[node]) & (away < 2 * self._clear[node])]
                rows, columns = np.rint(near).astype(int).T
                if len(near) > 1 and np.median(self.radii[rows, columns]) > MIDDLE * self._half_width(node):
                    lines.append(extended(near, self.places[node]))
            place = meeting_of(lines) if len(lines) == len(ends) else None
            if place is not None and np.hypot(*(place - self.places[node])) <= self._radius(node):
                self.places[node] = place

    def joined(self) -> list[tuple[FloatArray, bool]]:
        """Return lines (n, 2) of branches that continue each other, and whether each is closed."""
        following: dict[tuple[int, int], tuple[int, int]] = {}  # (branch, side) of a node to (branch, side)
        at_node: dict[int, list[tuple[int, int]]] = {}
        for index, branch in enumerate(self.branches):
            for side, node in enumerate(branch.nodes or ()):
                at_node.setdefault(node, []).append((index, side))
        for node, ends in at_node.items():
            interruption.check()
            directions = [self._direction(self.branches[index], side, node) for index, side in ends]
            pairs = sorted(
                (float(directions[i] @ directions[j]), i, j) for i in range(len(ends)) for j in range(i + 1, len(ends))
            )
            loop = self._stemmed_loop(ends, directions)
            for cosine, i, j in [(-1.0, *loop), *pairs] if loop else pairs:
                alone = len(ends) == 2  # a corner, no crossing
                if (cosine <= MAX_COSINE or alone) and ends[i] not in following and ends[j] not in following:
                    following[ends[i]], following[ends[j]] = ends[j], ends[i]
        return self._chains(following)

    @staticmethod
    def _stemmed_loop(ends: list[tuple[int, int]], directions: list[FloatArray]) -> tuple[int, int] | None:
        """Return the two ends of a loop at a node, if the third branch there is a stem that leaves it symmetrically."""
        if len(ends) != 3:
            return None
        for i, j, stem in ((0, 1, 2), (0, 2, 1), (1, 2, 0)):
            if ends[i][0] == ends[j][0] and abs((directions[i] - directions[j]) @ directions[stem]) < STEM:
                return i, j
        return None

    def _direction(self, branch: Branch, side: int, node: int) -> FloatArray:
        """Return the unit direction in which a branch leaves a node, measured beyond the node's own width."""
        points = branch.points if side == 0 else branch.points[::-1]
        distance = np.hypot(*(points - points[0]).T)
        radius = max(self._radius(node), 1.0)
        first, last = (int(np.argmax(distance > k * radius)) or len(points) - 1 for k in (1, REACH))
        start = points[first] if last > first else self.places[node] if len(points) < 3 else points[0]
        step = points[last] - start
        return np.asarray(step / max(float(np.hypot(*step)), 1e-9))

    def _chains(self, following: dict[tuple[int, int], tuple[int, int]]) -> list[tuple[FloatArray, bool]]:
        lines: list[tuple[FloatArray, bool]] = [(b.points, True) for b in self.branches if b.nodes is None]
        left = {index for index, branch in enumerate(self.branches) if branch.nodes is not None}
        degrees = [len(at_node) for at_node in self._by_node()]
        starts = [(i, side) for i in sorted(left) for side in (0, 1) if (i, side) not in following]
        for start in [*starts, *((i, 0) for i in sorted(left))]:
            if start[0] not in left:
                continue
            run: list[FloatArray] = []
            index, side = start
            closed = start in following
            while index in left:
                left.discard(index)
                branch = self.branches[index]
                assert branch.nodes is not None
                own = branch.points if side == 0 else branch.points[::-1]
                first, last = branch.nodes if side == 0 else branch.nodes[::-1]
                begins, ends = not run and not closed, (index, 1 - side) not in following
                run.append(self._between(own, (first, last), (begins, ends), degrees))
                if (index, 1 - side) not in following:
                    break
                index, side = following[index, 1 - side]
            lines.append((np.concatenate(run), closed))
        return lines

    def _between(
        self, points: FloatArray, nodes: tuple[int, int], at_end: tuple[bool, bool], degrees: list[int]
    ) -> FloatArray:
        """Return the points of a branch outside of its junctions, with the junctions themselves at a line's ends."""
        (first, last), (begins, ends) = nodes, at_end
        keep = np.ones(len(points), bool)
        for node in (first, last):
            if degrees[node] >= 3:
                keep &= np.hypot(*(points - self.places[node]).T) > self._clear[node]
        kept = points[keep] if keep.any() else points[len(points) // 2 : len(points) // 2 + 1]
        before = [self.places[first][None]] if begins and degrees[first] >= 3 else []
        after = [self.places[last][None]] if ends and degrees[last] >= 3 else []
        return np.concatenate([*before, kept, *after])


def _length(points: FloatArray) -> float:
    return float(np.hypot(*np.diff(points, axis=0).T).sum()) + 1


def _center_line(points: FloatArray, closed: bool, radii: FloatArray) -> CenterLine:
    rows, columns = np.rint(points).astype(int).T
    return CenterLine(points[:, ::-1] + 0.5 - PADDING, radii[rows, columns], closed)
