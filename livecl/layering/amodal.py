# SPDX-License-Identifier: Apache-2.0
"""A thing that something else lies across, in one piece: its visible parts, joined behind what hides the rest of it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

BoolArray = NDArray[np.bool_]
#: At most so many hidden pixels are joined to each visible one: no more is imagined than is seen. Without a limit, eyes
#: and mouth become one band behind a head with holes.
MOST_HIDDEN = 1.0


def completed(region: BoolArray, alike: BoolArray, hidden: BoolArray) -> BoolArray | None:
    """Return a region joined with other parts of its colour behind hidden pixels, or None if that cannot be.

    Parameters
    ----------
    region : (H, W) bool
        What is visible of a thing in one place.
    alike : (H, W) bool
        All pixels of its colour, the region's among them.
    hidden : (H, W) bool
        Pixels that are painted over whatever lies there.

    Returns
    -------
    (H, W) bool or None
        Of the pixels that are alike or hidden those that hang together with the region, within the convex hull of the
        parts joined: nothing else is to be painted. None where there is no other part to join, or more than
        `MOST_HIDDEN` would be hidden.
    """
    from skimage.measure import label
    from skimage.morphology import convex_hull_image

    start = tuple(np.argwhere(region)[0])
    labels = label(alike | hidden, connectivity=1)
    parts = alike & (labels == labels[start])
    if parts.sum() == region.sum():
        return None
    labels = label((alike | hidden) & convex_hull_image(parts), connectivity=1)
    joined = np.asarray(labels == labels[start])
    return joined if joined.sum() <= (1 + MOST_HIDDEN) * (joined & alike).sum() else None
