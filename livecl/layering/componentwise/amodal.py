# SPDX-License-Identifier: Apache-2.0
"""Amodal completion on masks: join the visible parts of an occluded region, for the placement by regions."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from livecl.layering.componentwise.masks import connected_part, convex_hull
from livecl.layering.stack import Window, window_of

BoolArray = NDArray[np.bool_]
#: Largest ratio of hidden to visible pixels: no more is completed than is visible. Without a limit, eyes
#: and mouth become one band behind a head with holes.
MAX_HIDDEN = 1.0


@dataclasses.dataclass(frozen=True)
class Completion:
    """A region joined with others, within a window, or None; and the window that holds all on which this depends.

    More hidden pixels change it only if they touch the `reach`.
    """

    window: Window
    mask: BoolArray | None
    reach: Window


def amodally_completed(region: BoolArray, alike: BoolArray, hidden: BoolArray) -> Completion:
    """Complete a region (H, W): join it with other parts of its colour behind hidden pixels.

    `alike` (H, W) are all pixels of its colour, `hidden` (H, W) those painted over whatever lies there. The result is
    of the pixels that are alike or hidden those that hang together with the region, within the convex hull of the parts
    joined; None if there is no other part to join, or if more than `MAX_HIDDEN` would be hidden.
    """
    start = tuple(np.argwhere(region)[0])
    whole = connected_part(alike | hidden, start)
    window = window_of(whole)
    reach = slice(window[0].start - 1, window[0].stop + 1), slice(window[1].start - 1, window[1].stop + 1)
    alike, whole = alike[window], whole[window]
    parts = alike & whole
    if np.count_nonzero(parts) == np.count_nonzero(region):
        return Completion(window, None, reach)
    joined = connected_part(whole & convex_hull(parts), (start[0] - window[0].start, start[1] - window[1].start))
    found = np.count_nonzero(joined) <= (1 + MAX_HIDDEN) * np.count_nonzero(joined & alike)
    return Completion(window, joined if found else None, reach)
