# SPDX-License-Identifier: Apache-2.0
"""Colours of layers: of a palette that is given, a few that are found, or equal ones where nobody sees a difference."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from livecl.drawing.colors import parse_color
from livecl.drawing.drawing import Drawing
from livecl.drawing.fills import SOLID
from livecl.layering.context import Context
from livecl.layering.contributions import layer_alphas, visible_shares

FloatArray = NDArray[np.float64]

#: CIEDE2000 difference under which two colours become one: about half of what most people notice.
JUST_NOTICEABLE = 1.0
#: Rounds of Lloyd's iteration, at most.
ROUNDS = 50


def with_few_colors(context: Context, drawing: Drawing, free: NDArray[np.bool_]) -> Drawing:
    """Return a drawing whose solid layers that are `free`, (N,), have the colours that the options ask for.

    `Options.palette`: each the nearest of it. `Options.colors`: that many, the background's among them, of least
    squared error. Without either, with `Options.simplify`: layers of nearly the same colour have that of the largest.
    """
    options = context.options
    changed = free & (drawing.fills.kinds == SOLID)
    if not changed.any() or not (options.palette or options.colors or options.simplify):
        return drawing
    colors = drawing.colors[:, :3].copy()
    if options.palette:
        colors[changed] = nearest(colors[changed], palette_of(options.palette))
    else:
        areas = visible_shares(layer_alphas(drawing, context.rasterizer)).sum(axis=(1, 2), dtype=np.float64)
        if options.colors:
            fixed = colors[~changed]
            if drawing.background is not None:
                fixed = np.concatenate([fixed, drawing.background[None]])
            fixed = np.unique(np.round(fixed * 255) / 255, axis=0)
            few = clustered(colors[changed], areas[changed] + 1e-6, fixed, options.colors)
            colors[changed] = nearest(colors[changed], few)
        else:
            colors[changed] = joined(colors[changed], areas[changed])
    return drawing.replace(colors=np.concatenate([colors, drawing.colors[:, 3:]], axis=1))


def palette_of(text: str) -> FloatArray:
    """Return the colours (K, 3) of a palette: CSS colours parted by commas.

    Raises
    ------
    ValueError
        If one is no opaque colour.
    """
    return np.array([parse_color(part.strip()) for part in text.split(",")])


def nearest(colors: FloatArray, palette: FloatArray) -> FloatArray:
    """Return the colour of a palette (K, 3) of least squared difference from each of some colours: (n, 3)."""
    distances = np.square(colors[:, None] - palette[None]).sum(axis=2)
    return np.asarray(palette[np.argmin(distances, axis=1)])


def clustered(colors: FloatArray, weights: FloatArray, fixed: FloatArray, count: int) -> FloatArray:
    """Return at most `count` colours of 8 bits, `fixed` (F, 3) among them, near weighted colours (n, 3).

    Ward's clustering, which joins the two clusters whose joining adds least squared error, then Lloyd's iteration.
    """
    centers = [*fixed, *colors]
    masses = [*np.full(len(fixed), np.inf), *weights]
    while len(centers) > max(count, len(fixed), 1):
        points, sizes = np.array(centers), np.array(masses)
        with np.errstate(divide="ignore", invalid="ignore"):
            shares = 1 / (1 / sizes[:, None] + 1 / sizes[None])
            cost = shares * np.square(points[:, None] - points[None]).sum(axis=2)
        cost[np.tril_indices(len(points))] = np.inf
        cost[np.isnan(cost)] = np.inf
        i, j = np.unravel_index(int(np.argmin(cost)), cost.shape)
        if np.isfinite(masses[i]):
            centers[i] = (masses[i] * centers[i] + masses[j] * centers[j]) / (masses[i] + masses[j])
            masses[i] += masses[j]
        del centers[j], masses[j]
    found = np.array(centers)
    for _ in range(ROUNDS):
        own = np.argmin(np.square(colors[:, None] - found[None]).sum(axis=2), axis=1)
        moved = found.copy()
        for k in range(len(fixed), len(found)):
            if (own == k).any():
                moved[k] = np.average(colors[own == k], axis=0, weights=weights[own == k])
        if np.array_equal(moved, found):
            break
        found = moved
    return np.asarray(np.round(found * 255) / 255)


def joined(colors: FloatArray, areas: FloatArray) -> FloatArray:
    """Return colours (n, 3), those that nobody tells apart being equal: the one of the largest area, (n,), stands."""
    from skimage.color import deltaE_ciede2000, rgb2lab

    rounded = np.round(colors * 255) / 255
    lab, result = rgb2lab(rounded), colors.copy()
    heads: list[int] = []
    for k in np.argsort(-areas, kind="stable").tolist():
        gaps = deltaE_ciede2000(lab[heads], lab[[k]]) if heads else np.zeros(0)
        if len(gaps) and gaps.min() < JUST_NOTICEABLE:
            result[k] = rounded[heads[int(np.argmin(gaps))]]
        else:
            result[k] = rounded[k]
            heads.append(k)
    return result
