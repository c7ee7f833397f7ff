# SPDX-License-Identifier: Apache-2.0
"""Cut-outs: layers that do not overlap, for cutters and print, each cut by those above it up to a small trap.

The curves are cut where they cross (Skia's path operations), so that the visible part of an outline stays its curve.
A trap, in print, is the strip of a layer below its neighbour, so that no paper shows where two colours meet.
"""

from __future__ import annotations

import importlib.util
import logging
from typing import Any

import numpy as np

from livecl.arrays import FloatArray
from livecl.drawing.assembly import outlines_of
from livecl.drawing.checks import check_number
from livecl.drawing.drawing import Drawing
from livecl.drawing.strokes import Strokes
from livecl.geometry import bezier, cyclic
from livecl.geometry.polylines import lengths_along

#: Default trap, px; least area to cut off, and least area of a remaining part, px^2.
DEFAULT_TRAP, LEAST_AREA = 0.5, 0.02
#: Largest distance, px, of a cubic that replaces two pieces of the hidden edge, and least cosine of the angle between
#: the two.
MISS, SMOOTH = 0.05, 0.985
#: Shortest segment, px; points at which pieces are compared.
SHORTEST, SAMPLES = 0.01, 9

_LOG = logging.getLogger(__name__)


def check_cutout() -> None:
    """Raise ValueError if the module for path operations is not installed."""
    if importlib.util.find_spec("pathops") is None:
        raise ValueError("layers: cutout needs skia-pathops: pip install 'livecl[cutout]'")


def cut_out(drawing: Drawing, trap: float = DEFAULT_TRAP) -> Drawing:
    """Cut a drawing's opaque layers so that they do not overlap, except for a trap, and look the same.

    Layers keep the names of whole shapes; hidden layers are removed. Translucent layers neither are cut nor cut others.
    A stroke that is cut becomes a filled outline.

    Parameters
    ----------
    drawing : Drawing
        Any drawing.
    trap : float
        How far a layer goes on below those that cover it, px.

    Raises
    ------
    ValueError
        If skia-pathops is not installed, or the trap is no number of pixels.
    """
    check_cutout()
    check_number("trap", trap, 0)
    import pathops

    opaque, labels = drawing.colors[:, 3] >= 1, drawing.labels
    outlines = outlines_of(drawing)
    strokes, widths = drawing.strokes, drawing.strokes.widths.copy()
    is_open = list(np.split(strokes.is_open, drawing.layer_offsets[1:-1]))
    above, kept = pathops.Path(), []
    for layer in reversed(range(drawing.num_layers)):
        path = _path(drawing, layer)
        try:
            cut = _cut(path, above, trap) if opaque[layer] else None
            if opaque[layer]:
                above = pathops.op(above, path, pathops.PathOp.UNION)
        except pathops.PathOpsError:
            _LOG.warning("layer %d could not be cut, and stays whole", layer)
            cut = None
        if cut is not None:
            outlines[layer] = cut
            widths[layer], is_open[layer] = 0, np.zeros(len(cut), bool)
        if outlines[layer]:
            kept.append(layer)
    kept.reverse()
    return Drawing.from_outlines(
        [outlines[layer] for layer in kept],
        drawing.colors[kept],
        drawing.size,
        drawing.background,
        stages=drawing.stages[kept],
        names=[labels[layer] for layer in kept],
        fills=drawing.fills.subset(kept),
        strokes=Strokes(
            widths=widths[kept],
            caps=strokes.caps[kept],
            joins=strokes.joins[kept],
            miter_limits=strokes.miter_limits[kept],
            is_open=np.concatenate([np.zeros(0, bool), *(is_open[layer] for layer in kept)]),
        ),
        groups=[drawing.groups[layer] for layer in kept],
    )


def _path(drawing: Drawing, layer: int) -> Any:
    """Convert a layer's area to a Skia path."""
    import pathops

    path, cubics, strokes = pathops.Path(fillType=pathops.FillType.WINDING), drawing.cubics, drawing.strokes
    for index, rows in enumerate(drawing.subpaths(layer), start=int(drawing.layer_offsets[layer])):
        own = cubics[rows][:-1] if strokes.is_open[index] else cubics[rows]  # the last row of a line is its end
        path.moveTo(*drawing.points[rows.start, 0])
        for cubic in own:
            if _is_line(cubic):
                path.lineTo(*cubic[3])
            else:
                path.cubicTo(*cubic[1], *cubic[2], *cubic[3])
        if not strokes.is_open[index]:
            path.close()
    if width := float(strokes.widths[layer]):
        cap, join = pathops.LineCap(int(strokes.caps[layer])), pathops.LineJoin(int(strokes.joins[layer]))
        path.stroke(width, cap, join, float(strokes.miter_limits[layer]))
        path.simplify(fix_winding=True, keep_starting_points=False)
    return path


def _is_line(cubic: FloatArray) -> bool:
    """Whether a cubic (4, 2) is straight."""
    along = cubic[3] - cubic[0]
    return bool(np.abs(bezier.cross(along, cubic[1:3] - cubic[0])).max() <= 1e-6 * max(1.0, float(np.hypot(*along))))


def _cut(path: Any, above: Any, trap: float) -> list[FloatArray] | None:
    """Subtract the paths above from one; return subpaths (m, 3, 2), or None if nothing is cut off."""
    import pathops

    if abs(pathops.op(path, above, pathops.PathOp.INTERSECTION).area) <= LEAST_AREA:
        return None
    left = pathops.op(path, above, pathops.PathOp.DIFFERENCE)
    if abs(left.area) <= LEAST_AREA:
        return []
    if trap:
        edge = pathops.Path(above)
        edge.stroke(2 * trap, pathops.LineCap.BUTT_CAP, pathops.LineJoin.MITER_JOIN, 4)
        inner = pathops.op(above, edge, pathops.PathOp.DIFFERENCE)
        left = pathops.op(path, inner, pathops.PathOp.DIFFERENCE)
    left.convertConicsToQuads()
    return [subpath for subpath in _subpaths(left) if abs(bezier.signed_area(_cubics(subpath))) > LEAST_AREA]


def _cubics(subpath: FloatArray) -> FloatArray:
    return np.concatenate([subpath, cyclic.following(subpath[:, :1])], axis=1)


def _subpaths(path: Any) -> list[FloatArray]:
    """Return the closed subpaths (m, 3, 2) of a path, with pieces of hidden edges joined into few cubics."""
    found: list[FloatArray] = []
    for contour in path.contours:
        pieces: list[tuple[FloatArray, bool]] = []
        first = last = np.zeros(2)
        for verb, points in contour:
            ends = [np.array(point) for point in points]
            if verb == type(verb).MOVE:
                first = last = ends[0]
                continue
            if verb == type(verb).CLOSE:
                ends = [first]
            end = ends[-1]
            if np.hypot(*(end - last)) < SHORTEST:
                continue
            if len(ends) == 3:
                piece = np.array([last, *ends])
            elif len(ends) == 2:
                piece = np.array([last, last + 2 / 3 * (ends[0] - last), end + 2 / 3 * (ends[0] - end), end])
            else:
                piece = last + (end - last) * np.array([0, 1 / 3, 2 / 3, 1])[:, None]
            pieces.append((piece, len(ends) == 2))
            last = end
        if pieces:
            found.append(np.array([piece[:3] for piece, _ in _with_joined_edges(pieces)]))
    return found


def _with_joined_edges(pieces: list[tuple[FloatArray, bool]]) -> list[tuple[FloatArray, bool]]:
    """Return cubics (4, 2), neighbours that are marked as parts of a hidden edge being one where that is as good."""
    count = 0
    while count != len(pieces) > 2:
        count, merged = len(pieces), pieces[:1]
        for piece in pieces[1:]:
            before = merged[-1]
            one = _one_cubic(before[0], piece[0]) if before[1] and piece[1] else None
            if one is None:
                merged.append(piece)
            else:
                merged[-1] = (one, True)
        pieces = merged
    return pieces


def _one_cubic(first: FloatArray, second: FloatArray) -> FloatArray | None:
    """Fit one cubic (4, 2) to two that meet smoothly; None if it would deviate too far."""
    enter, leave = second[1] - second[0], first[3] - first[2]
    if enter @ leave < SMOOTH * np.hypot(*enter) * np.hypot(*leave):
        return None
    t = np.linspace(0, 1, SAMPLES)
    points = np.concatenate([bezier.evaluate(first, t), bezier.evaluate(second, t[1:])])
    along = lengths_along(points)
    start, end = first[1] - first[0], second[3] - second[2]
    start, end = start / max(float(np.hypot(*start)), 1e-9), end / max(float(np.hypot(*end)), 1e-9)
    weights = bezier.bernstein(along / along[-1])
    fixed = weights[:, :2].sum(axis=1)[:, None] * first[0] + weights[:, 2:].sum(axis=1)[:, None] * second[3]
    columns = np.stack([weights[:, 1, None] * start, -weights[:, 2, None] * end], axis=-1)
    handles = np.linalg.lstsq(columns.reshape(-1, 2), (points - fixed).ravel(), rcond=None)[0]
    if not (handles > 0).all():
        return None
    cubic = np.array([first[0], first[0] + handles[0] * start, second[3] - handles[1] * end, second[3]])
    dense = bezier.evaluate(cubic, np.linspace(0, 1, 4 * len(points)))
    gaps = np.hypot(*np.moveaxis(dense[:, None] - points[None], 2, 0))
    return cubic if max(gaps.min(axis=0).max(), 0) <= MISS else None
