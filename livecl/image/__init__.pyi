# SPDX-License-Identifier: Apache-2.0
from .masks import Masks as Masks
from .masks import read_masks as read_masks
from .reading import as_image as as_image
from .reading import over_background as over_background
from .reading import premultiplied as premultiplied
from .reading import read_image as read_image
from .reading import save_image as save_image
from .resizing import reduced as reduced

__all__ = [
    "Masks",
    "as_image",
    "over_background",
    "premultiplied",
    "read_image",
    "read_masks",
    "reduced",
    "save_image",
]
