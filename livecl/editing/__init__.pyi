# SPDX-License-Identifier: Apache-2.0
from .palette import with_few_colors as with_few_colors
from .simplify import editable as editable

__all__ = [
    "editable",
    "with_few_colors",
]
