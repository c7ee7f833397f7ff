# SPDX-License-Identifier: Apache-2.0
"""Colours as CSS writes them, and the plain name of any colour."""

from __future__ import annotations

import colorsys
import functools
import math
import re
import reprlib

import numpy as np
from numpy.typing import ArrayLike, NDArray

Rgba = tuple[float, float, float, float]
FloatArray = NDArray[np.float64]

#: Longest text read as a colour, characters.
MAX_TEXT = 200

_HEX = re.compile(r"#([0-9a-f]{3,4}|[0-9a-f]{6}|[0-9a-f]{8})")
_FUNCTION = re.compile(r"(rgb|hsl)a?\(([^()]*)\)")

#: Basic names, each with typical colours that people call so.
BASIC_COLORS = {
    "black": "#000000 #121212",
    "dark gray": "#404040 #2a2d30",
    "gray": "#808080",
    "light gray": "#c4c4c4 #e0e0e0",
    "white": "#ffffff #f4f4f4",
    "dark red": "#840000",
    "red": "#e50000 #f8312f #c8202c",
    "pink": "#ff81c0 #ffb6c1 #ff69b4 #f08080",
    "magenta": "#c20078 #ff00ff #ff1493",
    "dark brown": "#3b2314",
    "brown": "#653700 #8b4513 #6d4534",
    "light brown": "#ad8150 #c69c6d",
    "beige": "#f5deb3 #e6daa6 #faebd7 #d2b48c",
    "peach": "#ffb07c #ffcba4",
    "orange": "#f97306 #ffa500 #ff7f50 #d2691e",
    "yellow": "#ffff14 #ffd700 #fcc73d #fff176 #dbb40c",
    "olive": "#6e750e #556b2f",
    "lime": "#aaff32 #9acd32",
    "light green": "#96f97b #98fb98 #8fbc8f",
    "green": "#15b01a #008000 #00ff00 #228b22 #2e8b57",
    "dark green": "#033500 #1c4422",
    "teal": "#029386 #008080",
    "turquoise": "#40e0d0 #06c2ac",
    "cyan": "#00ffff",
    "light blue": "#95d0fc #add8e6 #87ceeb",
    "blue": "#0343df #0000ff #1e90ff #00a6ed #4682b4",
    "dark blue": "#00035b #1f3a68",
    "lavender": "#c79fef",
    "purple": "#7e1e9c #9a0eea #9370db #6a5acd",
    "dark purple": "#35063e #433b6b",
}


def parse_rgba(text: str) -> Rgba:
    """Return the straight RGBA in [0, 1] of a CSS colour: a name, ``#`` and 3, 4, 6 or 8 digits, ``rgb()``, ``hsl()``.

    Raises
    ------
    ValueError
        If `text` is no such colour.
    """
    from PIL import ImageColor

    word = text.strip().lower() if len(text) <= MAX_TEXT else ""
    if word == "transparent":
        return 0.0, 0.0, 0.0, 0.0
    if word in ImageColor.colormap:
        red, green, blue = ImageColor.getrgb(word)[:3]
        return red / 255, green / 255, blue / 255, 1.0
    if match := _HEX.fullmatch(word):
        digits = match[1] if len(match[1]) > 4 else "".join(2 * digit for digit in match[1])
        levels = bytes.fromhex(digits.ljust(8, "f"))
        return levels[0] / 255, levels[1] / 255, levels[2] / 255, levels[3] / 255
    if match := _FUNCTION.fullmatch(word):
        parts = re.split(r"\s*[,/]\s*|\s+", match[2].strip())
        if len(parts) in (3, 4):
            try:
                alpha = share(parts[3]) if len(parts) == 4 else 1.0
                if match[1] == "rgb":
                    return share(parts[0], 255.0), share(parts[1], 255.0), share(parts[2], 255.0), alpha
                hue = float(parts[0].removesuffix("deg")) / 360 % 1
                if math.isfinite(hue):
                    return (*colorsys.hls_to_rgb(hue, share(parts[2], 100.0), share(parts[1], 100.0)), alpha)
            except ValueError:
                pass  # a part that is no number: reported like any other text that is no colour
    raise ValueError(
        f"got {text[:MAX_TEXT]!r}, wanted a colour: a CSS name such as 'white', '#rgb', '#rrggbb' or 'rgb(r, g, b)'"
    )


def parse_color(text: str) -> FloatArray:
    """Return the RGB in [0, 1], (3,), of an opaque CSS colour: ``white``, ``#rgb``, ``#rrggbb``, ``rgb(r, g, b)``.

    Raises
    ------
    ValueError
        If `text` is no colour, or a translucent one.
    """
    if not isinstance(text, str):
        raise ValueError(f"color: got {reprlib.repr(text)}, wanted text such as 'white' or '#rrggbb'")
    try:
        *rgb, alpha = parse_rgba(text)
    except ValueError as error:
        raise ValueError(f"color: {error}") from None
    if alpha < 1:
        raise ValueError(f"color: got {reprlib.repr(text)}, wanted an opaque colour")
    return np.array(rgb)


def share(text: str, whole: float = 1.0) -> float:
    """Return a number of `whole`, or a percentage, as a share clipped to [0, 1]; ValueError where it is neither."""
    text = text.strip()
    value = float(text[:-1]) / 100 if text.endswith("%") else float(text) / whole
    if math.isnan(value):
        raise ValueError(f"got {reprlib.repr(text)}, wanted a number or a percentage")
    return min(max(value, 0.0), 1.0)


def format_rgb(rgb: ArrayLike) -> str:
    """Return the first three of RGB(A) levels in [0, 1] as ``#rrggbb``, rounded to 8 bits."""
    red, green, blue = (round(level * 255) for level in np.asarray(rgb)[:3].tolist())
    return f"#{red:02x}{green:02x}{blue:02x}"


def color_names(rgb: ArrayLike) -> list[str]:
    """Return the basic name nearest to each sRGB colour (N, 3) in [0, 1], as the eye sees distance (Oklab)."""
    names, places = _basic_places()
    distances = np.linalg.norm(oklab(rgb)[:, None] - places, axis=-1)
    return [names[i] for i in distances.argmin(axis=1)]


def oklab(rgb: ArrayLike) -> FloatArray:
    """Return sRGB colours (..., 3) in [0, 1] in Oklab (lightness, green to red, blue to yellow): (..., 3).

    B. Ottosson: *A perceptual color space for image processing*, 2020. Euclidean distances follow seen differences.
    """
    rgb = np.asarray(rgb, dtype=np.float64)
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    cones = np.cbrt(
        linear
        @ np.array(
            [
                [0.4122214708, 0.2119034982, 0.0883024619],
                [0.5363325363, 0.6806995451, 0.2817188376],
                [0.0514459929, 0.1073969566, 0.6299787005],
            ]
        )
    )
    return cones @ np.array(
        [
            [0.2104542553, 1.9779984951, 0.0259040371],
            [0.7936177850, -2.4285922050, 0.7827717662],
            [-0.0040720468, 0.4505937099, -0.8086757660],
        ]
    )


@functools.cache
def _basic_places() -> tuple[list[str], FloatArray]:
    named = [(name, text) for name, texts in BASIC_COLORS.items() for text in texts.split()]
    return [name for name, _ in named], oklab([parse_color(text) for _, text in named])
