# SPDX-License-Identifier: Apache-2.0
"""Fill and opacity of an SVG element, and the properties without a counterpart in a `Drawing`."""

from __future__ import annotations

import collections
import functools
import re
from collections.abc import Mapping
from typing import Literal, NamedTuple

import tinycss2

from livecl.drawing.colors import Rgba, parse_rgba, share
from livecl.svg.coordinates import is_length

_LEFT_OUT_PROPERTIES = {
    "animation": "animations",
    "animation-name": "animations",
    "clip": "clips",
    "clip-path": "clips",
    "filter": "filters",
    "mask": "masks",
    "mask-image": "masks",
    "mix-blend-mode": "blend modes",
    "marker": "markers",
    "marker-start": "markers",
    "marker-mid": "markers",
    "marker-end": "markers",
    "offset-path": "transform properties",
    "rotate": "transform properties",
    "scale": "transform properties",
    "translate": "transform properties",
    "viewport-fill": "backgrounds",
}
_NOTHING = (None, "none", "normal", "auto", "")
_OPACITIES = {"opacity", "fill-opacity", "stroke-opacity", "stop-opacity"}
_WORDS = {
    "fill-rule": {"nonzero", "evenodd"},
    "stroke-linecap": {"butt", "round", "square"},
    "stroke-linejoin": {"miter", "miter-clip", "round", "bevel", "arcs"},
    "visibility": {"visible", "hidden", "collapse"},
}


class WrittenPaint(NamedTuple):
    """A paint as written: the id of a paint server, or None; the colour, "none", or None if there is only a server."""

    server: str | None
    color: str | None


@functools.lru_cache(maxsize=4096)
def parse_paint(text: str) -> WrittenPaint:
    """Parse a ``fill`` or ``stroke``; ValueError if it is invalid."""
    tokens = [
        token for token in tinycss2.parse_component_value_list(text) if token.type not in ("whitespace", "comment")
    ]
    server = None
    if tokens and tokens[0].type == "url":
        server = tokens.pop(0).value
    elif tokens and tokens[0].type == "function" and tokens[0].lower_name == "url":
        server = "".join(token.value for token in tokens.pop(0).arguments if token.type == "string")
    if tokens and tokens[-1].type == "function" and tokens[-1].lower_name == "icc-color":
        tokens.pop()  # after the colour in sRGB
    rest = tinycss2.serialize(tokens).strip()
    if rest.lower() not in ("none", "currentcolor") and (rest or server is None):
        parse_rgba(rest)
    return WrittenPaint(None if server is None else server.strip().removeprefix("#"), rest or None)


def is_valid(name: str, value: str) -> bool:
    """Return whether a property's value is valid; True for properties that are not checked."""
    try:
        if name in ("fill", "stroke"):
            parse_paint(value)
        elif name in ("color", "stop-color"):
            if value.lower() != "currentcolor":
                parse_rgba(value)
        elif name in _OPACITIES:
            share(value)
        elif name in ("stroke-width", "stroke-dashoffset"):
            return is_length(value)
        elif name in _WORDS:
            return value.lower() in _WORDS[name]
    except ValueError:
        return False
    return True


def solid_color(
    color: str, style: Mapping[str, str], opacity: float, name: Literal["fill", "stroke"] = "fill"
) -> Rgba | None:
    """Return the straight RGBA of a fill or stroke of one colour; None for ``none``."""
    if color.lower() == "currentcolor":
        color = style.get("color", "black")
    if color.lower() == "none":
        return None
    red, green, blue, alpha = (0.0, 0.0, 0.0, 1.0) if color.lower() == "currentcolor" else parse_rgba(color)
    opacity *= alpha * opacity_of(style.get(f"{name}-opacity"))
    return red, green, blue, as_saved(opacity)


def as_saved(opacity: float) -> float:
    """Return an opacity, made the multiple of 1/255 that agrees with it to five decimals, if there is one."""
    level = round(opacity * 255) / 255
    return level if abs(opacity - level) < 6e-6 else opacity


def opacity_of(text: str | None) -> float:
    """Parse an opacity; 1 if it is not given or invalid, as CSS ignores it."""
    try:
        return 1.0 if text is None else share(text)
    except ValueError:
        return 1.0


def is_stroked(style: Mapping[str, str]) -> bool:
    """Return whether a shape has a stroke that is read: a visible one, or an invisible one if it has no fill either."""
    return (
        style.get("stroke", "none").lower() not in ("none", "transparent")
        and (opacity_of(style.get("stroke-opacity")) > 0 or style.get("fill", "").lower() == "none")
        and re.fullmatch(r"[0.]*[a-z%]*", style.get("stroke-width", "1").strip()) is None
    )


def background_color(own: Mapping[str, str], left_out: collections.Counter[str]) -> Rgba | None:
    """Return the canvas colour, straight RGBA, from the root element's style; None if it is transparent."""
    color = own.get("background-color", own.get("background", "transparent")).lower()
    if color in ("none", "initial"):
        return None
    try:
        rgba = parse_rgba(own.get("color", "black") if color == "currentcolor" else color)
    except ValueError:
        left_out["backgrounds"] += 1
        return None
    return None if rgba[3] == 0 else rgba


def count_left_out(own: Mapping[str, str], left_out: collections.Counter[str]) -> None:
    """Count an element's properties that a `Drawing` cannot represent."""
    for kind in {_LEFT_OUT_PROPERTIES[name] for name in _LEFT_OUT_PROPERTIES if own.get(name) not in _NOTHING}:
        left_out[kind] += 1
