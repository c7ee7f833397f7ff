# SPDX-License-Identifier: Apache-2.0
"""Line art with known centre lines: drawings of the project's own, and how far found strokes are from them."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from scipy.spatial import cKDTree

from livecl.drawing import Drawing, Strokes
from livecl.geometry.bezier import evaluate

SIZE = (160, 160)
TAU = 2 * math.pi
BLACK, BLUE, RED = (0.1, 0.1, 0.1), (0.1, 0.25, 0.75), (0.8, 0.15, 0.1)

Subpath = tuple[np.ndarray, bool]


def line(*corners: tuple[float, float]) -> Subpath:
    """An open polyline; its last row is its end."""
    anchors = np.array(corners, dtype=float)
    steps = np.concatenate([np.diff(anchors, axis=0), np.zeros((1, 2))])
    return np.stack([anchors, anchors + steps / 3, anchors + 2 * steps / 3], axis=1), True


def polygon(*corners: tuple[float, float]) -> Subpath:
    """A closed polyline."""
    anchors = np.array(corners, dtype=float)
    steps = np.roll(anchors, -1, axis=0) - anchors
    return np.stack([anchors, anchors + steps / 3, anchors + 2 * steps / 3], axis=1), False


def arc(x: float, y: float, radius: float, begin: float = 0.0, end: float = 1.0, squeeze: float = 1.0) -> Subpath:
    """An arc between two angles, in turns; a whole one is closed."""
    closed = end - begin == 1
    count = max(1, math.ceil(abs(end - begin) * 4 - 1e-9))
    angles = TAU * np.linspace(begin, end, count + 1)
    handle = 4 / 3 * math.tan(TAU * (end - begin) / count / 4)
    on, along = np.stack([np.cos(angles), np.sin(angles)], 1), np.stack([-np.sin(angles), np.cos(angles)], 1)
    rows = np.stack([on[:-1], on[:-1] + handle * along[:-1], on[1:] - handle * along[1:]], axis=1)
    if not closed:
        rows = np.concatenate([rows, np.broadcast_to(on[-1], (1, 3, 2))])
    return rows * radius * np.array([1, squeeze]) + np.array([x, y]), not closed


def curve(*points: tuple[float, float]) -> Subpath:
    """An open curve of cubics: anchor, handle, handle, anchor, ..."""
    rows = np.array(points[:-1], dtype=float).reshape(-1, 3, 2)
    return np.concatenate([rows, np.broadcast_to(np.array(points[-1], float), (1, 3, 2))]), True


def drawing(
    *layers: tuple[tuple[float, float, float], float, list[Subpath]],
    cap: int = 1,
    join: int = 1,
    size: tuple[int, int] = SIZE,
) -> Drawing:
    """Layers of a colour, a width and subpaths, on white."""
    return Drawing.from_outlines(
        [[rows for rows, _ in subpaths] for _, _, subpaths in layers],
        [(*color, 1) for color, _, _ in layers],
        size,
        strokes=Strokes(
            widths=[width for _, width, _ in layers],
            caps=cap,
            joins=join,
            is_open=np.array([is_open for _, _, subpaths in layers for _, is_open in subpaths]),
        ),
    )


def _spiral() -> Subpath:
    angles = np.linspace(0.5, 5 * math.pi, 22)
    radius, growth = 4.4 * angles, 4.4
    on = np.stack([radius * np.cos(angles), radius * np.sin(angles)], 1)
    speed = np.stack(
        [growth * np.cos(angles) - radius * np.sin(angles), growth * np.sin(angles) + radius * np.cos(angles)], 1
    )
    third = (angles[1] - angles[0]) / 3
    rows = np.stack([on[:-1], on[:-1] + third * speed[:-1], on[1:] - third * speed[1:]], axis=1)
    return np.concatenate([rows, np.broadcast_to(on[-1], (1, 3, 2))]) + 80.0, True


def _star() -> Subpath:
    angles = np.arange(10) * TAU / 10 - TAU / 4
    radius = np.where(np.arange(10) % 2, 26, 62)
    return polygon(*(80 + radius[:, None] * np.stack([np.cos(angles), np.sin(angles)], 1)).tolist())


DRAWINGS: dict[str, Drawing] = {
    "house": drawing(
        (BLACK, 4, [line((20, 80), (80, 25), (140, 80)), line((35, 68), (35, 135), (125, 135), (125, 68))]),
        (BLUE, 4, [polygon((66, 135), (66, 95), (94, 95), (94, 135))]),
        cap=0,
        join=0,
    ),
    "face": drawing(
        (BLACK, 5, [arc(80, 80, 60), arc(80, 85, 34, 0.05, 0.45)]), (BLUE, 4, [arc(58, 65, 8), arc(102, 65, 8)])
    ),
    "spiral": drawing((BLACK, 5, [_spiral()])),
    "star": drawing((RED, 5, [_star()]), join=0),
    "cup": drawing(
        (BLACK, 5, [line((35, 55), (42, 125), (100, 125), (107, 55)), arc(71, 55, 36, squeeze=0.25)]),
        (BLACK, 5, [curve((105, 70), (140, 62), (140, 110), (101, 108))]),
        (BLUE, 3, [curve((60, 35), (52, 28), (68, 20), (60, 12)), curve((80, 35), (72, 28), (88, 20), (80, 12))]),
    ),
    "crossing": drawing(
        (BLACK, 4, [line((20, 30), (140, 120)), line((25, 125), (135, 25)), line((80, 10), (80, 150))])
    ),
    "letter": drawing(
        (BLACK, 7, [line((45, 140), (45, 25), (80, 25)), arc(80, 52, 27, -0.25, 0.25), line((80, 79), (45, 79))]),
        (BLACK, 7, [line((80, 79), (112, 140))]),
        cap=0,
    ),
    "waves": drawing(
        *(
            (color, 4, [curve((15, y), (37, y - 30), (58, y + 30), (80, y), (102, y - 30), (123, y + 30), (145, y))])
            for color, y in ((BLUE, 40), (BLACK, 80), (RED, 120))
        )
    ),
    "arrows": drawing(
        (BLACK, 4, [line((20, 40), (130, 40)), line((112, 22), (130, 40), (112, 58))]),
        (BLACK, 2.5, [line((20, 115), (130, 115)), line((116, 101), (130, 115), (116, 129))]),
        cap=1,
    ),
    "flower": drawing(
        (RED, 3.5, [arc(80 + 30 * math.cos(TAU * k / 5), 55 + 30 * math.sin(TAU * k / 5), 15) for k in range(5)]),
        (BLACK, 3.5, [arc(80, 55, 11), curve((80, 90), (84, 110), (76, 130), (82, 150))]),
    ),
}


def samples(art: Drawing) -> np.ndarray:
    """Return points (P, 2) of all centre lines, about two a pixel."""
    parts = []
    for subpath, rows in enumerate(art.subpaths()):
        cubics = art.cubics[rows][: -1 if art.strokes.is_open[subpath] else None]
        for cubic in cubics:
            length = np.abs(np.diff(cubic, axis=0)).sum()
            parts.append(evaluate(cubic, np.linspace(0, 1, 2 + int(2 * length))))
    return np.concatenate(parts) if parts else np.zeros((0, 2))


def widths(art: Drawing) -> np.ndarray:
    """Return the width at each of the samples."""
    counts = []
    layers = np.repeat(np.arange(art.num_layers), np.diff(art.layer_offsets))
    for subpath in range(len(layers)):
        rows = art.subpaths()[subpath]
        cubics = art.cubics[rows][: -1 if art.strokes.is_open[subpath] else None]
        total = sum(2 + int(2 * np.abs(np.diff(cubic, axis=0)).sum()) for cubic in cubics)
        counts.append(np.full(total, art.strokes.widths[layers[subpath]]))
    return np.concatenate(counts) if counts else np.zeros(0)


@dataclasses.dataclass(frozen=True)
class Match:
    """How found strokes compare with true ones.

    Attributes
    ----------
    distance : float
        Mean distance of the centre lines, px, both ways.
    width : float
        Mean share by which widths are off, at the true centre lines.
    nodes : float
        Nodes found for each true one.
    """

    distance: float
    width: float
    nodes: float


def match(found: Drawing, true: Drawing) -> Match:
    """Compare found strokes with true ones; infinitely far where nothing was found."""
    ours, theirs = samples(found), samples(true)
    if not len(ours):
        return Match(math.inf, math.inf, 0.0)
    near, index = cKDTree(ours).query(theirs)
    back, _ = cKDTree(theirs).query(ours)
    off = np.abs(widths(found)[index] / widths(true) - 1)
    return Match(float((near.mean() + back.mean()) / 2), float(off.mean()), found.num_segments / true.num_segments)
