# SPDX-License-Identifier: Apache-2.0
"""Outlines that the nonzero rule fills as the even-odd rule fills the ones given."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from livecl.geometry import bezier

FloatArray = NDArray[np.float64]

#: Horizontal lines on which the fill rules are compared.
_NUM_ROWS = 256
#: Most lines of a flattened outline, and most lines times subpaths, that are looked at: about a second each.
_MAX_LINES, _MAX_PAIRS = 300_000, 100_000_000


def nonzero_from_even_odd(outline: list[FloatArray]) -> tuple[list[FloatArray], bool]:
    """Return an outline that the nonzero rule fills as the even-odd rule fills the one given, where there is one.

    The two rules agree where no winding number is even but nonzero. Where they differ, subpaths that lie inside an
    odd number of others are made to turn against the rest, which settles nested subpaths and few crossing ones. The
    rules are compared along 256 rows, where stretches narrower than 1/1024 of the outline's size do not count.

    Returns
    -------
    (list of (n, 4, 2), bool)
        The outline, and whether the rules agree on it; where they do not, or the outline is too long to tell in a
        second, it is the one given.
    """
    if not outline:
        return outline, True
    bounds = bezier.hull_bounds(np.concatenate(outline).reshape(-1, 2))
    extent = float(max(bounds[2] - bounds[0], bounds[3] - bounds[1])) or 1.0
    lines, owners = _flattened(outline, extent / 4096)
    if len(lines) > _MAX_LINES or len(lines) * len(outline) > _MAX_PAIRS:
        return outline, False
    if _rules_agree(lines, extent / 1024):
        return outline, True
    against = np.zeros(len(outline), dtype=bool)
    for i, subpath in enumerate(outline):
        x, y = subpath[0, 0]
        others = lines[((lines[:, 0, 1] > y) != (lines[:, 1, 1] > y)) & (owners != i)]
        inside = np.count_nonzero(_abscissae(others, y) < x) % 2 == 1
        against[i] = inside == (bezier.signed_area(subpath) > 0)
    turned = [subpath[::-1, ::-1] if turn else subpath for subpath, turn in zip(outline, against, strict=True)]
    lines = np.where(against[owners][:, None, None], lines[:, ::-1], lines)
    return (turned, True) if _rules_agree(lines, extent / 1024) else (outline, False)


def _flattened(outline: list[FloatArray], tolerance: float) -> tuple[FloatArray, NDArray[np.int64]]:
    """Return the lines (L, 2, 2) that an outline is flattened into, in no order, and the subpath of each: (L,)."""
    cubics = np.concatenate(outline)
    subpaths = np.repeat(np.arange(len(outline)), [len(subpath) for subpath in outline])
    pieces = np.minimum(bezier.pieces_for(cubics, tolerance), _MAX_LINES)
    lines, owners = [], []
    for count in np.unique(pieces):
        same = pieces == count
        corners = bezier.evaluate(cubics[same], np.arange(count + 1) / count)
        lines.append(np.stack([corners[:, :-1], corners[:, 1:]], axis=2).reshape(-1, 2, 2))
        owners.append(np.repeat(subpaths[same], count))
    return np.concatenate(lines), np.concatenate(owners)


def _abscissae(lines: FloatArray, y: float) -> FloatArray:
    """Return where lines (L, 2, 2) that cross a row cross it: (L,)."""
    (x0, y0), (x1, y1) = lines[:, 0].T, lines[:, 1].T
    return x0 + (y - y0) / (y1 - y0) * (x1 - x0)


def _rules_agree(lines: FloatArray, narrow: float) -> bool:
    """Return whether no stretch of a row, wider than `narrow`, has an even winding number other than zero."""
    low, high = float(lines[..., 1].min()), float(lines[..., 1].max())
    for y in low + (high - low) * (np.arange(_NUM_ROWS) + 0.5) / _NUM_ROWS:
        below = lines[..., 1] > y
        crossing = below[:, 0] != below[:, 1]
        x = _abscissae(lines[crossing], y)
        order = np.argsort(x, kind="stable")
        winding = np.cumsum(np.where(below[crossing, 1], 1, -1)[order])[:-1]
        wide = np.diff(x[order]) > narrow
        if np.any(wide & (winding != 0) & (winding % 2 == 0)):
            return False
    return True
