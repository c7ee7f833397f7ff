# SPDX-License-Identifier: Apache-2.0
"""Labels of layers: names from fill, shape and position; selection of layers by name or colour."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from livecl.drawing.borders import border_pairs
from livecl.drawing.canvas import layer_boxes
from livecl.drawing.checks import MAX_NAME, clean_name
from livecl.drawing.color_words import BASIC_WORDS, color_names
from livecl.drawing.colors import parse_rgba
from livecl.drawing.fills import SOLID
from livecl.drawing.shape_words import SHAPE_WORDS, shape_words
from livecl.geometry import bezier

if TYPE_CHECKING:
    from livecl.drawing.drawing import Drawing

#: Largest number of names listed in an error.
_MAX_LISTED = 12
#: Largest number of a gradient's colours named in a label.
_MAX_STOP_NAMES = 3

#: Largest distance from the canvas's centre that still counts as the centre, as a share of a side.
CENTRAL = 1 / 12
_ROWS, _COLUMNS = ("top", "", "bottom"), ("left", "", "right")

_COLOR = rf"(?:(?:dark|light)-)?(?:{'|'.join(BASIC_WORDS)})|transparent"
_OWN_ID = re.compile(
    rf"(?:{_COLOR})(?:-to-(?:{_COLOR}))*-(?:{'|'.join(SHAPE_WORDS)})"
    r"-(?:(?:top|bottom)(?:-left|-right)?|left|right|(?:(?:left-of|right-of|above|below)-)?center)"
    r"(?:-\d+)?(?:-group)?(?:-\d+)?"
)


def layer_labels(drawing: Drawing) -> tuple[str, ...]:
    """Return each layer's name, by default made of colour, shape and place: ``orange circle left``.

    The place is the third of the canvas with the centroid of the layer's area, in the middle third also with a side, as
    in "left of center". A gradient is named by its stops: ``yellow to orange circle left``. Equal names are numbered,
    from 2. The stroke around a fill (:func:`livecl.drawing.borders.border_pairs`) has the fill's label.
    """
    fills = {stroke: fill for fill, stroke in border_pairs(drawing).tolist()}
    unnamed = [layer for layer, name in enumerate(drawing.names) if not name and layer not in fills]
    if not unnamed:
        return drawing.names
    labels, taken, counts = list(drawing.names), set(drawing.names), dict[str, int]()
    centers, part = layer_centers(drawing), drawing.layer_subset(unnamed)
    for layer, color, shape in zip(unnamed, fill_names(part), shape_words(part), strict=True):
        name = label = f"{color} {shape} {_place(centers[layer], drawing.size)}"
        while label in taken:
            counts[name] = counts.get(name, 1) + 1
            label = f"{name} {counts[name]}"
        taken.add(label)
        labels[layer] = label
    return tuple(labels[fills.get(layer, layer)] for layer in range(len(labels)))


def name_from_id(identifier: str) -> str:
    """Return the name for an id; in ids made from this program's labels, the label's spaces are restored."""
    return identifier.replace("-", " ") if _OWN_ID.fullmatch(identifier) else identifier


def fill_names(drawing: Drawing) -> list[str]:
    """Name each layer's fill by basic words: ``orange``; gradients by their stops, as ``yellow to orange``.

    Consecutive stops of one name count once; of more than `_MAX_STOP_NAMES`, the first and the last are named. Stops of
    opacity 0 are called transparent.
    """
    names = color_names(drawing.colors[:, :3])
    fills = drawing.fills
    for layer in fills.gradient_layers.tolist():
        stops = fills.stop_colors[fills.stops(layer)]
        words = [
            name if rgba[3] > 0 else "transparent" for name, rgba in zip(color_names(stops[:, :3]), stops, strict=True)
        ]
        distinct = [word for word, _ in itertools.groupby(words)]
        names[layer] = " to ".join(distinct if len(distinct) <= _MAX_STOP_NAMES else distinct[:: len(distinct) - 1])
    return names


def layer_centers(drawing: Drawing) -> NDArray[np.float64]:
    """Return the centroid of each layer's area, px, for tiny areas the centre of the box: (N, 2)."""
    if not drawing.num_layers:
        return np.zeros((0, 2))
    low, high = np.split(layer_boxes(drawing), 2, axis=1)
    moments = np.add.reduceat(bezier.area_moments(drawing.cubics), drawing.segment_offsets[:-1])
    with np.errstate(divide="ignore", invalid="ignore"):
        centers = moments[:, 1:] / moments[:, :1]
    # Loops of opposite orientation can cancel out; then the quotient is arbitrary.
    inside = np.all((centers >= low) & (centers <= high), axis=1, keepdims=True)
    return np.where(inside, centers, (low + high) / 2)


def select_layers(drawing: Drawing, spec: int | str) -> NDArray[np.int64]:
    """Select layers by index, name or colour: see :meth:`livecl.drawing.drawing.Drawing.select`."""
    labels = layer_labels(drawing)
    if not isinstance(spec, str):
        if not isinstance(spec, (int, np.integer)) or isinstance(spec, bool):
            raise ValueError(f"layer: got {spec!r}, wanted an index, a name or a colour")
        if not 0 <= spec < drawing.num_layers:
            raise ValueError(f"layer: got {spec}, wanted 0 to {drawing.num_layers - 1}, or a name or a colour")
        return np.array([spec], dtype=np.int64)
    word = clean_name(spec)
    if word.isascii() and word.isdigit() and int(word) < drawing.num_layers:
        return np.array([int(word)], dtype=np.int64)
    exact = [label == word or word in path for label, path in zip(labels, drawing.groups, strict=True)]
    if any(exact):
        return np.flatnonzero(exact)
    found = np.array([bool(word) and word.casefold() in label.casefold() for label in labels], dtype=bool)
    found |= _filled(drawing, word)
    if not found.any():
        raise ValueError(
            f"layer: nothing is called {spec[:MAX_NAME]!r}, nor filled with that colour; there are {_listed(labels)}"
        )
    return np.flatnonzero(found)


def _filled(drawing: Drawing, text: str) -> NDArray[np.bool_]:
    """Return which layers have a CSS colour as fill or stop, to 8 bits of RGB: (N,)."""
    try:
        rgb = np.rint(np.array(parse_rgba(text)[:3]) * 255)
    except ValueError:
        return np.zeros(drawing.num_layers, dtype=bool)
    fills = drawing.fills
    found = (fills.kinds == SOLID) & np.all(np.rint(drawing.colors[:, :3] * 255) == rgb, axis=1)
    found[fills.stop_layers[np.all(np.rint(fills.stop_colors[:, :3] * 255) == rgb, axis=1)]] = True
    return np.asarray(found)


def _listed(labels: Iterable[str]) -> str:
    names = [repr(label) for label in labels]
    more = f" and {len(names) - _MAX_LISTED} more" if len(names) > _MAX_LISTED else ""
    return ", ".join(names[:_MAX_LISTED]) + more if names else "no layers"


def _place(center: NDArray[np.float64], size: tuple[int, int]) -> str:
    """Return the third of a canvas that contains a point (2,), px; in the middle third also the side."""
    shares = np.round(center / (size[1], size[0]), 6)
    column, row = np.clip((3 * shares).astype(int), 0, 2).tolist()
    if column == row == 1:
        aside = shares - 0.5
        axis = int(np.argmax(np.abs(aside)))
        if abs(aside[axis]) < CENTRAL:
            return "center"
        return f"{(('left of', 'right of'), ('above', 'below'))[axis][int(aside[axis] > 0)]} center"
    return f"{_ROWS[row]} {_COLUMNS[column]}".strip()
