# SPDX-License-Identifier: Apache-2.0
"""Summary of a batch: the outcome of each picture, as a table beside the SVGs.

The table also tells which pictures are done: those with a row for the same picture and recipe, and whose SVG has not
changed since.
"""

from __future__ import annotations

import contextlib
import csv
import dataclasses
import io
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal, get_args, get_type_hints

from livecl.files import write_atomically

#: Name of the table in the output folder.
SUMMARY = "summary.csv"
#: Least time between two writings of the table, seconds: a killed batch repeats the pictures finished since.
SUMMARY_PERIOD = 1.0

Status = Literal["done", "skipped", "failed"]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Outcome:
    """Outcome of a picture; a row of ``summary.csv``.

    Attributes
    ----------
    file : str
        The picture.
    output : str
        Its SVG, relative to the output folder, with ``/`` between folders.
    status : "done", "skipped" or "failed"
        Skipped: it was already done.
    paths : int or None
        Number of layers; without a drawing, this and the following fields are None or "".
    mse : float or None
        Mean squared error at the working size.
    seconds : float or None
        Time of its stages.
    width, height, working_width, working_height : int or None
        Size of the picture and of its working copy, px.
    message : str
        Reason of a failure or stop.
    picture, recipe, svg : str
        SHA-256 of the picture's bytes and of the SVG's, fingerprint of the recipe.
    """

    file: str
    output: str
    status: Status
    paths: int | None = None
    mse: float | None = None
    seconds: float | None = None
    width: int | None = None
    height: int | None = None
    working_width: int | None = None
    working_height: int | None = None
    message: str = ""
    picture: str = ""
    recipe: str = ""
    svg: str = ""


_COLUMNS = [field.name for field in dataclasses.fields(Outcome)]


class Summary:
    """The table of an output folder: rows by output, those of earlier batches in the same folder included."""

    def __init__(self, folder: Path) -> None:
        self._path = folder / SUMMARY
        self._rows = {row.output: row for row in _read(self._path) if row.status != "failed"}
        self._written = 0.0

    def get(self, output: str) -> Outcome | None:
        """Return the row of an output, or None."""
        return self._rows.get(output)

    def add(self, outcome: Outcome) -> None:
        """Add a row, or replace that of the same output; the table is written periodically."""
        self._rows[outcome.output] = outcome
        if time.monotonic() - self._written >= SUMMARY_PERIOD:
            self.write()

    def write(self) -> None:
        """Write the table, sorted by output, replacing the file atomically."""
        text = io.StringIO()
        writer = csv.DictWriter(text, _COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(dataclasses.asdict(self._rows[output]) for output in sorted(self._rows))
        write_atomically(self._path, text.getvalue())
        self._written = time.monotonic()


def _read(path: Path) -> list[Outcome]:
    """Return the readable rows of a table; none if there is no file.

    Raises ValueError if the file is no table of a batch, and must not be overwritten.
    """
    try:
        reader = csv.DictReader(io.StringIO(path.read_text(encoding="utf-8")))
        if list(reader.fieldnames or ()) != _COLUMNS:
            raise ValueError
        rows = list(reader)
    except FileNotFoundError:
        return []
    except (ValueError, csv.Error):  # UnicodeDecodeError is a ValueError
        raise ValueError(
            f"{path}: is not the table of a batch and would be overwritten; move it, or choose another folder"
        ) from None
    found = []
    for row in rows:
        with contextlib.suppress(ValueError, TypeError):  # cut or edited
            found.append(_outcome(row))
    return found


def _outcome(row: Mapping[str, str]) -> Outcome:
    values: dict[str, Any] = {}
    for name, hint in get_type_hints(Outcome).items():
        kinds = [kind for kind in (int, float) if kind in get_args(hint)]
        values[name] = row[name] if not kinds else kinds[0](row[name]) if row[name] else None
    if values["status"] not in get_args(Status) or not isinstance(values["svg"], str):
        raise ValueError("status, or too few columns")
    return Outcome(**values)
