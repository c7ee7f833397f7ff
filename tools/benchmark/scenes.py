# SPDX-License-Identifier: Apache-2.0
"""The scenes that iterations are timed on: states as a real run leaves them, made by a short one."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmark.cases import Case
from livecl.drawing.drawing import Drawing, empty_drawing
from livecl.image.reading import over_background, read_image
from livecl.options import Options
from livecl.run.loop import run
from livecl.run.stages import Vectorizer
from livecl.schedule import parse_schedule
from livecl.training.state import State

#: Iterations of each stage of the run that makes a scene. With 20, 60 and 150, 256 paths on the photograph have a
#: median side of 41, 40 and 41 px, and are flattened into 30, 34 and 38 thousand lines.
ITERATIONS = 40
#: Largest canvas that a scene is made on from nothing: paths do not grow across a larger one in so few iterations.
#: Enlarged to 512x512, 256 paths cross 129 thousand pixels; with 150 iterations of each stage there, 115 thousand.
SIDE = 240
ROOT = Path(__file__).resolve().parents[2]
#: The paper's emoji stands in for any: this one is the repository's own.
FACE = ROOT / "examples" / "face.png"


def picture(name: str, side: int, photo: str | None = None) -> NDArray[np.float32]:
    """Return a picture as a square (side, side, 3) in [0, 1].

    Parameters
    ----------
    name : "face", "photo" or "covers"
        The emoji; the photograph that scikit-image brings, or the file `photo`; nothing but white.
    side : int
        Height and width, px.
    photo : path, optional
        File to take for the photograph.
    """
    if name == "covers":
        return np.ones((side, side, 3), np.float32)
    if name == "photo" and photo is None:
        import skimage.data

        image = skimage.data.astronaut().astype(np.float32) / 255
    else:
        image = read_image(photo if name == "photo" and photo is not None else FACE)
    if image.shape[2] == 4:
        image = over_background(image, np.ones(3))
    if image.shape[:2] != (side, side):
        from skimage.transform import resize

        image = resize(image, (side, side), anti_aliasing=True)
    return np.clip(image, 0, 1).astype(np.float32)


def made(case: Case, photo: str | None = None, device: int | str | None = None) -> State:
    """Return the state of a run after the last iteration of its last stage, from where it can go on.

    For larger canvases than `SIDE`, the drawing of that run is enlarged and trained on.
    """
    if case.picture == "covers":
        return State.start(covers(case.paths, case.side), Options.paper(), (case.paths,), 0)
    options, side = Options.paper(iterations=ITERATIONS), min(case.side, SIDE)
    stages = parse_schedule(case.schedule, case.paths)
    start = State.start(empty_drawing((side, side)), options, stages, 0)
    vectorizer = Vectorizer(picture(case.picture, side, photo), start, device)
    # Stopped at the very last iteration, the state is still within its stage.
    run(vectorizer, on_step=lambda step: (step.stage + 1, step.iteration) == (len(stages), ITERATIONS))
    if case.side == side:
        return vectorizer.state
    drawing = vectorizer.state.drawing
    drawing = drawing.replace(points=drawing.points * (case.side / side), size=(case.side, case.side))
    start = State.start(drawing, options, stages, 0)
    start.stage = len(stages) - 1
    vectorizer = Vectorizer(picture(case.picture, case.side, photo), start, device)
    for _ in range(ITERATIONS):
        vectorizer.step()
    return vectorizer.state


def covers(num_layers: int, side: int) -> Drawing:
    """Return translucent layers that each cover nearly all of the canvas, with an outline of their own within it."""
    rng = np.random.default_rng(0)
    angles = 2 * np.pi * np.arange(12) / 12
    radii = side * rng.uniform(0.5, 0.75, (num_layers, 12, 1))
    directions = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    points: NDArray[Any] = side / 2 + radii * directions
    colors = np.concatenate([rng.uniform(size=(num_layers, 3)), np.full((num_layers, 1), 0.05)], axis=1)
    return Drawing(points=points.reshape(-1, 3, 2), colors=colors, size=(side, side))
