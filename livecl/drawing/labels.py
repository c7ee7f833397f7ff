# SPDX-License-Identifier: Apache-2.0
"""Labels of layers: names made of colour and place, and selection of layers by name or colour."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from livecl.drawing.canvas import layer_boxes
from livecl.drawing.checks import MAX_NAME, clean_name
from livecl.drawing.color_words import color_names
from livecl.drawing.colors import parse_rgba
from livecl.geometry import bezier

if TYPE_CHECKING:
    from livecl.drawing.drawing import Drawing

#: Names that an error lists.
_MAX_LISTED = 12

_ROWS, _COLUMNS = ("top", "", "bottom"), ("left", "", "right")


def layer_labels(drawing: Drawing) -> tuple[str, ...]:
    """Return each layer's name, or where it has none one of index, colour and place: ``layer-03 orange left``.

    Indices count from 0, the bottom. The place is where the centre of the layer's area lies in the canvas's thirds.
    """
    unnamed = [layer for layer, name in enumerate(drawing.names) if not name]
    if not unnamed:
        return drawing.names
    labels = list(drawing.names)
    digits = max(2, len(str(drawing.num_layers - 1)))
    centers = layer_centers(drawing)
    for layer, color in zip(unnamed, color_names(drawing.colors[unnamed, :3]), strict=True):
        labels[layer] = f"layer-{layer:0{digits}d} {color} {_place(centers[layer], drawing.size)}"
    return tuple(labels)


def layer_centers(drawing: Drawing) -> NDArray[np.float64]:
    """Return the centroid of each layer's area, px; for tiny areas the centre of the box: (N, 2)."""
    if not drawing.num_layers:
        return np.zeros((0, 2))
    low, high = np.split(layer_boxes(drawing), 2, axis=1)
    moments = np.add.reduceat(bezier.area_moments(drawing.cubics), drawing.segment_offsets[:-1])
    with np.errstate(divide="ignore", invalid="ignore"):
        centers = moments[:, 1:] / moments[:, :1]
    # Loops of opposite turns can cancel out: then the quotient lies anywhere.
    inside = np.all((centers >= low) & (centers <= high), axis=1, keepdims=True)
    return np.where(inside, centers, (low + high) / 2)


def select_layers(drawing: Drawing, spec: int | str) -> NDArray[np.int64]:
    """Return the layers that `spec` means: see :meth:`livecl.drawing.drawing.Drawing.select`."""
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
    exact = [label == word for label in labels]
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
    """Which layers are filled with a CSS colour, to 8 bits of RGB: (N,)."""
    try:
        rgb = parse_rgba(text)[:3]
    except ValueError:
        return np.zeros(drawing.num_layers, dtype=bool)
    return np.all(np.rint(drawing.colors[:, :3] * 255) == np.rint(np.array(rgb) * 255), axis=1)


def _listed(labels: Iterable[str]) -> str:
    names = [repr(label) for label in labels]
    more = f" and {len(names) - _MAX_LISTED} more" if len(names) > _MAX_LISTED else ""
    return ", ".join(names[:_MAX_LISTED]) + more if names else "no layers"


def _place(center: NDArray[np.float64], size: tuple[int, int]) -> str:
    column, row = (
        min(max(int(3 * x / side), 0), 2) for x, side in zip(center.tolist(), (size[1], size[0]), strict=True)
    )
    return f"{_ROWS[row]} {_COLUMNS[column]}".strip() or "center"
