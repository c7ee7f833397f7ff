# SPDX-License-Identifier: Apache-2.0
"""Group layers by containment, reordering them where the picture stays the same.

An SVG group holds consecutive layers. So a layer that lies inside an earlier one moves down in the paint order to the
end of that one's group, if it overlaps no layer on the way.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from livecl.drawing.borders import border_pairs
from livecl.drawing.drawing import Drawing
from livecl.drawing.labels import layer_labels

#: Share of a layer's area that must lie within another one for it to count as inside.
INSIDE = 0.95
#: Share of the canvas from which a layer counts as ground, which groups nothing.
GROUND = 0.9
#: Coverage from which a pixel counts towards a layer's area, and from which two layers overlap there.
COVERED, TOUCHED = 0.5, 1 / 512
#: Most layers that are grouped, and side, px, of a square with the pixel count of the canvas used: each pair of layers
#: is compared pixel by pixel.
MOST, GROUPING_SIDE = 600, 192


def grouped(drawing: Drawing, coverages: NDArray[Any]) -> Drawing:
    """Group a drawing's layers by containment, in a paint order that shows the same picture.

    `coverages` (N, H, W) may be those on a smaller canvas. A group is named after its lowest layer: ``orange circle
    left group``. A drawing that already has groups, or very many layers, is returned unchanged.
    """
    if any(drawing.groups) or not 1 < drawing.num_layers <= MOST:
        return drawing
    pairs = border_pairs(drawing)
    shapes = np.setdiff1d(np.arange(drawing.num_layers), pairs.max(axis=1, initial=-1))  # a fill with its border is one
    members = {int(low): [int(low), int(high)] for low, high in np.sort(pairs, axis=1)}
    whole = np.array(coverages)
    whole[pairs.min(axis=1, initial=drawing.num_layers)] = whole[pairs].max(axis=1)
    can_hold = drawing.strokes.widths == 0
    can_hold[pairs] = True
    found, places = containment(whole[shapes], can_hold[shapes])
    parents = {int(shapes[k]): -1 if parent < 0 else int(shapes[parent]) for k, parent in enumerate(found)}
    parents |= {high: parents[low] for low, high in members.values()}
    order = [layer for place in places for layer in members.get(int(shapes[place]), [int(shapes[place])])]
    heads = {high: low for low, high in members.values()}
    drawing = drawing.layer_subset(order)
    labels = dict(zip(order, layer_labels(drawing), strict=True))
    holders = set(parents.values())
    paths: list[tuple[str, ...]] = []
    for layer in order:
        path = [f"{labels[head]} group"] if (head := heads.get(layer, layer)) in holders else []
        ancestor = parents[layer]
        while ancestor >= 0:
            path.append(f"{labels[ancestor]} group")
            ancestor = parents[ancestor]
        paths.append(tuple(path[::-1]))
    return drawing.replace(groups=paths)


def containment(coverages: NDArray[Any], can_hold: NDArray[np.bool_]) -> tuple[list[int], list[int]]:
    """Return the layer that contains each of N layers, -1 for none, and the paint order of the groups.

    From coverages (N, H, W), bottom first; only layers that `can_hold` (N,) contain others.
    """
    flat = np.asarray(coverages).reshape(len(coverages), -1)
    # Most pixels lie in the same layers as many others: each kind of pixel is compared once, with its count.
    layers = np.concatenate([flat >= COVERED, flat > TOUCHED])
    kinds = np.ascontiguousarray(np.packbits(layers, axis=0).T)
    _, first, counts = np.unique(kinds.view(f"V{kinds.shape[1]}").ravel(), return_index=True, return_counts=True)
    covered, touched = np.split(layers[:, first].astype(np.float32), 2)
    overlap = touched @ touched.T > 0
    weighted = covered * counts.astype(np.float32)
    areas = weighted.sum(axis=1)
    common = weighted @ covered.T
    holds = can_hold & (areas < GROUND * flat.shape[1])
    parents: list[int] = []
    order: list[int] = []
    for layer in range(len(flat)):
        inside = holds[:layer] & (areas[:layer] > areas[layer]) & (common[layer, :layer] >= INSIDE * areas[layer])
        parent, place = -1, len(order)
        for holder in np.flatnonzero(inside)[np.argsort(areas[:layer][inside], kind="stable")] if areas[layer] else ():
            end = _group_end(int(holder), parents, order)
            if not overlap[layer, order[end:]].any():
                parent, place = int(holder), end
                break
        parents.append(parent)
        order.insert(place, layer)
    return parents, order


def _group_end(layer: int, parents: list[int], order: list[int]) -> int:
    """Return the end position of a layer's group, in the order so far."""
    members, end = {layer}, order.index(layer) + 1
    while end < len(order) and parents[order[end]] in members:
        members.add(order[end])
        end += 1
    return end
