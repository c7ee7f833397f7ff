# SPDX-License-Identifier: Apache-2.0
"""Where things are in an SVG: lengths in px, transforms, view boxes, the size of the canvas.

Matrices are affine, (3, 3), and map column vectors (x, y, 1).
"""

from __future__ import annotations

import math
import re
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

#: Longest text read as a length, characters.
MAX_LENGTH_TEXT = 400

_PIXELS = {"": 1.0, "px": 1.0, "pt": 4 / 3, "pc": 16.0, "in": 96.0, "cm": 96 / 2.54, "mm": 9.6 / 2.54, "q": 2.4 / 2.54}
_LENGTH = re.compile(r"([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([a-zA-Z]*|%)")
_TRANSFORMS = re.compile(r"\s*(?:(?:matrix|translate|scale|rotate|skew)[xy]?\s*\([^()]*\)[\s,]*)*", re.IGNORECASE)


def length_in_pixels(text: str | None, default: float, reference: float) -> float:
    """Return a length in px; a percentage is one of `reference`; `default` stands for a length not given."""
    if text is None or text == "auto":
        return default
    match = _LENGTH.fullmatch(text.strip()) if len(text) <= MAX_LENGTH_TEXT else None
    if not match or (match[2] != "%" and match[2].lower() not in _PIXELS):
        raise ValueError(
            f"length {text[:60]!r} cannot be read; wanted a number, a percentage or px, pt, pc, mm, cm, in"
        )
    value = float(match[1]) * (reference / 100 if match[2] == "%" else _PIXELS[match[2].lower()])
    if not math.isfinite(value):
        raise ValueError(f"length {text[:60]!r} is not finite")
    return value


def transform_matrix(text: str | None) -> FloatArray:
    """Return the (3, 3) matrix of a ``transform`` attribute."""
    from svgelements import Matrix

    if not text or text == "none":
        return np.eye(3)
    if not _TRANSFORMS.fullmatch(text):
        raise ValueError(f"transform {text[:60]!r} cannot be read")
    try:
        m = Matrix(text)
        matrix = np.array([[m.a, m.c, m.e], [m.b, m.d, m.f], [0, 0, 1]], dtype=np.float64)
    except (ValueError, TypeError, IndexError, AttributeError) as error:
        raise ValueError(f"transform {text[:60]!r} cannot be read") from error
    if not np.isfinite(matrix).all():
        raise ValueError(f"transform {text[:60]!r} is not finite")
    return matrix


def view_box(element: Element) -> tuple[float, float, float, float] | None:
    """Return x, y, width, height of a ``viewBox``."""
    text = element.get("viewBox")
    if text is None:
        return None
    try:
        x, y, width, height = (float(part) for part in re.split(r"[\s,]+", text.strip()))
    except ValueError:
        raise ValueError(f"viewBox {text[:60]!r} cannot be read; wanted four numbers") from None
    if not (width > 0 and height > 0 and math.isfinite(x + y + width + height)):
        raise ValueError(f"viewBox {text[:60]!r} has no area")
    return x, y, width, height


def view_matrix(element: Element, width: float, height: float) -> FloatArray:
    """Return the (3, 3) matrix that fits an element's ``viewBox`` into a viewport of `width` by `height` px."""
    box = view_box(element)
    if box is None:
        return np.eye(3)
    words = element.get("preserveAspectRatio", "").split() or ["xMidYMid"]
    scale_x, scale_y = width / box[2], height / box[3]
    if words[0] != "none":
        scale_x = scale_y = (max if "slice" in words else min)(scale_x, scale_y)
    left = {"xMin": 0.0, "xMax": 1.0}.get(words[0][:4], 0.5) * (width - scale_x * box[2])
    top = {"YMin": 0.0, "YMax": 1.0}.get(words[0][4:], 0.5) * (height - scale_y * box[3])
    return np.array([[scale_x, 0, left - scale_x * box[0]], [0, scale_y, top - scale_y * box[1]], [0, 0, 1]])


def canvas_size(root: Element) -> tuple[float, float]:
    """Return width and height of the canvas, px; a side not stated follows from the ``viewBox``."""
    box = view_box(root)
    sides = [
        length_in_pixels(root.get(name), 0.0, box[2 + i] if box else 0.0) for i, name in enumerate(("width", "height"))
    ]
    if min(sides) < 0:
        raise ValueError("its width or height is negative")
    if box and not any(sides):
        sides = [box[2], box[3]]
    elif box and not all(sides):
        ratio = box[2] / box[3]
        sides = [sides[0] or sides[1] * ratio, sides[1] or sides[0] / ratio]
    if not all(sides):
        raise ValueError("states no size; give its <svg> element a width and a height, or a viewBox")
    return sides[0], sides[1]


def translation(x: float, y: float) -> FloatArray:
    """Return the (3, 3) matrix of a shift by (x, y) px."""
    return np.array([[1.0, 0.0, x], [0.0, 1.0, y], [0.0, 0.0, 1.0]])
