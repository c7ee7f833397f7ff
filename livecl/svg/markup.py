# SPDX-License-Identifier: Apache-2.0
"""Escape text and attributes of XML, as `xml.sax.saxutils` does, which would import the modules of HTTP and mail."""

from __future__ import annotations

#: Characters that are escaped in attributes only, beside quotes.
_BLANKS = {"\n": "&#10;", "\r": "&#13;", "\t": "&#9;"}


def escape(text: str) -> str:
    """Return text with ``&``, ``<`` and ``>`` as entities."""
    return text.replace("&", "&amp;").replace(">", "&gt;").replace("<", "&lt;")


def quoteattr(text: str) -> str:
    """Return text as a quoted value of an attribute: in single quotes if it contains double quotes only."""
    text = escape(text)
    for blank, entity in _BLANKS.items():
        text = text.replace(blank, entity)
    if '"' not in text:
        return f'"{text}"'
    if "'" not in text:
        return f"'{text}'"
    return '"' + text.replace('"', "&quot;") + '"'
