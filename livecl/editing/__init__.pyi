# SPDX-License-Identifier: Apache-2.0
from .borders import bordered as bordered
from .cutout import cut_out as cut_out
from .palette import with_few_colors as with_few_colors
from .simplify import editable as editable

__all__ = [
    "bordered",
    "cut_out",
    "editable",
    "with_few_colors",
]
