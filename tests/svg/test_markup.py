# SPDX-License-Identifier: Apache-2.0
"""Text and attributes are escaped as Python's own XML library does it."""

from __future__ import annotations

import itertools
from xml.sax import saxutils

from livecl.svg.markup import escape, quoteattr


def test_text_and_attributes_are_escaped_as_by_saxutils() -> None:
    for parts in itertools.product(("", "a", "&", "<b>", "&amp;"), ("", '"', "'", "\"'"), ("", "\n", "\t", "\r", "é")):
        text = "".join(parts)
        assert escape(text) == saxutils.escape(text)
        assert quoteattr(text) == saxutils.quoteattr(text)
