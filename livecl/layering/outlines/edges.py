# SPDX-License-Identifier: Apache-2.0
"""Sub-pixel edges of a region, to a few hundredths of a pixel, from the coverages of its anti-aliased border."""

from __future__ import annotations

import numpy as np

from livecl import interruption
from livecl.arrays import FloatArray, IntArray
from livecl.geometry import cyclic
from livecl.geometry.polylines import evenly

#: Pixels on each side of an edge used to locate it; largest coverage that counts as none.
EDGE_REACH, EDGE_SLACK = 4, 0.01
#: Largest step, px, between points of a straight outline.
LARGEST_STEP = 1.45


def edge_polylines(soft: FloatArray, cover: FloatArray) -> list[FloatArray]:
    """Trace the edges of a region as closed polylines (n, 2), (x, y) px, at steps of about 1 px.

    `soft` (H, W) is above 0.5 at pixels of the region, below elsewhere; `cover` (H, W) is the share that it covers.
    """
    from skimage.measure import find_contours

    cover = np.pad(cover, EDGE_REACH)
    crossings = find_contours(np.pad(soft, EDGE_REACH), 0.5)
    interruption.check()
    return [evenly(_on_edges(c[:-1], cover)[:, ::-1] + 0.5 - EDGE_REACH) for c in crossings]


def _on_edges(crossings: FloatArray, cover: FloatArray) -> FloatArray:
    """Move crossings of grid lines (n, 2) onto the edges given by the coverages (H, W) of their pixels, (row, column).

    Across an edge that runs mostly along the columns, the coverages of a row add up to the place of the edge in the
    middle of this row: exactly where the edge is straight, and to within 1 / (24 R) px at a radius R (the partial area
    effect: Trujillo-Pino et al., Image and Vision Computing 31, 2013). Crossings of the other axis are left out; one
    where a row shows no whole transition stays where interpolation puts it.
    """
    whole = np.floor(crossings).astype(np.int64)
    axis = (crossings != whole).argmax(axis=1)  # that the crossing lies between two pixels on
    steps = np.eye(2, dtype=np.int64)[axis]
    inner = whole + np.where(cover[tuple(whole.T)] >= cover[tuple((whole + steps).T)], 0, 1)[:, None] * steps
    way = np.where((inner == whole).all(axis=1), 1, -1)
    at = inner[:, None] + (way[:, None] * np.arange(1 - EDGE_REACH, EDGE_REACH + 1))[:, :, None] * steps[:, None]
    profile = cover[at[..., 0].clip(0, cover.shape[0] - 1), at[..., 1].clip(0, cover.shape[1] - 1)]
    full = profile[:, EDGE_REACH - 1 :: -1] >= 1 - EDGE_SLACK
    none = profile[:, EDGE_REACH:] <= EDGE_SLACK
    first, last = EDGE_REACH - 1 - full.argmax(axis=1), EDGE_REACH + none.argmax(axis=1)
    place = np.arange(2 * EDGE_REACH)
    offset = (profile * ((place >= first[:, None]) & (place <= last[:, None]))).sum(axis=1) + first - EDGE_REACH
    known = full.any(axis=1) & none.any(axis=1)
    edges = crossings.copy()
    rows = np.flatnonzero(known)
    edges[rows, axis[rows]] = inner[rows, axis[rows]] + way[rows] * (0.5 + offset[rows])
    slopes = _slopes(cover, whole, whole + steps)
    along = np.take_along_axis(slopes, axis[:, None], axis=1)[:, 0]
    kept = ~known | (along >= 0.95 * slopes.max(axis=1))
    if kept.sum() < 4:
        return edges
    # Rows of a corner's pixels show two edges: where no crossing is left for a while, interpolation has them.
    places = np.flatnonzero(kept)
    gaps = np.hypot(*(cyclic.following(edges[places]) - edges[places]).T) > LARGEST_STEP
    bare = gaps[np.cumsum(kept) - 1] & ~kept
    edges[bare] = crossings[bare]
    return np.asarray(edges[kept | bare])


def _slopes(cover: FloatArray, first: IntArray, second: IntArray) -> FloatArray:
    """Return the magnitudes of the coverage differences around pairs of pixels (n, 2) along both axes: (n, 2)."""
    total = np.zeros((len(first), 2))
    height, width = cover.shape
    for pixel in (first, second):
        y, x = pixel[:, 0].clip(1, height - 2), pixel[:, 1].clip(1, width - 2)
        for d in (-1, 0, 1):
            total[:, 0] += (2 - abs(d)) * (cover[y + 1, x + d] - cover[y - 1, x + d])
            total[:, 1] += (2 - abs(d)) * (cover[y + d, x + 1] - cover[y + d, x - 1])
    return np.abs(total)
