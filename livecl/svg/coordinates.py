# SPDX-License-Identifier: Apache-2.0
"""Coordinates of SVG: lengths in px, transforms, view boxes, the size of the canvas.

Matrices are affine, (3, 3), and map column vectors (x, y, 1).
"""

from __future__ import annotations

import collections
import dataclasses
import math
import re
from collections.abc import Mapping
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np

from livecl.arrays import FloatArray

#: Longest text read as a length, characters.
MAX_LENGTH_TEXT = 400
#: Font size where none is stated, px (CSS's `medium`), and the canvas where none is stated (CSS 2.1, 10.3.2).
FONT_SIZE, CANVAS = 16.0, (300.0, 150.0)

_PIXELS = {"": 1.0, "px": 1.0, "pt": 4 / 3, "pc": 16.0, "in": 96.0, "cm": 96 / 2.54, "mm": 9.6 / 2.54, "q": 2.4 / 2.54}
_OF_FONT = {"em": 1.0, "ex": 0.5, "ch": 0.5, "cap": 0.7, "ic": 1.0, "lh": 1.2}
_OF_ROOT_FONT = {"rem": 1.0, "rex": 0.5, "rch": 0.5, "rlh": 1.2}
_FONT_SIZES = {
    **{"xx-small": 9 / 16, "x-small": 10 / 16, "small": 13 / 16, "medium": 1.0},
    **{"large": 18 / 16, "x-large": 24 / 16, "xx-large": 32 / 16, "xxx-large": 48 / 16},
}
_LENGTH = re.compile(r"([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([a-zA-Z]*|%)")
_ANGLES = {"": 1.0, "deg": 1.0, "grad": 0.9, "turn": 360.0, "rad": 180 / math.pi}


@dataclasses.dataclass(frozen=True, kw_only=True)
class Units:
    """Reference of relative units of length: font sizes and the canvas, px; `guesses` counts assumptions."""

    font: float = FONT_SIZE
    root_font: float = FONT_SIZE
    canvas: tuple[float, float] = CANVAS
    guesses: collections.Counter[str] = dataclasses.field(default_factory=collections.Counter)

    def pixels(self, unit: str) -> float | None:
        """Return the px of one unit; None if it is unknown."""
        unit = unit.lower()
        width, height = self.canvas
        of_canvas = {"vw": width, "vi": width, "vh": height, "vb": height, "vmin": min(width, height)}
        of_canvas["vmax"] = max(width, height)
        if unit in _PIXELS:
            return _PIXELS[unit]
        if unit in of_canvas or (unit not in ("em", "ex") and unit in _OF_FONT | _OF_ROOT_FONT):
            self.guesses["lengths in units of the page or of the font's letters"] += 1
        if unit in of_canvas:
            return of_canvas[unit] / 100
        if unit in _OF_FONT:
            return self.font * _OF_FONT[unit]
        return self.root_font * _OF_ROOT_FONT[unit] if unit in _OF_ROOT_FONT else None


def length_in_pixels(text: str | None, default: float, reference: float, units: Units | None = None) -> float:
    """Return a length in px, or `default` if it is None; percentages are of `reference`."""
    if text is None or text == "auto":
        return default
    match = _LENGTH.fullmatch(text.strip()) if len(text) <= MAX_LENGTH_TEXT else None
    pixels = None
    if match:
        pixels = reference / 100 if match[2] == "%" else (units or Units()).pixels(match[2])
    if match is None or pixels is None:
        raise ValueError(
            f"length {text[:60]!r} cannot be read; wanted a number, a percentage or px, pt, pc, mm, cm, in, em, ex"
        )
    value = float(match[1]) * pixels
    if not math.isfinite(value):
        raise ValueError(f"length {text[:60]!r} is not finite")
    return value


def is_length(text: str) -> bool:
    """Return whether a length can be read."""
    try:
        length_in_pixels(text, 0.0, 0.0)
    except ValueError:
        return False
    return True


def font_size(own: Mapping[str, str], around: Units) -> float:
    """Return the font size of an element, px; that of its parent if none is stated or it cannot be read."""
    text = own.get("font-size")
    if text is None and "font" in own:  # size[/line height] stands before the family
        text = next((word.partition("/")[0] for word in own["font"].split() if word[0] in "0123456789."), None)
    if text is None:
        return around.font
    word = text.strip().lower()
    if word in _FONT_SIZES:
        return FONT_SIZE * _FONT_SIZES[word]
    if word in ("larger", "smaller"):
        return around.font * (1.2 if word == "larger" else 1 / 1.2)
    try:
        return max(0.0, length_in_pixels(word, around.font, around.font, around))
    except ValueError:
        return around.font


def transform_matrix(
    text: str | None, viewport: tuple[float, float] = (0.0, 0.0), units: Units | None = None
) -> FloatArray:
    """Return the (3, 3) matrix of a ``transform``, as an attribute or as CSS writes it.

    Parameters
    ----------
    text : str or None
        The transform; None and ``none`` are the identity.
    viewport : (float, float)
        Width and height that percentages refer to, px.
    units : Units, optional
        Reference of relative units.
    """
    import tinycss2

    matrix = np.eye(3)
    if not text or text == "none":
        return matrix
    text = re.sub(r"([a-zA-Z])\s+\(", r"\1(", text)  # a space that attributes allow, and CSS does not
    for token in tinycss2.parse_component_value_list(text, skip_comments=True):
        if token.type == "whitespace" or token == ",":
            continue
        step = _transform_step(token, viewport, units) if token.type == "function" else None
        if step is None:
            raise ValueError(f"transform {text[:60]!r} cannot be read")
        matrix = matrix @ step
    if not np.isfinite(matrix).all():
        raise ValueError(f"transform {text[:60]!r} is not finite")
    return matrix


def _transform_step(function: Any, viewport: tuple[float, float], units: Units | None) -> FloatArray | None:
    """Return the matrix of a function of tinycss2; None if it is unknown or its arguments are wrong."""
    name = function.lower_name
    arguments = [token for token in function.arguments if token.type not in ("whitespace", "comment") and token != ","]
    numbers = []
    for i, token in enumerate(arguments):
        if token.type not in ("number", "percentage", "dimension"):
            return None
        unit: str = token.unit.lower() if token.type == "dimension" else "%" if token.type == "percentage" else ""
        is_length = name.startswith("translate") or (name == "rotate" and i) or (name == "matrix" and i > 3)
        is_angle = name.startswith("skew") or (name == "rotate" and not i)
        if unit == "%" and name.startswith("translate"):
            per_unit: float | None = viewport[1 if i or name.endswith("y") else 0] / 100
        elif unit == "%":
            per_unit = 0.01 if name.startswith("scale") else None
        elif is_angle:
            per_unit = _ANGLES.get(unit)
        else:
            per_unit = (units or Units()).pixels(unit) if is_length or not unit else None
        if per_unit is None:
            return None
        numbers.append(token.value * per_unit)
    a, *rest = numbers or [0.0]
    count = len(numbers)
    if name == "matrix" and count == 6:
        return np.array([[a, rest[1], rest[3]], [rest[0], rest[2], rest[4]], [0, 0, 1]])
    if name in ("translate", "translatex", "translatey") and (count == 1 or (count == 2 and name == "translate")):
        return translation(0.0 if name == "translatey" else a, a if name == "translatey" else (*rest, 0.0)[0])
    if name in ("scale", "scalex", "scaley") and (count == 1 or (count == 2 and name == "scale")):
        both = (a, (*rest, a)[0]) if name == "scale" else (a, 1.0) if name == "scalex" else (1.0, a)
        return np.diag([*both, 1.0])
    if name == "rotate" and count in (1, 3):
        cos, sin = math.cos(math.radians(a)), math.sin(math.radians(a))
        turn = np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]])
        return translation(*rest) @ turn @ translation(-rest[0], -rest[1]) if rest else turn
    if name in ("skew", "skewx", "skewy") and (count == 1 or (count == 2 and name == "skew")):
        x, y = (0.0, a) if name == "skewy" else (a, (*rest, 0.0)[0])
        return np.array([[1, math.tan(math.radians(x)), 0], [math.tan(math.radians(y)), 1, 0], [0, 0, 1]])
    return None


def transform_origin(text: str | None, viewport: tuple[float, float], units: Units) -> tuple[float, float]:
    """Return the origin of a transform; words and percentages refer to the viewport."""
    words = (text or "").lower().split()
    if (words and words[0] in ("top", "bottom")) or (len(words) > 1 and words[1] in ("left", "right")):
        words = [*words[1:2], words[0]] if len(words) > 1 else ["center", words[0]]
    if len(words) == 1:
        words.append("center")
    shares = {"left": "0%", "top": "0%", "center": "50%", "right": "100%", "bottom": "100%"}
    x, y = (
        length_in_pixels(shares.get(word, word), 0.0, side, units)
        for word, side in zip(words[:2] or ("0", "0"), viewport, strict=True)
    )
    return x, y


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


def canvas_size(root: Element, own: Mapping[str, str], units: Units) -> tuple[float, float]:
    """Return width and height of the canvas, px, from the ``<svg>`` element and its attributes and properties.

    A side not stated follows from the ``viewBox``; without one, it is CSS's default, which `units` counts as a guess.
    """
    box = view_box(root)
    references = box[2:] if box else CANVAS
    sides = [
        None if own.get(name, "auto") == "auto" else length_in_pixels(own[name], 0.0, reference, units)
        for name, reference in zip(("width", "height"), references, strict=True)
    ]
    if any(side is not None and side < 0 for side in sides):
        raise ValueError("its width or height is negative")
    if 0.0 in sides:
        raise ValueError("its width or height is 0, so nothing of it is shown")
    width, height = sides
    if box is None:
        if None in sides or any("%" in own[name] for name in ("width", "height")):
            units.guesses["sides of the canvas, not stated and taken as 300 by 150 px"] += 1
        return width or CANVAS[0], height or CANVAS[1]
    if width is None and height is None:
        return box[2], box[3]
    ratio = box[2] / box[3]
    return width or (height or 0.0) * ratio, height or (width or 0.0) / ratio


def translation(x: float, y: float) -> FloatArray:
    """Return the (3, 3) matrix of a shift by (x, y) px."""
    return np.array([[1.0, 0.0, x], [0.0, 1.0, y], [0.0, 0.0, 1.0]])
