# SPDX-License-Identifier: Apache-2.0
"""Count the numbers of an SVG file's outlines, as a measure of the effort to edit them."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET

from livecl.svg.path_data import NUMBER

_NUMBER = re.compile(NUMBER)
#: Arcs, and their flags, which need no separator, after the first three numbers.
_ARC = re.compile(r"([Aa])([^A-Za-z]*)")
_FLAGS = re.compile(rf"(({NUMBER})[\s,]*({NUMBER})[\s,]*({NUMBER})[\s,]*)([01])[\s,]*([01])")
#: Attributes with numbers of outlines.
_ATTRIBUTES = ("d", "points", "x", "y", "x1", "y1", "x2", "y2", "cx", "cy", "r", "rx", "ry", "width", "height")
_ELEMENTS = ("path", "polygon", "polyline", "line", "circle", "ellipse", "rect")


def count_numbers(svg: bytes | str) -> int:
    """Count the coordinates, lengths and angles of an SVG file's shapes, those of transforms included.

    >>> count_numbers('<svg><path d="M0 0h9v9z"/><circle cx="3" cy="4" r="1"/></svg>')
    7
    """
    count = 0
    for element in ET.fromstring(svg).iter():
        if str(element.tag).rpartition("}")[2] not in _ELEMENTS:
            continue
        for name in (*_ATTRIBUTES, "transform"):
            if text := element.get(name):
                spaced = _ARC.sub(lambda arc: arc[1] + _FLAGS.sub(r"\1 \5 \6 ", arc[2]), text) if name == "d" else text
                count += len(_NUMBER.findall(spaced))
    return count
