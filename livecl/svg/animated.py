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

from livecl.drawing.canvas import check_canvases
from livecl.drawing.checks import check_number
from livecl.drawing.drawing import Drawing
from livecl.files import write_atomically
from livecl.svg import format_svg
from livecl.svg.writer import INKSCAPE_NAMESPACE, SVG_NAMESPACE

#: Seconds from the first drawing to the last, at least.
MIN_SECONDS = 0.02
#: Half of the smallest step of a colour.
HALF_LEVEL = 0.5 / 255

FloatArray = NDArray[np.float64]


@dataclasses.dataclass(frozen=True)
class _Timeline:
    """A round of an animation: the drawings in the order in which they are met, and when, in seconds: (K,) each."""

    order: list[int]
    times: FloatArray


def format_animated_svg(
    drawings: Sequence[Drawing], *, seconds: float = 2.0, hold: float = 0.0, bounce: bool = True, precision: int = 3
) -> str:
    """Return an SVG that moves from drawing to drawing, and never ends.

    The path data and fills of layers are animated (SMIL), linearly from each drawing to the next at even times. What
    does not change is not animated, and a drawing that lies on the way between its neighbours adds nothing to the file.
    Where nothing plays animations the first drawing is seen.

    Parameters
    ----------
    drawings : sequence of Drawing
        One or more of the same structure: canvas, layers, subpaths and segments.
    seconds : float
        Time from the first drawing to the last.
    hold : float
        Time for which the first and the last drawing stand still.
    bounce : bool
        Whether it goes back the way that it came, or starts again from the first drawing.
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
    documents = [ElementTree.fromstring(format_svg(drawing, precision)) for drawing in drawings]
    timeline = _timeline(len(drawings), seconds, hold, bounce)
    if drawings[0].background is not None:
        rects = [next(document.iter(f"{{{SVG_NAMESPACE}}}rect")) for document in documents]
        backgrounds = np.array([drawing.background for drawing in drawings])
        _animate(rects, "fill", backgrounds, HALF_LEVEL, timeline)
    offsets = drawings[0].segment_offsets
    points = [drawing.points for drawing in drawings]
    colors = np.array([drawing.colors for drawing in drawings])
    layers = zip(*(document.iter(f"{{{SVG_NAMESPACE}}}path") for document in documents), strict=True)
    for layer, paths in enumerate(layers):
        own = np.array([frame[offsets[layer] : offsets[layer + 1]] for frame in points])
        _animate(paths, "d", own, 0.5 * 10.0**-precision, timeline)
        _animate(paths, "fill", colors[:, layer, :3], HALF_LEVEL, timeline)
        _animate(paths, "fill-opacity", colors[:, layer, 3], HALF_LEVEL, timeline)
    ElementTree.register_namespace("", SVG_NAMESPACE)
    ElementTree.register_namespace("inkscape", INKSCAPE_NAMESPACE)
    ElementTree.indent(documents[0])
    return ElementTree.tostring(documents[0], encoding="unicode") + "\n"


def save_animated_svg(path: str | os.PathLike[str], drawings: Sequence[Drawing], **options: Any) -> None:
    """Write an animated SVG, replacing an existing file atomically; arguments as in :func:`format_animated_svg`."""
    write_atomically(path, format_animated_svg(drawings, **options))


def _timeline(count: int, seconds: float, hold: float, bounce: bool) -> _Timeline:
    """Return a round; on the way back the stands at both ends are met from the other side, so each is two halves."""
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
    """Animate an attribute of the first of the elements, which show the drawings one after the other.

    `numbers` (F, ...) are what the attribute says in each drawing; where they lie between those of neighbours to within
    `tolerance`, nothing is written.
    """
    texts = [element.get(name, "1") for element in elements]  # of those animated, only opacities are left out, where 1
    if len(set(texts)) == 1:
        return
    keys = _needed_keys(numbers[timeline.order].reshape(len(timeline.order), -1), timeline.times, tolerance)
    ElementTree.SubElement(
        elements[0],
        "animate",
        attributeName=name,
        dur=f"{timeline.times[-1]:.6g}s",
        repeatCount="indefinite",
        values=";".join(texts[timeline.order[key]] for key in keys),
        keyTimes=";".join(f"{timeline.times[key] / timeline.times[-1]:.6g}" for key in keys),
    )


def _needed_keys(values: FloatArray, times: FloatArray, tolerance: float) -> list[int]:
    """Return the rows of `values` (K, n) that the others follow from by linear interpolation, to within `tolerance`.

    Ramer's and Douglas and Peucker's way: between two rows kept, the one farthest off is kept as well, and so on.
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
        same = np.array_equal(drawing.subpath_offsets, first.subpath_offsets)
        if not same or not np.array_equal(drawing.layer_offsets, first.layer_offsets):
            raise ValueError(
                f"drawings: {index} has other layers or segments than 0; livecl.interpolate makes them agree"
            )
        if (drawing.background is None) != (first.background is None):
            raise ValueError(f"drawings: of 0 and {index} one has a background and the other none")
