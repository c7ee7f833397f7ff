# SPDX-License-Identifier: Apache-2.0
"""Hints for drawings that stay far from their picture, chosen by properties of the picture."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from livecl.arrays import FloatArray
from livecl.image.reading import premultiplied
from livecl.image.resizing import reduced
from livecl.options import Options
from livecl.run.recipe import Recipe
from livecl.run.result import Result
from livecl.schedule import MAX_DEFAULT_PATHS

#: Mean squared error above which a drawing is far from its picture: faces that lack a feature have 0.001 to 0.003, a
#: screenshot drawn as seven bars has 0.02.
FAR = 5e-3
#: Unexplained share of the picture's variance above which much of it is missing, and the mean squared error below which
#: nothing is missing: two levels of 255.
LEFT, VISIBLE = 0.05, (2 / 255) ** 2
#: A picture is smoothly shaded if this share of its blocks is: the share; side of a block, px; and, in levels of 255,
#: the least range of a shaded block and its largest root mean square deviation from a plane.
SMOOTH_SHARE, BLOCK, RANGE, MISS = 0.2, 16, 2.0, 0.75

#: Share of the error that is noise or fine texture from which further paths hardly help; and the side, px, of the
#: window whose median tells them from shapes: it keeps edges, and what is wider than half of it.
FINE_SHARE, WINDOW = 0.5, 5
#: Share of the pixels in flat cores from which fine detail is small print and thin lines, not noise or texture:
#: screenshots and pages have at least .8, photographs with noise at most .35.
FLAT = 0.5


def hint(recipe: Recipe, result: Result, image: NDArray[np.floating]) -> str:
    """Return a hint on options to try if a drawing is far from its picture, (H, W, 3) or (H, W, 4), else ""."""
    if result.stopped is not None or not result.mse >= VISIBLE or recipe.masks is not None:
        return ""
    if recipe.options.fills == "solid" and smooth_share(image) >= SMOOTH_SHARE:
        return "the picture is smoothly shaded, and each path has one colour: try --fills auto"
    variance = float(np.mean(np.var(premultiplied(np.asarray(image, dtype=np.float32)), axis=(0, 1))))
    far, fine = result.mse >= min(FAR, LEFT * variance), fine_detail(image, result.working_size)
    usual = recipe.options.prune <= Options().prune
    is_fine = fine >= FINE_SHARE * result.mse
    missing = is_fine and (far or result.mse >= FINE_SHARE * fine)
    if missing and usual and _is_flat(image, result.working_size):
        strokes = (
            "" if recipe.options.strokes != "off" else ", or --strokes auto, which draws print of 12 px by its lines"
        )
        is_reduced = result.working_size not in (None, image.shape[:2])
        size = "; with a larger --size, or on a part of the picture" if is_reduced else ""
        return f"small or thin parts are missing, such as small print: try more paths (--paths auto){strokes}{size}"
    if not far:
        return ""
    if is_fine:
        return (
            "that is far from the picture, and most of what is missing is noise, or texture of a pixel or two, which "
            "paths hardly show: try a picture that is smoothed or larger"
        )
    used, most = result.drawing.num_layers, sum(recipe.stages)
    if recipe.chooses_paths and used <= MAX_DEFAULT_PATHS:
        most = MAX_DEFAULT_PATHS
    if used < most and not usual:
        return (
            f"that is far from the picture, and layers that lower its error by less than {recipe.options.prune:g} were "
            "left out: try --preset default, or a smaller --prune"
        )
    if used < most:
        return (
            "that is far from the picture, and further paths gained too little each, as in noise, texture or smooth "
            "ramps: try --preset photo, or a smaller --path-gain"
        )
    return f"that is far from the picture: try more than {most} paths (--paths {4 * most})"


def _worked_on(image: NDArray[np.floating], size: tuple[int, int] | None) -> FloatArray:
    """Return the premultiplied picture at a size (height, width); None is its own."""
    pixels = np.asarray(image, dtype=np.float32)
    return premultiplied(pixels if size is None else reduced(pixels, size)).astype(np.float64)


def _is_flat(image: NDArray[np.floating], size: tuple[int, int] | None) -> bool:
    """Whether most of a picture at a size (height, width) is flat colour."""
    from livecl.layering.segmentation.flat import flatness

    return flatness(_worked_on(image, size)).cored >= FLAT


def fine_detail(image: NDArray[np.floating], size: tuple[int, int] | None) -> float:
    """Return the mean squared error of a picture, reduced to a size (height, width), against its local median."""
    from scipy import ndimage

    pixels = _worked_on(image, size)
    local = ndimage.median_filter(pixels, (WINDOW, WINDOW, 1))
    return float(np.mean(np.square(pixels - local, dtype=np.float64)))


def smooth_share(image: NDArray[np.floating]) -> float:
    """Return the share of the blocks of a picture, (H, W, C) in [0, 1], that are smoothly shaded.

    Such a block has more than one colour, and differs from a plane by no more than rounding.
    """
    side = min(BLOCK, *image.shape[:2])
    rows, columns = image.shape[0] // side, image.shape[1] // side
    cut: FloatArray = 255 * np.asarray(image[: rows * side, : columns * side], dtype=np.float64)
    blocks = (
        cut.reshape(rows, side, columns, side, -1).transpose(0, 2, 4, 1, 3).reshape(-1, image.shape[2], side * side)
    )
    blocks = blocks - blocks.mean(axis=2, keepdims=True)
    along = np.arange(side) - (side - 1) / 2
    plane = np.stack([np.repeat(along, side), np.tile(along, side)], axis=1)
    plane /= max(float(np.linalg.norm(plane[:, 0])), 1e-9)
    slopes = blocks @ plane  # the two columns are orthonormal
    miss = np.sqrt(np.maximum(np.square(blocks).sum(axis=2) - np.square(slopes).sum(axis=2), 0) / side**2).max(axis=1)
    span = (np.abs(slopes).sum(axis=2) * (np.abs(plane).max() * 2)).max(axis=1)
    return float(np.mean((span >= RANGE) & (miss <= MISS)))
