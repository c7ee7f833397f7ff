# SPDX-License-Identifier: Apache-2.0
from .reading import as_image as as_image
from .reading import over_background as over_background
from .reading import premultiplied as premultiplied
from .reading import read_image as read_image
from .reading import save_image as save_image
from .resizing import reduced as reduced

__all__ = [
    "as_image",
    "over_background",
    "premultiplied",
    "read_image",
    "reduced",
    "save_image",
]
