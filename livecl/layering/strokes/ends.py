# SPDX-License-Identifier: Apache-2.0
"""Caps of lines chosen by the error, with the length that each cap needs.

A round or square cap covers as much as a flat end that lies farther out, by pi / 8 or half a width. A line whose cap
changes is therefore lengthened or shortened by the difference, except at ends that lie on another line, where no cap is
visible.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree

from livecl import interruption
from livecl.arrays import BoolArray, FloatArray
from livecl.drawing.assembly import outlines_of, with_outlines
from livecl.drawing.drawing import Drawing
from livecl.geometry import cyclic
from livecl.geometry.bezier import evaluate
from livecl.geometry.strokes import BUTT, ROUND, SQUARE
from livecl.layering.context import Context

#: Length, in widths, of a flat end that covers the same area as a cap.
REACH = {BUTT: 0.0, ROUND: np.pi / 8, SQUARE: 0.5}
#: Samples of lines per width; most samples of a segment.
SAMPLES, MOST = 4, 64
#: Length of a line, in widths, next to its end that is not searched for contact with the end.
OWN = 1.5
#: Sampling step of the ink around an end, and its extent beyond the line's border, px.
STEP, MARGIN = 0.25, 1.5
#: Largest share of a width by which the ink a width before an end may differ from the line's, and ink may lie beyond.
CLEAR = 0.15


def with_best_ends(context: Context, drawing: Drawing) -> Drawing:
    """Return a drawing with the caps of least error for each stroke; the same object if none changes."""
    best, error = drawing, context.visible_mse(drawing)
    for layer in drawing.strokes.stroked_layers.tolist():
        for cap in (BUTT, ROUND):
            changed = _with_caps(best, layer, cap)
            if changed is not best and (changed_error := context.visible_mse(changed)) < error:
                best, error = changed, changed_error
    return best


def _with_caps(drawing: Drawing, layer: int, cap: int) -> Drawing:
    """Return a drawing with other caps for one layer; the same object if it has them already, or has no ends."""
    strokes = drawing.strokes
    subpaths = slice(*drawing.layer_offsets[layer : layer + 2])
    is_open = strokes.is_open[subpaths]
    if strokes.caps[layer] == cap or not is_open.any():
        return drawing
    width = float(strokes.widths[layer])
    by = width * (REACH[int(strokes.caps[layer])] - REACH[cap])
    outlines = outlines_of(drawing)
    outlines[layer] = lengthened(outlines[layer], is_open, width, by)
    caps = strokes.caps.copy()
    caps[layer] = cap
    return with_outlines(drawing, outlines, strokes=dataclasses.replace(strokes, caps=caps))


def lengthened(lines: list[FloatArray], is_open: BoolArray, width: float, by: float) -> list[FloatArray]:
    """Lengthen lines of a width, px, at their free ends by a length, px; rows (s, 3, 2).

    Ends that lie on another line, or on their own, stay.
    """
    return _moved(lines, is_open, width, lambda end, direction: by)


def with_flat_ends(lines: list[FloatArray], is_open: BoolArray, width: float, coverage: FloatArray) -> list[FloatArray]:
    """Move the free ends of lines, (s, 3, 2) rows, to where flat ends would cover as much as their ink (H, W) does.

    Ends that the ink does not tell, as other ink is near, count as those of round caps.
    """

    def miss(end: FloatArray, direction: FloatArray) -> float:
        along = np.arange(-width, width + MARGIN, STEP)
        across = np.arange(-width / 2 - MARGIN, width / 2 + MARGIN, STEP)
        normal = np.array([-direction[1], direction[0]])
        places = end + along[:, None, None] * direction + across[:, None] * normal
        ink = ndimage.map_coordinates(coverage, places.reshape(-1, 2).T[::-1] - 0.5, order=1, mode="constant")
        profile = ink.reshape(len(along), -1).sum(axis=1) * STEP / width
        if abs(profile[0] - 1) > CLEAR or profile[-1] > CLEAR:
            return float(width * REACH[ROUND])
        return float(profile.sum() * STEP - width)

    return _moved(lines, is_open, width, miss)


def _moved(
    lines: list[FloatArray], is_open: BoolArray, width: float, by: Callable[[FloatArray, FloatArray], float]
) -> list[FloatArray]:
    """Move the free ends of lines outwards by a length, px, that depends on the end and its outward direction."""
    samples = [_samples(rows, gap, width) for rows, gap in zip(lines, is_open, strict=True)]
    found = []
    for number, (rows, gap) in enumerate(zip(lines, is_open, strict=True)):
        interruption.check()
        others = [points for other, points in enumerate(samples) if other != number]
        rows = rows.copy()
        for end, inwards in ((0, 1), (-1, -1)):
            if not gap or len(rows) < 2:
                continue
            own = samples[number][::inwards]
            away = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(own, axis=0).T))])
            beside = np.concatenate([own[away > OWN * width], *others])
            near = cKDTree(beside).query(own[0])[0] if len(beside) else np.inf
            direction = own[0] - own[min(2, len(own) - 1)]
            size = float(np.hypot(*direction))
            if near > width / 2 and size:
                step = by(own[0], direction / size) * direction / size
                handle = (0, 1) if end == 0 else (-2, 2)
                # The handle stays where it is, on the tangent, and with it the curve, unless the end comes near it.
                if np.hypot(*step) > np.hypot(*(own[0] - rows[handle])) / 2:
                    rows[handle] += step
                rows[end, : 1 if end == 0 else 3] += step
        found.append(rows)
    return found


def _samples(rows: FloatArray, is_open: bool, width: float) -> FloatArray:
    """Return points (n, 2) along a line, some per width."""
    after = rows[1:, 0] if is_open else cyclic.following(rows)[:, 0]
    cubics = np.concatenate([rows[: len(after)], after[:, None]], axis=1)
    longest = float(np.hypot(*np.diff(cubics, axis=1).reshape(-1, 2).T).reshape(-1, 3).sum(axis=1).max(initial=0))
    count = int(np.clip(SAMPLES * longest / max(width, 1e-9), 4, MOST))
    return np.asarray(evaluate(cubics, np.linspace(0, 1, count + 1)).reshape(-1, 2))
