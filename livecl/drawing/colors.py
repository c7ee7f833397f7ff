# SPDX-License-Identifier: Apache-2.0
"""Colours as CSS writes them, and in Oklab."""

from __future__ import annotations

import colorsys
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
