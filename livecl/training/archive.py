# SPDX-License-Identifier: Apache-2.0
"""Archives of arrays and facts: the file format of checkpoints, written atomically, and read without trust."""

from __future__ import annotations

import io
import json
import os
import zipfile
from typing import Any

import numpy as np

from livecl.drawing.drawing import Drawing
from livecl.drawing.fills import Fills
from livecl.drawing.strokes import Strokes
from livecl.files import write_atomically
from livecl.training.adam import Adam
from livecl.training.fills import FillMoments

Arrays = dict[str, Any]

#: Exceptions of reading a missing, truncated, changed or foreign file.
UNREADABLE = (
    OSError,
    LookupError,
    TypeError,
    ValueError,
    AttributeError,
    EOFError,
    RuntimeError,
    zipfile.BadZipFile,
)

_DRAWING_ARRAYS = ("points", "colors", "subpath_offsets", "layer_offsets", "stages", "names")
_FILLS_ARRAYS = ("kinds", "geometry", "stop_offsets", "stop_positions", "stop_colors")
_STROKES_ARRAYS = ("widths", "caps", "joins", "miter_limits", "is_open")


def write_archive(path: str | os.PathLike[str], facts: dict[str, Any], arrays: dict[str, Any]) -> None:
    """Write facts, which JSON can hold, and arrays by name, replacing an existing file atomically."""
    buffer = io.BytesIO()
    np.savez(buffer, facts=np.array(json.dumps(facts)), **arrays)
    write_atomically(path, buffer.getvalue())


def read_archive(path: str | os.PathLike[str]) -> tuple[dict[str, Any], Arrays]:
    """Return the facts and the arrays of a file; raises one of `UNREADABLE` if it is no archive."""
    with np.load(path, allow_pickle=False) as file:
        arrays = dict(file)
    facts = json.loads(str(arrays.pop("facts")))
    if not isinstance(facts, dict):
        raise ValueError("its facts are no table")
    return facts, arrays


def drawing_arrays(prefix: str, drawing: Drawing) -> dict[str, Any]:
    """Return a drawing's arrays by name; its size is not among them."""
    arrays = {prefix + name: getattr(drawing, name) for name in _DRAWING_ARRAYS}
    if any(drawing.groups):
        arrays[f"{prefix}groups"] = np.array(json.dumps(drawing.groups))
    if drawing.fills.any_gradients:
        arrays |= {f"{prefix}fills.{name}": getattr(drawing.fills, name) for name in _FILLS_ARRAYS}
    if drawing.strokes.any:
        arrays |= {f"{prefix}strokes.{name}": getattr(drawing.strokes, name) for name in _STROKES_ARRAYS}
    return arrays if drawing.background is None else {**arrays, f"{prefix}background": drawing.background}


def drawing_from(prefix: str, arrays: Arrays, size: tuple[int, int]) -> Drawing:
    """Return the drawing from the arrays of :func:`drawing_arrays`."""
    background = arrays.get(f"{prefix}background")
    fills = None
    if any(name.startswith(f"{prefix}fills.") for name in arrays):
        fills = Fills(**{name: arrays[f"{prefix}fills.{name}"] for name in _FILLS_ARRAYS})
    strokes = None
    if f"{prefix}strokes.widths" in arrays:
        strokes = Strokes(**{name: arrays[f"{prefix}strokes.{name}"] for name in _STROKES_ARRAYS})
    groups = json.loads(str(arrays[f"{prefix}groups"])) if f"{prefix}groups" in arrays else None
    values = {name: arrays[prefix + name] for name in _DRAWING_ARRAYS}
    return Drawing(size=size, background=background, fills=fills, strokes=strokes, groups=groups, **values)


def adam_arrays(name: str, adam: Adam) -> dict[str, Any]:
    """Return the moments' arrays by name."""
    return {f"adam.{name}.{field}": value for field, value in vars(adam).items()}


def adam_from(name: str, arrays: Arrays) -> Adam:
    """Return the moments from the arrays of :func:`adam_arrays`."""
    return Adam(**{field: arrays[f"adam.{name}.{field}"] for field in ("mean", "square", "ages")})


def fill_arrays(prefix: str, drawing: Drawing, moments: FillMoments) -> dict[str, Any]:
    """Return the arrays of fills' moments by name; none where all layers are solid."""
    if not drawing.fills.any_gradients:
        return {}
    return adam_arrays(f"{prefix}geometry", moments.geometry) | adam_arrays(f"{prefix}stops", moments.stops)


def fills_from(prefix: str, arrays: Arrays, drawing: Drawing) -> FillMoments:
    """Return the moments from the arrays of :func:`fill_arrays`."""
    if not drawing.fills.any_gradients:
        return FillMoments.start(drawing.fills)
    return FillMoments(adam_from(f"{prefix}geometry", arrays), adam_from(f"{prefix}stops", arrays))
