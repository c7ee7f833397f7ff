# SPDX-License-Identifier: Apache-2.0
"""Amodal completion on masks: join the visible parts of an occluded region, for the placement by regions.

livecl/layering/outlines/completion.py completes outlines, which have a price. Here thousands of candidates are tried
before any of them has an outline, and the error decides, so masks are completed.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from livecl.arrays import BoolArray, Window
from livecl.layering.componentwise.masks import connected_part, convex_hull
from livecl.layering.stack import window_of

#: Largest ratio of hidden to visible pixels in a completed region. Without a limit, eyes and mouth become one band
#: behind a head with holes.
MAX_HIDDEN = 1.0


@dataclasses.dataclass(frozen=True)
class Completion:
    """Result of amodal completion: the mask within `window`, or None, and the window it depends on.

    Newly hidden pixels can change the result only if they touch `reach`.
    """

    window: Window
    mask: BoolArray | None
    reach: Window


def amodally_completed(region: BoolArray, alike: BoolArray, hidden: BoolArray) -> Completion:
    """Complete a region (H, W): join it with other parts of its colour behind hidden pixels.

    `alike` (H, W) marks all pixels of its colour, `hidden` (H, W) those covered by opaque layers. The result is the
    connected set of alike or hidden pixels that holds the region, within the convex hull of the joined parts; None if
    there is no other part, or if the ratio of hidden to visible pixels would exceed `MAX_HIDDEN`.
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
