# SPDX-License-Identifier: Apache-2.0
"""`Drawing` and SVG, both ways.

What is saved is what a drawing holds after :func:`quantize`, to the last digit: :func:`read_svg` gives it back equal.
"""

from __future__ import annotations

from livecl.colors import parse_color
from livecl.svg_reader import read_svg
from livecl.svg_writer import LayerStyle, format_svg, quantize, save_svg

__all__ = ["LayerStyle", "format_svg", "parse_color", "quantize", "read_svg", "save_svg"]
