# SPDX-License-Identifier: Apache-2.0
"""Overlaid fills: a gradient, and above it on the same outline fills of one colour that fade out.

Icons are often shaded by repeating a shape in the colour of a shadow or a gleam that is opaque at one end and fades to
transparent. Over the fill b(p), an overlay of colour o and opacity a(p), a ramp, shows

    c(p) = (1 - a(p)) b(p) + a(p) o.

Where b is seen alone it is fitted; then o and a by least squares from c - b = a (o - b), by turns with b.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence

import numpy as np

from livecl import interruption
from livecl.arrays import BoolArray, FloatArray
from livecl.drawing.fills import LINEAR, SOLID
from livecl.layering.fills.ramps import COLOR_NUMBERS, LAYER_NUMBERS, Paint, refit_paint
from livecl.layering.fills.stops import Pixels


@dataclasses.dataclass(frozen=True, kw_only=True)
class OverlayRules:
    """Parameters of the search for overlaid fills.

    Values: chosen by hand on shaded icons; no comparison of other values is recorded.
    """

    most: int = 3  # most overlays above the lowest fill
    bases: int = 4  # candidate lowest fills tried, those that explain most pixels
    directions: int = 8  # directions from which pixels are taken that may show the lowest fill alone
    seen_share: float = 0.4  # share of the pixels taken from each direction
    alike: float = 0.02  # largest share of pixels explained by only one of a base and one that failed
    rounds: int = 4  # rounds of refitting one fill to the pixels that it explains
    turns: int = 3  # rounds of fitting each fill given the others
    hopeless: float = 4.0  # ratio of the cost after a round to `most` above which the search is abandoned
    max_pixels: int = 3000  # most pixels used
    missed: float = 3.5 / 255  # largest error, in any channel, at a pixel that a fill explains
    steepest: float = 12 / 255  # largest change of colour per px: a steeper ramp draws an edge between two regions
    clear: float = 0.02  # least transmittance of the fills above at which a colour below them can be recovered


OVERLAYS = OverlayRules()


def fit_overlaid(
    points: FloatArray, colors: FloatArray, price: float, kinds: Sequence[str], most: float = np.inf
) -> Paint | None:
    """Fit overlaid fills that minimize squared error plus price; None if the cost is `most` or more.

    Parameters
    ----------
    points : (n, 2)
        Pixel centres.
    colors : (n, 4)
        Straight RGBA wanted there, opaque.
    price : float
        Price of a number, squared error.
    kinds : sequence of str
        Kinds of gradients allowed, of "linear" and "radial".
    most : float
        Cost of the alternative explanation; an overlay costs as much as a layer, numbers of an outline included.
    """
    pixels = Pixels(points, colors, np.ones(len(points))).thinned(OVERLAYS.max_pixels)
    best: Paint | None = None
    failed: list[BoolArray] = []
    for base in _bases(pixels, price, kinds):
        explained = _missed(base, pixels) <= OVERLAYS.missed
        if any(np.mean(explained != other) <= OVERLAYS.alike for other in failed):
            continue
        found = _overlaid(base, pixels, price, kinds, most)
        if not found.over:
            failed.append(explained)
        if found.over and (best is None or _cost(found, price) < _cost(best, price)):
            best = found
    if best is None or _cost(best, price) >= most:
        return None
    return _polished(best, pixels)


def _cost(paint: Paint, price: float) -> float:
    """Return the squared error plus price of the layer or layers of a fill."""
    return paint.error + price * (paint.numbers + LAYER_NUMBERS - COLOR_NUMBERS)


def _missed(paint: Paint, pixels: Pixels) -> FloatArray:
    """Return the largest error of a fill at each pixel, over the channels: (n,)."""
    return np.asarray(np.abs(paint.at(pixels.points) - pixels.colors).max(axis=1))


def _with_error(paint: Paint, pixels: Pixels) -> Paint:
    """Return a fill with its squared error over the pixels."""
    error = float(pixels.weights @ np.square(paint.at(pixels.points) - pixels.colors).sum(axis=1))
    return dataclasses.replace(paint, error=error)


def _bases(pixels: Pixels, price: float, kinds: Sequence[str]) -> Iterator[Paint]:
    """Yield candidate lowest fills, those that explain most pixels first.

    Each starts from the pixels on one side, and is refitted to the pixels that it explains.
    """
    center = pixels.points.mean(axis=0)
    turns = 2 * np.pi * np.arange(OVERLAYS.directions) / OVERLAYS.directions
    along = (pixels.points - center) @ np.array([np.cos(turns), np.sin(turns)])
    starts = [np.ones(len(along), bool), *(along <= np.quantile(along, OVERLAYS.seen_share, axis=0)).T]
    found: dict[bytes, tuple[int, Paint]] = {}
    known: set[bytes] = set()
    for seen in starts:
        before: Paint | None = None
        for _ in range(OVERLAYS.rounds):
            interruption.check()
            known.add(seen.tobytes())
            some = pixels.points[seen], pixels.colors[seen], pixels.weights[seen]
            before = paint = refit_paint(before, *some, price, kinds)
            explained = _missed(paint, pixels) <= OVERLAYS.missed
            if explained.tobytes() in known or explained.sum() < len(explained) / 10:
                break
            seen = explained
        found.setdefault(explained.tobytes(), (-int(explained.sum()), paint))
    for _, paint in sorted(found.values(), key=lambda item: item[0])[: OVERLAYS.bases]:
        yield paint


def _overlaid(base: Paint, pixels: Pixels, price: float, kinds: Sequence[str], most: float) -> Paint:
    """Add overlays to a fill while each lowers the cost."""
    best = _with_error(base, pixels)
    for _ in range(OVERLAYS.most):
        added = _overlay(best, pixels, None, price, kinds)
        if added is None:
            break
        trial = least = _with_error(dataclasses.replace(best, over=(*best.over, added)), pixels)
        for turn in range(OVERLAYS.turns):
            interruption.check()
            if turn and _cost(least, price) > OVERLAYS.hopeless * most:
                return best
            for place in range(len(trial.over) + 1):
                trial = _refitted(trial, place, pixels, price, kinds)
                least = trial if _cost(trial, price) < _cost(least, price) else least
        if _cost(least, price) >= _cost(best, price):
            break
        best = least
    return best


def _overlay(below: Paint, pixels: Pixels, near: Paint | None, price: float, kinds: Sequence[str]) -> Paint | None:
    """Fit an overlay, one colour with a ramp of opacity, to the residual of the fills below.

    Its colour is the point to which the residuals of the fill below converge; with an overlay `near`, both are searched
    for from there.
    """
    from scipy.optimize import least_squares

    under, wanted = below.at(pixels.points)[:, :3], pixels.colors[:, :3]
    missing = wanted - under
    far = np.abs(missing).max(axis=1) > OVERLAYS.missed
    if far.sum() < 12:
        return None
    if near is not None:
        color = near.stops[0, :3]
    else:  # extrapolated from the colour below through the wanted one to the gamut's border
        start, step = under[far].mean(axis=0), missing[far].mean(axis=0)
        room = np.where(step > 0, 1 - start, start) / np.maximum(np.abs(step), 1e-9)
        color = start + step * room.min()
    roots = np.sqrt(pixels.weights[far] / pixels.weights.max())[:, None]

    def aside(rgb: FloatArray) -> FloatArray:
        way = rgb - under[far]
        share = (missing[far] * way).sum(axis=1) / np.maximum((way * way).sum(axis=1), 1e-9)
        return np.asarray((roots * (missing[far] - np.clip(share, 0, 1)[:, None] * way)).ravel())

    found = least_squares(aside, np.clip(color, 0, 1), bounds=(-1e-6, 1 + 1e-6), diff_step=1e-3, max_nfev=30)
    color = np.clip(found.x, 0, 1)
    way = color - under
    squares = (way * way).sum(axis=1)
    opacity = (missing * way).sum(axis=1) / np.maximum(squares, 1e-9)
    rgba = np.column_stack([np.tile(color, (len(opacity), 1)), opacity])
    paint = refit_paint(near, pixels.points, rgba, pixels.weights * squares, price, kinds)
    return paint if paint.kind != SOLID and _steepness(paint) * np.sqrt(squares.max()) <= OVERLAYS.steepest else None


def _steepness(paint: Paint) -> float:
    """Return the largest change of a gradient's opacity, per px."""
    sides = np.linalg.norm(_geometry(paint)[1:] - paint.geometry[0], axis=1)
    rises = np.abs(np.diff(paint.stops[:, 3])) / np.maximum(np.diff(paint.positions), 1e-9)
    return float(rises.max() / max(sides.min(), 1e-9))


def _refitted(paint: Paint, place: int, pixels: Pixels, price: float, kinds: Sequence[str]) -> Paint:
    """Refit one of several overlaid fills, 0 being the lowest, with outliers downweighted."""
    clear, above = np.ones((len(pixels.points), 1)), np.zeros((len(pixels.points), 3))
    for other in paint.over[place:]:
        rgba = other.at(pixels.points)
        above = above + rgba[:, 3:] * (rgba[:, :3] - above)
        clear = clear * (1 - rgba[:, 3:])
    colors = pixels.colors.copy()
    colors[:, :3] = (pixels.colors[:, :3] - above) / np.maximum(clear, OVERLAYS.clear)
    doubt = 1 + np.square(_missed(paint, pixels) / OVERLAYS.missed)
    alone = Pixels(pixels.points, colors, pixels.weights * clear[:, 0] ** 2 / doubt)
    if place == 0:
        fitted: Paint | None = refit_paint(paint, alone.points, alone.colors, alone.weights, price, kinds)
        assert fitted is not None
        return _with_error(dataclasses.replace(fitted, over=paint.over), pixels)
    below = dataclasses.replace(paint, over=paint.over[: place - 1])
    fitted = _overlay(below, alone, paint.over[place - 1], price, kinds)
    if fitted is None:
        return paint
    over = (*paint.over[: place - 1], fitted, *paint.over[place:])
    return _with_error(dataclasses.replace(paint, over=over), pixels)


def _polished(paint: Paint, pixels: Pixels) -> Paint:
    """Refine all parameters of overlaid fills jointly, except the offsets of stops."""
    from scipy.optimize import least_squares

    roots = np.sqrt(pixels.weights / pixels.weights.max())[:, None]

    def residual(numbers: FloatArray) -> FloatArray:
        seen = _of_numbers(numbers, paint).at(pixels.points)
        return np.asarray((roots * (seen - pixels.colors)[:, :3]).ravel())

    start = _numbers_of(paint)
    found = least_squares(residual, start, x_scale="jac", loss="soft_l1", f_scale=OVERLAYS.missed, max_nfev=40)
    polished = _with_error(_of_numbers(found.x, paint), pixels)
    return polished if polished.error < paint.error else paint


def _numbers_of(paint: Paint) -> FloatArray:
    parts = [_geometry(paint).ravel(), (paint.stops if len(paint.stops) else paint.color[None])[:, :3].ravel()]
    for over in paint.over:
        parts += [_geometry(over).ravel(), over.stops[0, :3], over.stops[:, 3]]
    return np.concatenate(parts)


def _geometry(paint: Paint) -> FloatArray:
    return paint.geometry[: {SOLID: 0, LINEAR: 2}.get(paint.kind, 3)]


def _of_numbers(numbers: FloatArray, paint: Paint) -> Paint:
    """Return overlaid fills with other parameters."""
    rest = numbers

    def take(count: int) -> FloatArray:
        nonlocal rest
        taken, rest = rest[:count], rest[count:]
        return taken

    def moved(old: Paint, opaque: bool) -> Paint:
        geometry = old.geometry.copy()
        size = _geometry(old).shape
        geometry[: size[0]] = take(2 * size[0]).reshape(size)
        if old.kind == SOLID:
            return dataclasses.replace(old, color=np.append(np.clip(take(3), 0, 1), 1.0))
        if opaque:
            stops = np.column_stack([take(3 * len(old.stops)).reshape(-1, 3), np.ones(len(old.stops))])
        else:
            color = take(3)
            stops = np.column_stack([np.tile(color, (len(old.stops), 1)), take(len(old.stops))])
        return dataclasses.replace(old, geometry=geometry, stops=np.clip(stops, 0, 1))

    base = moved(paint, opaque=True)
    return dataclasses.replace(base, over=tuple(moved(over, opaque=False) for over in paint.over))
