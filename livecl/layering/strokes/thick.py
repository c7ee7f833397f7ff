# SPDX-License-Identifier: Apache-2.0
"""Parts of an ink's shapes that are thicker than its lines: heads of notes, dots on lines."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from scipy.spatial import cKDTree

from livecl import interruption
from livecl.arrays import FloatArray
from livecl.geometry.skeleton import CenterLine


def thick_parts(
    shapes: NDArray[np.integer], usual: FloatArray, lines: list[CenterLine], rules: tuple[float, float, float]
) -> list[tuple[NDArray[np.bool_], tuple[slice, slice]]]:
    """Return the parts of shapes (H, W) that are thicker than their lines, each with its box: heads of notes, dots.

    They are what is left of a shape by a disc that its lines, and two of them crossing, have no room for; parts that
    are themselves lines are left out. `usual` (N,) is the half width of each shape's longest line, 0 where it has none.
    `rules` are the `StrokeRules.thick`, `same_width` and `drawn`.
    """
    thick, same_width, share = rules
    inside = interruption.apart(lambda: ndimage.distance_transform_edt(shapes > 0))
    radii = thick * usual[shapes]
    core = (radii > 0) & (inside > radii)
    if not core.any():
        return []
    away, (rows, columns) = interruption.apart(lambda: ndimage.distance_transform_edt(~core, return_indices=True))
    parts, _ = ndimage.label((away <= radii[rows, columns]) & (shapes > 0))
    # Lines away from a part are not asked; of the others' points only those within the line's width are looked for.
    reaches = [same_width * float(np.median(line.radii)) for line in lines]
    trees = [(cKDTree(line.points), reach) for line, reach in zip(lines, reaches, strict=True)]
    found = []
    for number, box in enumerate(ndimage.find_objects(parts), 1):
        interruption.check()
        blob = parts[box] == number
        places = np.argwhere(blob)[:, ::-1] + [box[1].start + 0.5, box[0].start + 0.5]
        drawn = np.zeros(len(places), bool)
        low, high = places.min(axis=0), places.max(axis=0)
        for tree, reach in trees:
            if (tree.maxes + reach >= low).all() and (tree.mins - reach <= high).all() and not drawn.all():
                interruption.check()
                left = places[~drawn]
                drawn[~drawn] = tree.query(left, distance_upper_bound=reach * (1 + 1e-9))[0] <= reach
        if drawn.mean() < share:
            found.append((blob, box))
    return found
