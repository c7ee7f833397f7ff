# SPDX-License-Identifier: Apache-2.0
"""Text and attributes of XML, escaped as by `xml.sax.saxutils`, which would load the modules of HTTP and mail."""

from __future__ import annotations

#: Characters that an attribute cannot hold as they are, beside those of text and quotes.
_BLANKS = {"\n": "&#10;", "\r": "&#13;", "\t": "&#9;"}


def escape(text: str) -> str:
    """Return text with ``&``, ``<`` and ``>`` as entities."""
    return text.replace("&", "&amp;").replace(">", "&gt;").replace("<", "&lt;")


def quoteattr(text: str) -> str:
    """Return text as the value of an attribute, in quotes: single ones where it holds double ones alone."""
    text = escape(text)
    for blank, entity in _BLANKS.items():
        text = text.replace(blank, entity)
    if '"' not in text:
        return f'"{text}"'
    if "'" not in text:
        return f"'{text}'"
    return '"' + text.replace('"', "&quot;") + '"'
