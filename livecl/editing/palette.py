# SPDX-License-Identifier: Apache-2.0
"""Palettes: quantize the colours of layers to a given palette or to few colours, or unify indistinguishable ones."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from livecl import interruption
from livecl.arrays import Float32Array, FloatArray
from livecl.drawing.colors import parse_color
from livecl.drawing.drawing import Drawing
from livecl.drawing.fills import SOLID
from livecl.layering.context import Context
from livecl.layering.contributions import layer_alphas, visible_shares

IntArray = NDArray[np.intp]

#: CIEDE2000 difference below which two colours become one: about half of the just noticeable difference.
JUST_NOTICEABLE = 1.0
#: Most rounds of Lloyd's iteration, and of moving layers between clusters; least relative decrease of the squared
#: error.
ROUNDS, LEAST_GAIN = 50, 1e-6
#: Share of a pixel's colour left to the background from which the background's colour is one of the palette.
SHOWN = 0.5


def with_few_colors(context: Context, drawing: Drawing, free: NDArray[np.bool_]) -> Drawing:
    """Quantize the colours of the solid layers that are `free`, (N,), as the options ask.

    `Options.palette`: each the nearest of it. `Options.colors`: that many, of least squared error in the picture, the
    background's among them if a pixel shows it by half. Without either, with `Options.simplify`: layers of nearly the
    same colour have that of the largest.
    """
    options = context.options
    changed = free & (drawing.fills.kinds == SOLID)
    if not changed.any() or not (options.palette or options.colors or options.simplify):
        return drawing
    colors = drawing.colors[:, :3].copy()
    if options.palette:
        colors[changed] = nearest_colors(colors[changed], palette_of(options.palette))
    else:
        shares = visible_shares(layer_alphas(drawing, context.rasterizer))
        if options.colors:
            fixed = colors[~changed]
            if drawing.background is not None and (shares.sum(axis=0) < SHOWN).any():
                fixed = np.concatenate([fixed, drawing.background[None]])
            fixed = np.unique(np.round(fixed * 255) / 255, axis=0)
            colors[changed] = fewest(_Picture.of(context, drawing, changed, shares), colors[changed], fixed)
        else:
            colors[changed] = without_twins(colors[changed], shares.sum(axis=(1, 2), dtype=np.float64)[changed])
    return drawing.replace(colors=np.concatenate([colors, drawing.colors[:, 3:]], axis=1))


@dataclasses.dataclass(frozen=True)
class _Picture:
    """The squared error of a picture as a function of the colours c (n, 3) of some layers.

    Their shares s (n, P) of the pixels' colours make the picture ``rest + s^T c``, so that with d (P, 3), the target
    less the rest, the error is ``tr(c^T A c) - 2 tr(c^T b)`` and a constant, where ``A = s s^T`` and
    ``b = s d``. Without a background, an error of alpha e_a counts as in `livecl.image.errors.visible_error`: d is less
    by ``e_a / 2``.
    """

    count: int
    square: FloatArray  # A (n, n)
    product: FloatArray  # b (n, 3)

    @classmethod
    def of(cls, context: Context, drawing: Drawing, changed: NDArray[np.bool_], shares: Float32Array) -> _Picture:
        black = drawing.colors.copy()
        black[changed, :3] = 0
        interruption.check()
        missing = context.target - context.rasterizer.forward(drawing.replace(colors=black))
        if missing.shape[2] == 4:
            missing = missing[..., :3] - missing[..., 3:] / 2
        count = np.count_nonzero(changed)
        square, product = np.zeros((count, count)), np.zeros((count, 3))
        for row, missed in zip(np.moveaxis(shares[changed], 1, 0), missing, strict=True):  # row by row of the picture
            interruption.check()
            own = row.astype(np.float64)
            square += own @ own.T
            product += own @ missed
        return cls(context.options.colors, square, product)

    def solved(self, own: IntArray, fixed: FloatArray, count: int) -> tuple[FloatArray, float]:
        """Return the colours (count, 3) of clusters, the first of them `fixed`, and their error.

        `own` (n,) is the cluster of each layer.
        """
        member = np.zeros((len(own), count))
        member[np.arange(len(own)), own] = 1
        square, product, first = member.T @ self.square @ member, member.T @ self.product, len(fixed)
        colors = np.concatenate([fixed, np.zeros((count - first, 3))])
        rest = square[first:, first:] + 1e-9 * np.eye(count - first)
        colors[first:] = np.linalg.solve(rest, product[first:] - square[first:, :first] @ fixed)
        colors = np.round(np.clip(colors, 0, 1) * 255) / 255
        return colors, float(np.sum(colors * (square @ colors)) - 2 * np.sum(colors * product))


def fewest(picture: _Picture, colors: FloatArray, fixed: FloatArray) -> FloatArray:
    """Quantize the colours (n, 3) of layers to few of least squared error, `fixed` (F, 3) among them.

    Clusters of the colours by visible area, then layers move from one cluster to another as long as the
    picture's error falls, the best colours of the clusters being those of least squares.
    """
    weights = np.diag(picture.square)
    few = clustered(colors, weights + 1e-6, fixed, picture.count)
    own: IntArray = np.argmin(np.square(colors[:, None] - few[None]).sum(axis=2), axis=1)
    best, error = picture.solved(own, fixed, len(few))
    for _ in range(ROUNDS):
        before = error
        for layer in np.argsort(-weights, kind="stable").tolist():
            interruption.check()
            for other in range(len(few)):
                moved = own.copy()
                moved[layer] = other
                found, lower = picture.solved(moved, fixed, len(few))
                if lower < error - LEAST_GAIN:
                    own, best, error = moved, found, lower
        if error >= before:
            break
    return best[own]


def palette_of(text: str) -> FloatArray:
    """Parse the colours (K, 3) of a palette: CSS colours separated by commas.

    Raises ValueError if one is no opaque colour.
    """
    return np.array([parse_color(part.strip()) for part in text.split(",")])


def nearest_colors(colors: FloatArray, palette: FloatArray) -> FloatArray:
    """Return the colour of a palette (K, 3) nearest to each of some colours: (n, 3)."""
    distances = np.square(colors[:, None] - palette[None]).sum(axis=2)
    return np.asarray(palette[np.argmin(distances, axis=1)])


def clustered(colors: FloatArray, weights: FloatArray, fixed: FloatArray, count: int) -> FloatArray:
    """Return at most `count` colours of 8 bits, `fixed` (F, 3) among them, near weighted colours (n, 3).

    Ward's clustering, which joins the two clusters whose joining adds least squared error, then Lloyd's iteration.
    """
    centers = [*fixed, *colors]
    masses = [*np.full(len(fixed), np.inf), *weights]
    while len(centers) > max(count, len(fixed), 1):
        interruption.check()
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


def without_twins(colors: FloatArray, areas: FloatArray) -> FloatArray:
    """Replace colours (n, 3) that nobody can tell apart by that of the largest area, (n,)."""
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
