# SPDX-License-Identifier: Apache-2.0
"""Parse and format CSS colours; convert sRGB to Oklab."""

from __future__ import annotations

import functools
import math
import reprlib

import numpy as np
from numpy.typing import ArrayLike

from livecl.arrays import FloatArray

Rgba = tuple[float, float, float, float]

#: Longest text read as a colour, characters.
MAX_TEXT = 200


@functools.lru_cache(maxsize=4096)
def parse_rgba(text: str) -> Rgba:
    """Parse a CSS colour to straight RGBA in [0, 1]: a name, ``#`` and digits, ``rgb()``, ``hsl()``, ``hwb()``.

    Raises ValueError if `text` is no such colour.
    """
    from tinycss2 import color4

    try:
        color = color4.parse_color(text.strip()) if len(text) <= MAX_TEXT else None
        if isinstance(color, color4.Color):
            if color.space == "hsl":
                hue, saturation, lightness = (coordinate or 0.0 for coordinate in color.coordinates)
                color = color4.Color("hsl", (hue, min(saturation, 100.0), lightness), color.alpha)
            red, green, blue, alpha = color.to("srgb")
            if math.isfinite(red + green + blue + alpha):
                return _clip(red), _clip(green), _clip(blue), _clip(alpha)
    except (ValueError, NotImplementedError):
        pass  # color() without arguments, and unsupported colour spaces: refused like other text
    raise ValueError(
        f"got {text[:MAX_TEXT]!r}, wanted a colour: a CSS name such as 'white', '#rgb', '#rrggbb' or 'rgb(r, g, b)'"
    )


def parse_color(text: str) -> FloatArray:
    """Return the RGB in [0, 1], (3,), of an opaque CSS colour: ``white``, ``#rgb``, ``#rrggbb``, ``rgb(r, g, b)``.

    Raises ValueError if `text` is no colour, or a translucent one.
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
    """Parse a number (of `whole`) or a percentage as a share clipped to [0, 1]; ValueError if it is neither."""
    text = text.strip()
    value = float(text[:-1]) / 100 if text.endswith("%") else float(text) / whole
    if math.isnan(value):
        raise ValueError(f"got {reprlib.repr(text)}, wanted a number or a percentage")
    return _clip(value)


def premultiplied_colors(rgba: FloatArray) -> FloatArray:
    """Convert straight RGBA to premultiplied RGBA: (..., 4)."""
    return np.concatenate([rgba[..., :3] * rgba[..., 3:], rgba[..., 3:]], axis=-1)


def _clip(value: float) -> float:
    return min(max(value, 0.0), 1.0)


def format_rgb(rgb: ArrayLike) -> str:
    """Format the first three of RGB(A) levels in [0, 1] as ``#rrggbb``, rounded to 8 bits."""
    red, green, blue = (round(level * 255) for level in np.asarray(rgb)[:3].tolist())
    return f"#{red:02x}{green:02x}{blue:02x}"


def oklab(rgb: ArrayLike) -> FloatArray:
    """Convert sRGB colours (..., 3) in [0, 1] to Oklab (lightness, green to red, blue to yellow): (..., 3).

    B. Ottosson: *A perceptual color space for image processing*, 2020. Euclidean distances approximate perceived ones.
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
