# SPDX-License-Identifier: Apache-2.0
"""Animated SVG: drawings one after the other."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Sequence
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from livecl.arrays import FloatArray
from livecl.drawing.canvas import check_canvases
from livecl.drawing.checks import check_number
from livecl.drawing.drawing import Drawing
from livecl.drawing.fills import LINEAR, POSITION_DECIMALS, Fills
from livecl.drawing.strokes import DEFAULT_MITER_LIMIT
from livecl.files import write_atomically
from livecl.svg import format_svg
from livecl.svg.servers import format_gradient
from livecl.svg.writer import INKSCAPE_NAMESPACE, SVG_NAMESPACE

#: Least time from the first drawing to the last, seconds.
MIN_SECONDS = 0.02
#: Half a level of an 8-bit colour.
HALF_LEVEL = 0.5 / 255
#: Decimals of a gradient's angle, degrees.
ANGLE_DECIMALS = 3
#: Attributes of a stroke that cannot be interpolated, and their values by default.
PEN = {"stroke-linecap": "butt", "stroke-linejoin": "miter", "stroke-miterlimit": f"{DEFAULT_MITER_LIMIT:g}"}


@dataclasses.dataclass(frozen=True)
class _Timeline:
    """A cycle of an animation: indices of the drawings in the order shown, and their times, seconds: (K,) each."""

    order: list[int]
    times: FloatArray


def format_animated_svg(
    drawings: Sequence[Drawing], *, seconds: float = 2.0, hold: float = 0.0, bounce: bool = True, precision: int = 3
) -> str:
    """Return an SVG that moves from drawing to drawing in an endless loop.

    The path data, paints and widths of layers are animated (SMIL), linearly from each drawing to the next at equal
    intervals; caps, joins and miter limits change half-way. Attributes that do not change are not animated, and a
    drawing that is an interpolation of its neighbours adds nothing to the file. Viewers without animation show the
    first drawing.

    Parameters
    ----------
    drawings : sequence of Drawing
        One or more of the same structure: canvas, layers, subpaths and segments, kinds of fills and numbers of stops,
        which layers are stroked, and which lines are open.
    seconds : float
        Time from the first drawing to the last.
    hold : float
        Time for which the first and the last drawing are shown still.
    bounce : bool
        Whether it plays backwards at the end, or restarts from the first drawing.
    precision : int
        Decimals kept of coordinates in px, 0 to 9.

    Returns
    -------
    str
        The SVG, with the groups, names and background of :func:`livecl.svg.format_svg`.

    Raises
    ------
    ValueError
        If the drawings differ in structure, or a number is out of range.
    """
    _check_structure(drawings)
    check_number("seconds", seconds, MIN_SECONDS)
    check_number("hold", hold, 0)
    # Gradients are added below, as those of one drawing may be plain or shared where those of another are not.
    names = drawings[0].labels if drawings[0].fills.any_gradients else drawings[0].names
    solid = Fills.solid(drawings[0].num_layers)
    plain = [drawing.replace(fills=solid, names=names) for drawing in drawings]
    documents = [ElementTree.fromstring(format_svg(drawing, precision, cubics=True)) for drawing in plain]
    timeline = _timeline(len(drawings), seconds, hold, bounce)
    if drawings[0].background is not None:
        rects = [next(document.iter(f"{{{SVG_NAMESPACE}}}rect")) for document in documents]
        backgrounds = np.array([drawing.background for drawing in drawings])
        _animate(rects, "fill", backgrounds, HALF_LEVEL, timeline)
    offsets = drawings[0].segment_offsets
    points = [drawing.points for drawing in drawings]
    colors = np.array([drawing.colors for drawing in drawings])
    widths = np.array([drawing.strokes.widths for drawing in drawings])
    gradients: list[ElementTree.Element] = []
    layers = zip(*(document.iter(f"{{{SVG_NAMESPACE}}}path") for document in documents), strict=True)
    for layer, paths in enumerate(layers):
        own = np.array([frame[offsets[layer] : offsets[layer + 1]] for frame in points])
        _animate(paths, "d", own, 0.5 * 10.0**-precision, timeline)
        paint = "fill"
        if widths[0, layer]:
            paint = "stroke"
            _animate(paths, "stroke-width", widths[:, layer], 0.5 * 10.0**-precision, timeline)
            for name, default in PEN.items():
                _switch(paths, name, default, timeline)
        if drawings[0].fills.kinds[layer]:
            gradients.append(_animated_gradient(drawings, layer, paths[0], precision, timeline))
            continue
        _animate(paths, paint, colors[:, layer, :3], HALF_LEVEL, timeline)
        _animate(paths, f"{paint}-opacity", colors[:, layer, 3], HALF_LEVEL, timeline)
    if gradients:
        definitions = ElementTree.Element(f"{{{SVG_NAMESPACE}}}defs")
        definitions.extend(gradients)
        documents[0].insert(0, definitions)
    ElementTree.register_namespace("", SVG_NAMESPACE)
    ElementTree.register_namespace("inkscape", INKSCAPE_NAMESPACE)
    ElementTree.indent(documents[0])
    return ElementTree.tostring(documents[0], encoding="unicode") + "\n"


def _animated_gradient(
    drawings: Sequence[Drawing], layer: int, path: ElementTree.Element, precision: int, timeline: _Timeline
) -> ElementTree.Element:
    """Return the gradient of a layer, its points and stops animated, and make it the path's fill."""
    identifier, paint = f"{path.get('id')}-fill", "stroke" if drawings[0].strokes.widths[layer] else "fill"
    path.set(paint, f"url(#{identifier})")
    path.attrib.pop(f"{paint}-opacity", None)
    fills = [drawing.fills.quantized(precision) for drawing in drawings]
    elements = [
        _named(ElementTree.fromstring(format_gradient(drawing.replace(fills=own), layer, identifier, precision)))
        for drawing, own in zip(drawings, fills, strict=True)
    ]
    points = np.array([own.geometry[layer] for own in fills])
    step = 0.5 * 10.0**-precision
    if fills[0].kinds[layer] == LINEAR:
        for name, numbers in zip(("x1", "y1", "x2", "y2"), points[:, :2].reshape(-1, 4).T, strict=True):
            _animate(elements, name, numbers, step, timeline)
    else:
        _animate_ellipse(elements[0], points, precision, timeline)
    own_stops = fills[0].stops(layer)
    positions = np.array([own.stop_positions[own_stops] for own in fills])
    colors = np.array([own.stop_colors[own_stops] for own in fills])
    for index, stops in enumerate(zip(*(list(element)[: positions.shape[1]] for element in elements), strict=True)):
        _animate(stops, "offset", positions[:, index], 0.5 * 10.0**-POSITION_DECIMALS, timeline)
        _animate(stops, "stop-color", colors[:, index, :3], HALF_LEVEL, timeline)
        _animate(stops, "stop-opacity", colors[:, index, 3], HALF_LEVEL, timeline)
    return elements[0]


def _named(element: ElementTree.Element) -> ElementTree.Element:
    """Return an element and its descendants with the namespace of SVG added to their tags."""
    for each in element.iter():
        each.tag = f"{{{SVG_NAMESPACE}}}{each.tag}"
    return element


def _animate_ellipse(element: ElementTree.Element, points: FloatArray, precision: int, timeline: _Timeline) -> None:
    """Animate the transform of a radial gradient's unit circle: `points` (F, 3, 2) are its centre and ends of axes.

    SMIL has no animated matrices: E = R(angle) diag(scales), up to a rotation of the circle, is composed of a
    translation, a rotation and a scaling.
    """
    vectors, scales, _ = np.linalg.svd(np.swapaxes(points[:, 1:] - points[:, :1], 1, 2))
    angles = np.degrees(np.arctan2(vectors[:, 1, 0], vectors[:, 0, 0]))
    for frame in range(1, len(points)):  # of four angles of the same ellipse, the nearest to the one before
        quarters = round((angles[frame - 1] - angles[frame]) / 90)
        if np.ptp(scales[frame]) <= 1e-6 * scales[frame].max():
            angles[frame] = angles[frame - 1]
        elif quarters % 2 and np.ptp(scales[frame]) > np.abs(scales[frame, ::-1] - scales[frame - 1]).max():
            angles[frame], scales[frame] = angles[frame] + 90 * quarters, scales[frame, ::-1]
        else:
            angles[frame] += 180 * round((angles[frame - 1] - angles[frame]) / 180)
    parts = {"translate": points[:, 0], "rotate": angles[:, None], "scale": np.maximum(scales, 10.0**-precision)}
    if all(len(np.unique(numbers, axis=0)) == 1 for numbers in parts.values()):
        return
    decimals = {"translate": precision, "rotate": ANGLE_DECIMALS, "scale": precision}
    for index, (kind, numbers) in enumerate(parts.items()):
        texts = [",".join(f"{number:.{decimals[kind]}f}" for number in row) for row in numbers.tolist()]
        keys = _needed_keys(numbers[timeline.order], timeline.times, 0.5 * 10.0 ** -decimals[kind])
        attributes = {"attributeName": "gradientTransform", "type": kind, "additive": "sum" if index else "replace"}
        _add_animation(element, "animateTransform", attributes, texts, keys, timeline)


def save_animated_svg(path: str | os.PathLike[str], drawings: Sequence[Drawing], **options: Any) -> None:
    """Write an animated SVG, replacing an existing file atomically; arguments as in :func:`format_animated_svg`."""
    write_atomically(path, format_animated_svg(drawings, **options))


def _timeline(count: int, seconds: float, hold: float, bounce: bool) -> _Timeline:
    """Return a cycle; if it bounces, the hold at either end is split into halves, before and after the turn."""
    stand = hold / 2 if bounce else hold
    order = [0, *range(count), count - 1]
    times = np.concatenate([[0.0], stand + seconds * np.linspace(0, 1, count), [seconds + 2 * stand]])
    if bounce:
        order += order[-2::-1]
        times = np.concatenate([times, 2 * times[-1] - times[-2::-1]])
    kept = np.append(True, np.diff(times) > 0)
    return _Timeline([drawing for drawing, keep in zip(order, kept, strict=True) if keep], times[kept])


def _animate(
    elements: Sequence[ElementTree.Element], name: str, numbers: FloatArray, tolerance: float, timeline: _Timeline
) -> None:
    """Animate an attribute of the first element through its values in all elements, one for each drawing.

    `numbers` (F, ...) are the attribute's numbers in each drawing; values that interpolation gives to within
    `tolerance` are not written.
    """
    texts = [
        element.get(name, "1") for element in elements
    ]  # the only attribute left out by default is an opacity of 1
    if len(set(texts)) == 1:
        return
    keys = _needed_keys(numbers[timeline.order].reshape(len(timeline.order), -1), timeline.times, tolerance)
    _add_animation(elements[0], "animate", {"attributeName": name}, texts, keys, timeline)


def _switch(elements: Sequence[ElementTree.Element], name: str, default: str, timeline: _Timeline) -> None:
    """Animate an attribute that cannot be interpolated: it changes half-way between two drawings."""
    texts = [element.get(name, default) for element in elements]
    if len(set(texts)) == 1:
        return
    order, times = timeline.order, timeline.times
    changes = [key for key in range(1, len(order)) if texts[order[key]] != texts[order[key - 1]]]
    middles = [(times[key - 1] + times[key]) / 2 for key in changes]
    ElementTree.SubElement(
        elements[0],
        "animate",
        {"attributeName": name, "calcMode": "discrete"},
        dur=f"{times[-1]:.6g}s",
        repeatCount="indefinite",
        values=";".join(texts[order[key]] for key in [0, *changes]),
        keyTimes=";".join(f"{time / times[-1]:.6g}" for time in [0, *middles]),
    )


def _add_animation(
    element: ElementTree.Element,
    tag: str,
    attributes: dict[str, str],
    texts: Sequence[str],
    keys: Sequence[int],
    timeline: _Timeline,
) -> None:
    """Add an animation to an element; `texts` are the values in each drawing, `keys` the rows that are written."""
    ElementTree.SubElement(
        element,
        tag,
        attributes,
        dur=f"{timeline.times[-1]:.6g}s",
        repeatCount="indefinite",
        values=";".join(texts[timeline.order[key]] for key in keys),
        keyTimes=";".join(f"{timeline.times[key] / timeline.times[-1]:.6g}" for key in keys),
    )


def _needed_keys(values: FloatArray, times: FloatArray, tolerance: float) -> list[int]:
    """Return the rows of `values` (K, n) from which linear interpolation gives the others to within `tolerance`.

    The algorithm of Ramer and of Douglas and Peucker: between two rows kept, the one farthest off is kept as well, and
    so on.
    """
    kept = {0, len(values) - 1}
    open_ranges = [(0, len(values) - 1)]
    while open_ranges:
        first, last = open_ranges.pop()
        if last - first < 2:
            continue
        inner = slice(first + 1, last)
        share = ((times[inner] - times[first]) / (times[last] - times[first]))[:, None]
        off = np.abs((1 - share) * values[first] + share * values[last] - values[inner]).max(axis=1)
        worst = int(np.argmax(off))
        if off[worst] > tolerance:
            middle = first + 1 + worst
            kept.add(middle)
            open_ranges += [(first, middle), (middle, last)]
    return sorted(kept)


def _check_structure(drawings: Sequence[Drawing]) -> None:
    check_canvases(drawings)
    first = drawings[0]
    for index, drawing in enumerate(drawings):
        for what, parts in _structure(drawing).items():
            if not all(map(np.array_equal, parts, _structure(first)[what])):
                raise ValueError(f"drawings: {index} has {what} than 0; livecl.interpolate makes them agree")
        if (drawing.background is None) != (first.background is None):
            raise ValueError(f"drawings: of 0 and {index} one has a background and the other none")


def _structure(drawing: Drawing) -> dict[str, tuple[NDArray[Any], ...]]:
    """Return the arrays that must be equal in all drawings, by the words for a difference in messages."""
    fills, strokes = drawing.fills, drawing.strokes
    return {
        "other layers or segments": (drawing.subpath_offsets, drawing.layer_offsets),
        "fills of other kinds or stops": (fills.kinds, fills.stop_offsets),
        "other strokes or open lines": (strokes.widths > 0, strokes.is_open),
    }
