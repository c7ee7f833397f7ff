# SPDX-License-Identifier: Apache-2.0
"""`State`: everything that a run needs to go on, in one object that can be saved."""

from __future__ import annotations

import dataclasses
import io
import json
import os
import zipfile
from typing import Any

import numpy as np
from numpy.typing import NDArray

from livecl.drawing import Drawing
from livecl.errors import LiveclError
from livecl.files import write_atomically
from livecl.optimizers import Adam
from livecl.options import Options

_FORMAT = 1


@dataclasses.dataclass
class State:
    """A run between two iterations.

    Attributes
    ----------
    drawing : Drawing
        Layers so far, as trained: neither rounded nor snapped to 8 bits.
    options : Options
        Parameters of the method.
    schedule : tuple of int
        Paths that each stage adds.
    stage, iteration : int
        The stage that is under way (its paths are placed once `iteration` counts), and its steps so far.
    points, colors, background : Adam
        Moments of the control points, by segment, of the colours, by layer, and of the background.
    pieces : (M,) int
        Lines that each segment is flattened into.
    rng : numpy.random.Generator
        Source of whatever is random.
    kept_weight : (H, W) float or None
        Distance weight that earlier stages left (the released program's loss).
    """

    drawing: Drawing
    options: Options
    schedule: tuple[int, ...]
    stage: int
    iteration: int
    points: Adam
    colors: Adam
    background: Adam
    pieces: NDArray[np.int32]
    rng: np.random.Generator
    kept_weight: NDArray[Any] | None = None

    @classmethod
    def start(cls, drawing: Drawing, options: Options, schedule: tuple[int, ...], seed: int) -> State:
        """Return the state before the first stage, from a drawing that may have layers already."""
        return cls(
            drawing=drawing,
            options=options,
            schedule=schedule,
            stage=0,
            iteration=0,
            points=Adam.start(drawing.points.shape),
            colors=Adam.start(drawing.colors.shape),
            background=Adam.start((1, 3)),
            pieces=np.ones(drawing.num_segments, np.int32),
            rng=np.random.default_rng(seed),
        )

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the state to a file, replacing an existing one atomically."""
        drawing = self.drawing
        arrays: dict[str, Any] = {
            "points": drawing.points,
            "colors": drawing.colors,
            "subpath_offsets": drawing.subpath_offsets,
            "layer_offsets": drawing.layer_offsets,
            "stages": drawing.stages,
            "pieces": self.pieces,
        }
        if drawing.background is not None:
            arrays["background"] = drawing.background
        if self.kept_weight is not None:
            arrays["kept_weight"] = self.kept_weight
        for name in ("points", "colors", "background"):
            for field, value in vars(getattr(self, name)).items():
                arrays[f"adam.{name}.{field}"] = value
        facts = {
            "format": _FORMAT,
            "size": drawing.size,
            "options": dataclasses.asdict(self.options),
            "schedule": self.schedule,
            "stage": self.stage,
            "iteration": self.iteration,
            "rng": self.rng.bit_generator.state,
        }
        buffer = io.BytesIO()
        np.savez(buffer, facts=np.array(json.dumps(facts)), **arrays)
        write_atomically(path, buffer.getvalue())

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> State:
        """Read a state that :meth:`save` wrote.

        Raises
        ------
        LiveclError
            If the file is not one.
        """
        try:
            with np.load(path, allow_pickle=False) as file:
                arrays = dict(file)
            facts = json.loads(str(arrays["facts"]))
            if facts["format"] != _FORMAT:
                raise ValueError(f"format {facts['format']}, wanted {_FORMAT}")
            rng = np.random.default_rng()
            rng.bit_generator.state = facts["rng"]
            adams = {
                name: Adam(**{field: arrays[f"adam.{name}.{field}"] for field in ("mean", "square", "ages")})
                for name in ("points", "colors", "background")
            }
            return cls(
                drawing=Drawing(
                    size=facts["size"],
                    background=arrays.get("background"),
                    **{key: arrays[key] for key in ("points", "colors", "subpath_offsets", "layer_offsets", "stages")},
                ),
                options=Options(**facts["options"]),
                schedule=tuple(facts["schedule"]),
                stage=facts["stage"],
                iteration=facts["iteration"],
                pieces=arrays["pieces"],
                rng=rng,
                kept_weight=arrays.get("kept_weight"),
                **adams,
            )
        except (OSError, KeyError, TypeError, ValueError, EOFError, zipfile.BadZipFile) as error:
            raise LiveclError(f"{os.fspath(path)!r} is not a saved state of livecl: {error}") from error
