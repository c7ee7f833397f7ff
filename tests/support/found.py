# SPDX-License-Identifier: Apache-2.0
"""Flat regions and strokes of a picture, found in one call."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from livecl import Drawing
from livecl.layering.context import Context
from livecl.layering.segmentation.flat import FlatRegions, clean_regions, noisy_regions
from livecl.layering.strokes.finding import find_line_art, kept_strokes


def flat_regions(image: NDArray[np.floating]) -> FlatRegions:
    """Segment a picture (H, W, C) into flat regions with resolved borders."""
    noisy = noisy_regions(image)
    return clean_regions(image) if noisy is None else noisy


def find_strokes(context: Context, background: NDArray[np.floating] | None) -> Drawing:
    """Find the strokes of line art, a layer for each combination of ink and width; no layers for other pictures."""
    return kept_strokes(context, find_line_art(context, background))
