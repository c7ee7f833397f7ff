# SPDX-License-Identifier: Apache-2.0
"""What an SVG element is painted with: fill and opacity; and what of its style has no counterpart in a `Drawing`."""

from __future__ import annotations

import collections
import re
from collections.abc import Mapping

from livecl.drawing.colors import Rgba, parse_rgba, share

_LEFT_OUT_PROPERTIES = {
    "clip-path": "clips",
    "mask": "masks",
    "filter": "filters",
    "mix-blend-mode": "blend modes",
    "marker": "markers",
    "marker-start": "markers",
    "marker-mid": "markers",
    "marker-end": "markers",
}
_URL = re.compile(r"url\([^)]*\)\s*(.*)", re.DOTALL)


def fill_color(style: Mapping[str, str], opacity: float, left_out: collections.Counter[str]) -> Rgba | None:
    """Return straight RGBA of the fill, None where nothing is filled; count in `left_out` what cannot be read.

    Parameters
    ----------
    style : mapping of str
        Inherited properties.
    opacity : float
        Product of the opacities of the element and those around it.
    left_out : Counter
        Kinds of what is not represented.
    """
    paint = style.get("fill", "black").strip()
    if match := _URL.fullmatch(paint):
        left_out["gradient or pattern fills"] += 1
        paint = match[1].strip() or "none"
    if paint.lower() == "currentcolor":
        paint = style.get("color", "black")
    if paint == "none":
        return None
    try:
        red, green, blue, alpha = parse_rgba(paint)
    except ValueError:
        left_out["unknown colours read as black"] += 1
        red, green, blue, alpha = 0.0, 0.0, 0.0, 1.0
    opacity *= alpha * opacity_of(style.get("fill-opacity"))
    level = round(opacity * 255) / 255  # a saved opacity is a multiple of 1/255, written to five decimals
    return red, green, blue, level if abs(opacity - level) < 6e-6 else opacity


def opacity_of(text: str | None) -> float:
    """Return an opacity; one that is not given or cannot be read is 1, as CSS ignores it."""
    try:
        return 1.0 if text is None else share(text)
    except ValueError:
        return 1.0


def is_stroked(style: Mapping[str, str]) -> bool:
    """Return whether an outline would be drawn."""
    return (
        style.get("stroke", "none") not in ("none", "transparent")
        and opacity_of(style.get("stroke-opacity")) > 0
        and re.fullmatch(r"[0.]*[a-z%]*", style.get("stroke-width", "1").strip()) is None
    )


def count_left_out(own: Mapping[str, str], left_out: collections.Counter[str]) -> None:
    """Count an element's properties that a `Drawing` cannot represent."""
    for kind in {_LEFT_OUT_PROPERTIES[name] for name in _LEFT_OUT_PROPERTIES if own.get(name) not in _NOTHING}:
        left_out[kind] += 1
    if own.get("transform-origin") is not None and own.get("transform", "none") not in _NOTHING:
        left_out["transform origins"] += 1


_NOTHING = (None, "none", "normal", "")
