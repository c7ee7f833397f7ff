# SPDX-License-Identifier: Apache-2.0
from .simplify import editable as editable

__all__ = [
    "editable",
]
