# SPDX-License-Identifier: Apache-2.0
"""Match layers between two drawings, in order or by the Hungarian algorithm, with one paint order for both."""

from __future__ import annotations

import heapq
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components

from livecl.arrays import FloatArray
from livecl.drawing.canvas import layer_boxes
from livecl.drawing.drawing import Drawing

Match = Literal["order", "nearest"]
#: Largest difference (see `layer_differences`) of layers paired by "nearest": a shift by 0.63 of the canvas.
MAX_DIFFERENCE = 0.4
#: Weight of the squared difference of each colour channel: small, so that layers in one place are paired.
COLOR_WEIGHT = 0.5
#: Layers of the first and of the second drawing; None if a layer has no match.
Pair = tuple[int | None, int | None]


def match_layers(a: Drawing, b: Drawing, match: Match = "order") -> list[Pair]:
    """Pair the layers of two drawings.

    Parameters
    ----------
    a, b : Drawing
        On canvases of one size.
    match : "order" or "nearest"
        "order": by place in paint order, as in the paper. If one drawing has more layers, all of the other's are paired
        in order, at the least total difference in place, extent and colour. "nearest": the pairs of least total
        difference (Hungarian matching), in any order, without pairs that differ too much.

    Returns
    -------
    list of pairs of int or None
        Every layer of either drawing once, filled and stroked ones never paired, in a paint order that suits both:
        layers that overlap in `a` are in the order of `a`, those that overlap in `b` in that of `b`. If nearest pairs
        contradict each other in this, the pair of the smallest layers is split.

    Raises
    ------
    ValueError
        If `match` is neither.
    """
    if match not in get_args(Match):
        raise ValueError(f"match: got {match!r}, wanted {' or '.join(map(repr, get_args(Match)))}")
    differences = layer_differences(a, b)
    if match == "order":
        return _of_one_kind(_in_order(differences), a, b)
    rows, columns = linear_sum_assignment(np.minimum(differences, MAX_DIFFERENCE))
    partners = {
        i: j for i, j in zip(rows.tolist(), columns.tolist(), strict=True) if differences[i, j] < MAX_DIFFERENCE
    }
    return _without_contradictions(partners, a, b)


def layer_differences(a: Drawing, b: Drawing) -> FloatArray:
    """Return the differences between the layers of two drawings: (N_a, N_b), no unit.

    The sum of squared differences of nine numbers, each about from 0 to 1: centre and sides of the layer's box as
    shares of the canvas's longer side; straight red, green, blue and opacity, weighted by `COLOR_WEIGHT`; and 1 for
    strokes, 0 for fills, which alone is too much for "nearest".
    """
    difference = _features(a)[:, None] - _features(b)[None]
    squares: FloatArray = np.sum(difference * difference, axis=2)
    return squares


def _features(drawing: Drawing) -> FloatArray:
    boxes = layer_boxes(drawing) / max(drawing.size)
    colors = drawing.colors * np.sqrt(COLOR_WEIGHT)
    kinds = (drawing.strokes.widths > 0).astype(np.float64)[:, None]
    return np.concatenate([(boxes[:, :2] + boxes[:, 2:]) / 2, boxes[:, 2:] - boxes[:, :2], colors, kinds], axis=1)


def _in_order(differences: FloatArray) -> list[Pair]:
    """Pair all layers of the drawing that has fewer, in order, at the least sum of differences."""
    if differences.shape[0] > differences.shape[1]:
        return [(i, j) for j, i in _in_order(differences.T)]
    few, many = differences.shape
    # least[i, j]: least sum for the first i layers of the smaller drawing among the first j of the larger.
    least = np.full((few + 1, many + 1), np.inf)
    least[0] = 0
    for i in range(few):
        for j in range(i, many - few + i + 1):
            least[i + 1, j + 1] = min(least[i + 1, j], least[i, j] + differences[i, j])
    pairs: list[Pair] = []
    i = few
    for j in range(many, 0, -1):
        paired = i > 0 and least[i, j] < least[i, j - 1]
        i -= int(paired)
        pairs.append((i if paired else None, j - 1))
    return pairs[::-1]


def _of_one_kind(pairs: list[Pair], a: Drawing, b: Drawing) -> list[Pair]:
    """Split the pairs of a filled and a stroked layer."""
    found: list[Pair] = []
    for i, j in pairs:
        if i is None or j is None or (a.strokes.widths[i] > 0) == (b.strokes.widths[j] > 0):
            found.append((i, j))
        else:
            found += [(i, None), (None, j)]
    return found


def _without_contradictions(partners: dict[int, int], a: Drawing, b: Drawing) -> list[Pair]:
    """Order the pairs and unmatched layers, after splitting pairs that no order suits."""
    areas = [np.prod(boxes[:, 2:] - boxes[:, :2], axis=1) for boxes in (layer_boxes(a), layer_boxes(b))]
    overlaps = _overlaps(a), _overlaps(b)
    while nodes := _nodes(partners, a.num_layers, b.num_layers):
        after = _constraints(nodes, *overlaps)
        _, groups = connected_components(csr_matrix(after), directed=True, connection="strong")
        in_cycles = np.bincount(groups)[groups] > 1
        if not in_cycles.any():
            return _sorted(nodes, after)
        bad = [i for node, (i, j) in enumerate(nodes) if in_cycles[node] and i is not None and j is not None]
        del partners[min(bad, key=lambda i: areas[0][i] + areas[1][partners[i]])]
    return []


def _nodes(partners: dict[int, int], num_a: int, num_b: int) -> list[Pair]:
    """Return pairs with every layer of either drawing once; those of `a` first."""
    lone = sorted(set(range(num_b)) - set(partners.values()))
    return [(i, partners.get(i)) for i in range(num_a)] + [(None, j) for j in lone]


def _overlaps(drawing: Drawing) -> NDArray[np.bool_]:
    """Return [i, j]: layer j lies above layer i, and their boxes meet: (N, N)."""
    boxes = layer_boxes(drawing)
    low, high = boxes[:, :2], boxes[:, 2:]
    meet = np.all((low[:, None] <= high[None]) & (low[None] <= high[:, None]), axis=2)
    return np.triu(meet, 1)


def _constraints(nodes: list[Pair], overlaps_a: NDArray[np.bool_], overlaps_b: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return [m, n]: node n must be painted after node m."""
    after = np.zeros((len(nodes), len(nodes)), dtype=bool)
    for side, overlaps in enumerate((overlaps_a, overlaps_b)):
        own = [(node, layer) for node, pair in enumerate(nodes) if (layer := pair[side]) is not None]
        at, layers = np.array(own, dtype=np.int64).reshape(-1, 2).T
        after[np.ix_(at, at)] |= overlaps[np.ix_(layers, layers)]
    return after


def _sorted(nodes: list[Pair], after: NDArray[np.bool_]) -> list[Pair]:
    """Sort the nodes topologically; of those that may come next, the lowest layer is first."""
    counts = [max(1, sum(pair[side] is not None for pair in nodes)) for side in (0, 1)]

    def height(node: int) -> float:
        parts = [layer / count for layer, count in zip(nodes[node], counts, strict=True) if layer is not None]
        return sum(parts) / len(parts)

    waiting_for = after.sum(axis=0)
    free = [(height(node), node) for node in np.flatnonzero(waiting_for == 0).tolist()]
    heapq.heapify(free)
    order: list[Pair] = []
    while free:
        _, node = heapq.heappop(free)
        order.append(nodes[node])
        for following in np.flatnonzero(after[node]).tolist():
            waiting_for[following] -= 1
            if not waiting_for[following]:
                heapq.heappush(free, (height(following), following))
    return order
