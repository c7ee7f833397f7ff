# SPDX-License-Identifier: Apache-2.0
"""Convert outlines from the even-odd fill rule to nonzero."""

from __future__ import annotations

import numpy as np

from livecl.arrays import FloatArray, IntArray
from livecl.geometry import bezier, cyclic

#: Horizontal lines on which the fill rules are compared.
_NUM_ROWS = 256
#: Most crossings of lines and rows in one block of work.
_MAX_CROSSINGS = 2_000_000
#: Most lines of a flattened outline, and most lines times subpaths, that are examined: about a second each.
_MAX_LINES, _MAX_PAIRS = 300_000, 100_000_000


def nonzero_from_even_odd(outline: list[FloatArray]) -> tuple[list[FloatArray], bool]:
    """Return an outline that the nonzero rule fills as the even-odd rule fills the given one, if one is found.

    The two rules agree if no winding number is even but nonzero. If they differ, subpaths inside an odd number of
    others are reversed relative to the rest, which solves nested subpaths and few crossing ones. The rules are compared
    along 256 rows; stretches narrower than 1/1024 of the outline's size do not count.

    Returns
    -------
    (list of (n, 4, 2), bool)
        The outline, and whether the rules agree on it; if they do not, or the outline is too long to be examined, it is
        the given one.
    """
    if not outline:
        return outline, True
    bounds = bezier.outline_bounds(outline)
    extent = float(max(bounds[2] - bounds[0], bounds[3] - bounds[1])) or 1.0
    lines, owners = _flattened(outline, extent / 4096)
    if len(lines) > _MAX_LINES or len(lines) * len(outline) > _MAX_PAIRS:
        return outline, False
    agree = _rules_agree(lines, extent / 1024)
    if agree or len(outline) == 1:  # reversing a single subpath changes nothing
        return outline, agree
    against = np.zeros(len(outline), dtype=bool)
    for i, subpath in enumerate(outline):
        x, y = subpath[0, 0]
        others = lines[((lines[:, 0, 1] > y) != (lines[:, 1, 1] > y)) & (owners != i)]
        inside = np.count_nonzero(_abscissae(others, y) < x) % 2 == 1
        against[i] = inside == (bezier.signed_area(subpath) > 0)
    turned = [subpath[::-1, ::-1] if turn else subpath for subpath, turn in zip(outline, against, strict=True)]
    lines = np.where(against[owners][:, None, None], lines[:, ::-1], lines)
    return (turned, True) if _rules_agree(lines, extent / 1024) else (outline, False)


def _flattened(outline: list[FloatArray], tolerance: float) -> tuple[FloatArray, IntArray]:
    """Flatten an outline into lines (L, 2, 2), unordered; return them and the subpath of each, (L,)."""
    cubics = np.concatenate(outline)
    subpaths = np.repeat(np.arange(len(outline)), [len(subpath) for subpath in outline])
    lines = bezier.flatten(cubics, tolerance, _MAX_LINES)
    last = np.diff(lines.segments, append=len(cubics)) > 0  # the last line of a cubic
    ends = np.where(last[:, None], cubics[lines.segments, 3], cyclic.following(lines.corners))
    return np.stack([lines.corners, ends], axis=1), subpaths[lines.segments]


def _abscissae(lines: FloatArray, y: float) -> FloatArray:
    """Return x of the crossings of lines (L, 2, 2) with a row that all of them cross: (L,)."""
    (x0, y0), (x1, y1) = lines[:, 0].T, lines[:, 1].T
    return x0 + (y - y0) / (y1 - y0) * (x1 - x0)


def _rules_agree(lines: FloatArray, narrow: float) -> bool:
    """Return whether no stretch of a row, wider than `narrow`, has an even winding number other than zero."""
    return _agree_along(lines, narrow, _NUM_ROWS // 16) and _agree_along(lines, narrow, _NUM_ROWS)


def _agree_along(lines: FloatArray, narrow: float, num_rows: int) -> bool:
    """Return whether the rules agree along `num_rows` rows."""
    low, high = float(lines[..., 1].min()), float(lines[..., 1].max())
    if not high > low:
        return True
    rows = (lines[..., 1] - low) * (num_rows / (high - low)) - 0.5  # row k lies at k
    first = np.ceil(rows.min(axis=1)).astype(np.int64)
    end = np.ceil(rows.max(axis=1)).astype(np.int64)
    size = num_rows if (end - first).sum() <= _MAX_CROSSINGS else num_rows // 16
    blocks = range(0, num_rows, size)
    return all(_rows_agree(lines, rows, first.clip(k, k + size), end.clip(k, k + size), narrow) for k in blocks)


def _rows_agree(lines: FloatArray, rows: FloatArray, first: IntArray, end: IntArray, narrow: float) -> bool:
    """Return whether the rules agree along the rows from `first` up to `end` of each line."""
    owner = np.repeat(np.arange(len(lines)), end - first)
    row = np.arange(len(owner)) - np.repeat(np.cumsum(end - first) - end, end - first)
    start, stop = rows[owner].T
    x = lines[owner, 0, 0] + (row - start) / (stop - start) * (lines[owner, 1, 0] - lines[owner, 0, 0])
    order = np.lexsort((x, row))
    # Subpaths are closed, so the winding number is zero again at the end of each row.
    winding = np.cumsum(np.where(stop > start, 1, -1)[order])[:-1]
    x, row = x[order], row[order]
    inside = (np.diff(row) == 0) & (np.diff(x) > narrow)
    return not np.any(inside & (winding != 0) & (winding % 2 == 0))
