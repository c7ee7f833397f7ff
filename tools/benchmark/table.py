# SPDX-License-Identifier: Apache-2.0
"""Tables as aligned text or as Markdown."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence


@dataclasses.dataclass(frozen=True)
class Table:
    """A table with a title; the first column is text, the others are numbers."""

    title: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]

    def text(self) -> str:
        """Return the table in aligned columns."""
        lines = [self._aligned(row) for row in (self.head, *self.rows)]
        return "\n".join([self.title, *(line.rstrip() for line in lines)])

    def markdown(self) -> str:
        """Return the table as Markdown."""
        rule = ["---", *["--:"] * (len(self.head) - 1)]
        lines = ["| " + " | ".join(row) + " |" for row in (self.head, rule, *self.rows)]
        return "\n".join([f"**{self.title}**", "", *lines])

    def _aligned(self, row: Sequence[str]) -> str:
        widths = [max(map(len, column)) for column in zip(self.head, *self.rows, strict=True)]
        cells = [row[0].ljust(widths[0]), *(cell.rjust(width) for cell, width in zip(row[1:], widths[1:], strict=True))]
        return "  ".join(cells)


def number(value: float | None, digits: int = 3) -> str:
    """Return a number with so many significant digits, without an exponent; a dash for None."""
    if value is None:
        return "-"
    if value == 0 or abs(value) >= 10 ** (digits - 1):
        return f"{value:.0f}"
    text = f"{value:.{digits}g}"
    return f"{value:.{digits - 1 - math.floor(math.log10(abs(value)))}f}" if "e" in text else text
