# SPDX-License-Identifier: Apache-2.0
"""Convert the colours of a picture to sRGB: colour profiles, PNG gamma, CMYK, Lab."""

from __future__ import annotations

import io
import warnings
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from livecl.arrays import Float32Array

if TYPE_CHECKING:
    from PIL.Image import Image

#: Exponent of sRGB in terms of PNG's gamma; and the largest deviation from 1 of a correcting exponent that is ignored:
#: writers of sRGB state 1/2.2, which is slightly off, and some about 1/2.3.
_GAMMA, _NEGLIGIBLE = 2.2, 0.05
#: Least and largest credible gamma.
_GAMMAS = (0.1, 10.0)


def in_srgb(name: str, image: Image, info: Mapping[Any, Any]) -> Float32Array:
    """Convert an 8-bit L, RGB, CMYK or LAB picture to sRGB, by its colour profile if it has one.

    Parameters
    ----------
    name : str
        Name of the image in a warning.
    image : PIL.Image.Image
        Pixels.
    info : mapping
        Metadata of the file on colours: Pillow's ``icc_profile``, ``gamma``, ``srgb``.

    Returns
    -------
    (H, W, 3) float32
        In [0, 1].
    """
    from PIL import ImageCms

    profile = other_profile(info)
    try:
        if profile:
            source = ImageCms.ImageCmsProfile(io.BytesIO(profile))
        elif image.mode == "LAB":
            source = ImageCms.ImageCmsProfile(ImageCms.createProfile("LAB"))
        if profile or image.mode == "LAB":
            converted = ImageCms.profileToProfile(image, source, ImageCms.createProfile("sRGB"), outputMode="RGB")
            return _shares(converted or image)
    except (ImageCms.PyCMSError, OSError, ValueError, TypeError):
        warnings.warn(f"{name}: its colour profile cannot be applied; colours are taken as sRGB", stacklevel=5)
    return without_gamma(_shares(image), info)


def other_profile(info: Mapping[Any, Any]) -> bytes | None:
    """Return a picture's colour profile; None if it has none, or one named sRGB."""
    from PIL import ImageCms

    profile: bytes | None = info.get("icc_profile") or None
    try:
        if profile and "srgb" in ImageCms.getProfileDescription(ImageCms.ImageCmsProfile(io.BytesIO(profile))).lower():
            return None
    except (ImageCms.PyCMSError, OSError, TypeError):
        pass  # unreadable: the caller that applies it warns
    return profile


def without_gamma(color: Float32Array, info: Mapping[Any, Any]) -> Float32Array:
    """Convert colours to sRGB if a PNG states a gamma, but neither sRGB nor a profile, which take precedence.

    The file's numbers are light to the power of gamma; those of sRGB, in PNG's terms, light to the power of 1/2.2.
    """
    gamma = info.get("gamma")
    if gamma is None or "srgb" in info or info.get("icc_profile") or not _GAMMAS[0] <= gamma <= _GAMMAS[1]:
        return color
    exponent = 1 / (_GAMMA * gamma)
    if abs(exponent - 1) <= _NEGLIGIBLE:
        return color
    return np.power(color, np.float32(exponent), dtype=np.float32)


def _shares(image: Image) -> Float32Array:
    rgb: Float32Array = np.array(image.convert("RGB"), dtype=np.float32)
    rgb /= np.float32(255)
    return rgb
