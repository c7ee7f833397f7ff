# SPDX-License-Identifier: Apache-2.0
"""What the benchmark asks of a subprocess."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from typing import Any

from benchmark.cases import CASES, Case


@dataclasses.dataclass(frozen=True, kw_only=True)
class Request:
    """One thing to do in a process of its own.

    Attributes
    ----------
    verb : str
        What to do: "machine", "prepare", "check" or "time".
    root : str
        The checkout whose package is used.
    folder : str
        Where scenes and answers are.
    device : str or None
        OpenCL device.
    case : str
        Name of the case; empty for "machine".
    photo : str or None
        File to take for the photograph.
    repeats : int or None
        How often to measure; None for what fits.
    """

    verb: str
    root: str
    folder: str
    device: str | None = None
    case: str = ""
    photo: str | None = None
    repeats: int | None = None

    def to_json(self) -> str:
        """Return the request as text."""
        return json.dumps(dataclasses.asdict(self))

    @classmethod
    def from_json(cls, text: str) -> Request:
        """Read what :meth:`to_json` returned."""
        fields: dict[str, Any] = json.loads(text)
        return cls(**fields)

    @property
    def the_case(self) -> Case:
        """The case itself."""
        return CASES[self.case]

    @property
    def scene_file(self) -> Path:
        """State that iterations start from."""
        return Path(self.folder) / f"{self.case}.npz"

    @property
    def picture_file(self) -> Path:
        """The case's picture, (H, W, 3) float32."""
        return Path(self.folder) / f"{self.case}.npy"

    @property
    def answer_file(self) -> Path:
        """Where the answer is left."""
        return Path(self.folder) / "answer.json"
