# SPDX-License-Identifier: Apache-2.0
from .animated import format_animated_svg as format_animated_svg
from .animated import save_animated_svg as save_animated_svg
from .groups import GroupKind as GroupKind
from .reader import read_svg as read_svg
from .writer import LayerStyle as LayerStyle
from .writer import format_svg as format_svg
from .writer import quantize as quantize
from .writer import save_svg as save_svg

__all__ = [
    "GroupKind",
    "LayerStyle",
    "format_animated_svg",
    "format_svg",
    "quantize",
    "read_svg",
    "save_animated_svg",
    "save_svg",
]
