# SPDX-License-Identifier: Apache-2.0
"""Choice of fills during training: replace solid colours by gradients, or gradients by solid colours, where it pays.

A fill is worth the squared error that it removes, and costs its numbers (ramps.py).
"""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from livecl import interruption
from livecl.arrays import BoolArray, FloatArray
from livecl.drawing.drawing import Drawing
from livecl.drawing.fills import SOLID, Fills, concatenate_fills
from livecl.image.errors import visible_error
from livecl.layering.context import Context
from livecl.layering.contributions import covered_alphas
from livecl.layering.fills.ramps import COLOR_NUMBERS, GEOMETRY_NUMBERS, LAYER_NUMBERS, Paint, Shading, fit_paint
from livecl.layering.fills.stops import STOP_NUMBERS
from livecl.options import AUTO_PATH_GAIN, Options

#: Least share of a pixel's colour for the pixel to count as a layer's own, clear of anti-aliased edges; fewest such
#: pixels.
OWN_SHARE, LEAST_PIXELS = 0.95, 24
#: Largest alpha of the layers below at which a layer counts as painted over transparency; least alpha divided by.
CLEAR = 0.02
#: Least saving, in numbers, for another fill to be used: less may be rounding.
LEAST_SAVING = 0.1


def shading_of(options: Options) -> Shading | None:
    """Return the kinds of gradients that the options allow, and their price; None where layers are solid.

    A number costs its share of a layer's price: `prune`, or `path_gain` where that decides on layers. With `colors` or
    `palette` there are no gradients, as a gradient has any number of colours.
    """
    if options.fills == "solid" or options.colors or options.palette:
        return None
    kinds = ("linear", "radial") if options.fills == "auto" else (options.fills,)
    return Shading(kinds, (max(options.prune, options.path_gain) or AUTO_PATH_GAIN) / LAYER_NUMBERS)


def shaded(context: Context, drawing: Drawing, free: BoolArray) -> Drawing:
    """Refit the fills of `free` (N,) layers, solid or gradient, where another fill lowers the cost.

    The colour wanted of a layer at a pixel is its present colour plus the residual over its share of the pixel. Only
    pixels that belong almost wholly to the layer are used. A layer over transparency may also change its opacity.
    """
    shading = shading_of(context.options)
    if shading is None or not free.any():
        return drawing
    coverages = context.rasterizer.coverages(drawing)
    alphas = covered_alphas(drawing, coverages)
    above = _transmittances(alphas[::-1], len(alphas) - int(np.argmax(free)))[::-1]  # from the lowest free layer on
    above = [np.zeros(0)] * (len(alphas) - len(above)) + above
    target = np.asarray(context.target, dtype=np.float64)
    below = _transmittances(alphas, len(alphas)) if target.shape[2] == 4 else []
    price = shading.price_in(target[..., 0].size)
    residual = target - context.rasterizer.forward(drawing)
    found: dict[int, Paint] = {}
    for layer in range(drawing.num_layers):
        if not free[layer]:
            continue
        interruption.check()
        own = (coverages[layer] > OWN_SHARE) & (above[layer] > OWN_SHARE)
        if np.count_nonzero(own) < LEAST_PIXELS:
            continue
        fills = drawing.fills.subset([layer])
        points = np.asarray(np.argwhere(own)[:, ::-1] + 0.5, dtype=np.float64)
        now = _colors_at(drawing, layer, points)
        alone = bool(below) and float(np.mean(1 - below[layer][own])) <= CLEAR
        wanted, weights = _wanted(now, residual[own], alone)
        kept = float(weights @ np.square(now - wanted).sum(axis=1)) + price * _numbers(fills)
        kinds = shading.kinds if context.changes.drift(own) else ()
        paint = fit_paint(points, wanted, weights, price, kinds, most=kept - LEAST_SAVING * price)
        saved = kept - paint.error - price * paint.numbers
        if (paint.kind != SOLID or fills.any_gradients) and saved > LEAST_SAVING * price:
            found[layer] = paint
    # What else a layer covers, and layers over and under it, may want another fill than its own pixels. Fills that make
    # up for each other are right together, if at all.
    error = _squared(residual)
    for some in [found, *({layer: paint} for layer, paint in found.items())] if found else []:
        interruption.check()
        changed = _filled(drawing, some, context.options.opacity == "opaque")
        dearer = price * (_numbers(changed.fills) - _numbers(drawing.fills))
        left = _squared(target - context.rasterizer.forward(changed))
        if left + dearer < error:
            drawing, error = changed, left
            if some is found:
                break
    return drawing


def _squared(residual: FloatArray) -> float:
    """Return the visible squared error of a residual (H, W, C), summed over pixels and channels."""
    return float(np.square(visible_error(residual)).sum())


def _filled(drawing: Drawing, paints: dict[int, Paint], opaque: bool) -> Drawing:
    """Return the drawing with other fills of some layers, optionally with uniform opacity."""
    parts, colors = [], drawing.colors.copy()
    for layer in range(drawing.num_layers):
        paint = paints.get(layer)
        if paint is None:
            parts.append(drawing.fills.subset([layer]))
            continue
        parts.append(_opaque(paint) if opaque else paint.fills)
        if paint.kind == SOLID:
            colors[layer] = paint.color
    return drawing.replace(colors=colors, fills=concatenate_fills(parts))


def _opaque(paint: Paint) -> Fills:
    stops = paint.stops.copy()
    if len(stops):
        stops[:, 3] = stops[:, 3].mean()
    return dataclasses.replace(paint, stops=stops).fills


def _numbers(fills: Fills) -> int:
    """Count the numbers that describe the fills of some layers."""
    solid = int(np.count_nonzero(fills.kinds == SOLID))
    geometry = sum(GEOMETRY_NUMBERS[kind] for kind in fills.kinds.tolist())
    return geometry + COLOR_NUMBERS * solid + STOP_NUMBERS * len(fills.stop_positions)


def _colors_at(drawing: Drawing, layer: int, points: FloatArray) -> FloatArray:
    """Evaluate the straight RGBA of a layer at points: (n, 4)."""
    if drawing.fills.kinds[layer] == SOLID:
        return np.broadcast_to(drawing.colors[layer], (len(points), 4))
    return drawing.fills.colors_at(layer, points)


def _wanted(now: FloatArray, residual: FloatArray, alone: bool) -> tuple[FloatArray, FloatArray]:
    """Return the straight RGBA (n, 4) wanted of a layer of colours `now`, and the weight of each pixel.

    Where nothing lies below, the layer's premultiplied colour absorbs the residual; elsewhere its opacity stays.
    """
    opacity = now[:, 3:]
    if alone:
        premultiplied = np.concatenate([now[:, :3] * opacity, opacity], axis=1) + residual
        alpha = np.clip(premultiplied[:, 3:], CLEAR, 1)
        wanted = np.concatenate([premultiplied[:, :3] / alpha, alpha], axis=1)
        return np.clip(wanted, 0, 1), alpha[:, 0] ** 2
    colors = now[:, :3] + residual[:, :3] / np.maximum(opacity, CLEAR)
    return np.concatenate([colors, opacity], axis=1), np.maximum(opacity[:, 0] ** 2, CLEAR**2)


def _transmittances(alphas: NDArray[np.float32], count: int) -> list[FloatArray]:
    """Return the product of (1 - alpha) of the layers before each of the first `count`."""
    through = [np.ones(alphas.shape[1:])]
    for alpha in alphas[: count - 1]:
        interruption.check()
        through.append(through[-1] * (1 - alpha))
    return through
