# SPDX-License-Identifier: Apache-2.0
"""Scenes in files that any version of the package can read: the drawing, Adam's moments, and where the run stands.

A saved `State` is for the version that wrote it. Here options are not kept: each version takes its own paper preset.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from livecl.drawing.drawing import Drawing
from livecl.options import Options
from livecl.training.state import State

_DRAWING = ("points", "colors", "background", "subpath_offsets", "layer_offsets", "stages")
_TRAINED = ("points", "colors", "background")
_MOMENTS = ("mean", "square", "ages")


def save_scene(path: Path, state: State) -> None:
    """Write a state."""
    arrays: dict[str, Any] = {name: getattr(state.drawing, name) for name in _DRAWING}
    for name in _TRAINED:
        arrays |= {f"{name}.{moment}": getattr(getattr(state, name), moment) for moment in _MOMENTS}
    place = np.array([state.stage, state.iteration, state.options.iterations])
    np.savez(path, size=state.drawing.size, schedule=state.schedule, place=place, **arrays)


def load_scene(path: Path) -> State:
    """Read what :func:`save_scene` wrote; the pieces are chosen anew."""
    with np.load(path) as file:
        arrays = dict(file)
    height, width = map(int, arrays["size"])
    stage, iteration, iterations = map(int, arrays["place"])
    drawing = Drawing(size=(height, width), **{name: arrays[name] for name in _DRAWING})
    schedule = tuple(int(paths) for paths in arrays["schedule"])
    state = State.start(drawing, Options.paper(iterations=iterations), schedule, seed=0)
    state.stage, state.iteration = stage, iteration
    for name in _TRAINED:
        for moment in _MOMENTS:
            setattr(getattr(state, name), moment, arrays[f"{name}.{moment}"])
    return state
