# SPDX-License-Identifier: Apache-2.0
"""Figure of interpolation: how well drawings of two pictures blend, ours and those of a DiffVG-style baseline."""

from __future__ import annotations

import functools
import itertools
from collections.abc import Sequence
from pathlib import Path

import numpy as np

import livecl
from figures.strip import save_small, shown
from livecl.geometry import bezier
from livecl.interpolation.blending import correspond, interpolate
from livecl.quality import self_crossing

ROOT = Path(__file__).resolve().parents[2]
NO_HOLES = functools.partial(livecl.Options, holes=False)
#: Name, preset, schedule, matching, whether both pictures have the same seed.
ROWS = (
    ("default", NO_HOLES, None, "order", True),
    ("default, nearest", NO_HOLES, None, "nearest", True),
    ("paper", livecl.Options.paper, None, "order", True),
    ("DiffVG-style, random seeds", livecl.Options.diffvg, "8", "order", False),
    ("DiffVG-style, one seed", livecl.Options.diffvg, "8", "order", True),
)
PATHS, FRAMES, REPEATS, SIDE = 8, 7, 3, 108


def orderness(file: Path) -> None:
    """Write a row of drawings for each method, from the face to a surprised one; print the table of measures."""
    images = [
        livecl.read_image(ROOT / "examples" / "face.png"),
        livecl.render(livecl.read_svg(ROOT / "docs" / "figures" / "surprised.svg")),
    ]
    print("| method | MSE | stray | crossing, ends | crossing, between | moved px | fill differs |")
    print("|---" + "|--:" * 6 + "|")
    rows = []
    for name, preset, schedule, match, same_seed in ROWS:
        measures = []
        for repeat in range(REPEATS):
            seeds = (repeat, repeat if same_seed else repeat + REPEATS)
            a, b = (
                livecl.vectorize(image, PATHS, schedule=schedule, options=preset(), seed=seed)
                for image, seed in zip(images, seeds, strict=True)
            )
            drawings = interpolate(a.drawing, b.drawing, np.linspace(0, 1, FRAMES).tolist(), match=match)
            if repeat == 0:
                rows.append(np.concatenate([shown(drawing, SIDE) for drawing in drawings], axis=1))
            ends = correspond(a.drawing, b.drawing, match=match)
            measures.append([(a.mse + b.mse) / 2, *measure(*ends, drawings)])
        mse, stray, at_ends, between, moved, fill = np.mean(measures, axis=0)
        print(f"| {name} | {mse:.2g} | {stray:.1%} | {at_ends:.1f} | {between:.1f} | {moved:.1f} | {fill:.2f} |")
    save_small(file, np.rint(255 * np.concatenate(rows)))


def measure(start: livecl.Drawing, end: livecl.Drawing, drawings: Sequence[livecl.Drawing]) -> tuple[float, ...]:
    """Return stray, self-crossing layers at the ends and in between, movement in px, and difference of fills."""
    areas = np.array([layer_areas(drawing) for drawing in drawings])
    t = np.linspace(0, 1, len(drawings))[:, None]
    expected = (1 - t) * areas[0] + t * areas[-1]
    stray = np.abs(areas - expected)[1:-1].sum() / expected[1:-1].sum()
    crossing = [self_crossing(drawing).sum() for drawing in drawings]
    moved = np.linalg.norm(end.points - start.points, axis=-1).mean()
    fill = np.abs(end.colors - start.colors)[:, :3].mean()
    return float(stray), (crossing[0] + crossing[-1]) / 2, float(np.mean(crossing[1:-1])), float(moved), float(fill)


def layer_areas(drawing: livecl.Drawing) -> np.ndarray:
    """Return the area of each layer, without its holes: (N,), px^2."""
    cubics = drawing.cubics
    return np.array([abs(bezier.signed_area(cubics[i:j])) for i, j in itertools.pairwise(drawing.segment_offsets)])


FIGURES = {"orderness": orderness}
