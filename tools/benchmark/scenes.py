# SPDX-License-Identifier: Apache-2.0
"""Scenes for timing iterations: drawings like those of a real run, made by a short one."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from benchmark.cases import Case
from benchmark.package import training

if TYPE_CHECKING:
    from livecl.drawing.drawing import Drawing

#: Iterations of each stage of the run that makes a scene. With 20, 60 and 150, 256 paths on the photograph have a
#: median side of 41, 40 and 41 px, and are flattened into 30, 34 and 38 thousand lines.
ITERATIONS = 40
#: Side of the largest canvas on which a scene is made from scratch: few iterations do not suffice for larger ones.
#: Enlarged to 512x512, 256 paths cross 129 thousand pixels; with 150 iterations of each stage there, 115 thousand.
SIDE = 240
ROOT = Path(__file__).resolve().parents[2]
#: The repository's own emoji, in place of the paper's.
FACE = ROOT / "examples" / "face.png"


def picture(name: str, side: int, photo: str | None = None) -> NDArray[np.float32]:
    """Return a picture as a square (side, side, 3) in [0, 1].

    Parameters
    ----------
    name : str
        As of :class:`benchmark.cases.Case`; the photograph is scikit-image's, or the file `photo`; "covers" is white.
    side : int
        Height and width, px.
    photo : path, optional
        File of the photograph.
    """
    from skimage.transform import resize

    from livecl.image.reading import over_background, read_image

    if name == "pixels":
        small = picture("face", 256)[4::8, 4::8]
        return np.kron(small, np.ones((side // 32, side // 32, 1), np.float32))
    if name == "covers":
        return np.ones((side, side, 3), np.float32)
    if name == "photo" and photo is None:
        import skimage.data

        image = skimage.data.astronaut().astype(np.float32) / 255
    else:
        image = read_image(photo if name == "photo" and photo is not None else FACE.with_name(f"{name}.png"))
    if image.shape[2] == 4:
        image = over_background(image, np.ones(3))
    if image.shape[:2] != (side, side):
        image = resize(image, (side, side), anti_aliasing=True)
    return np.clip(image, 0, 1).astype(np.float32)


def warm_up_pictures(side: int = 48) -> list[NDArray[np.float32]]:
    """Return a flat picture and one of noise in colours that change, (`side`, `side`, 3)."""
    rows, columns = np.mgrid[:side, :side].astype(np.float32) / side
    flat = np.ones((side, side, 3), np.float32)
    flat[side // 4 : side // 2, side // 4 : -side // 4] = (0.8, 0.2, 0.1)
    shaded = np.stack([rows, columns, rows * columns], axis=2)
    noise = np.random.default_rng(0).normal(0, 0.1, shaded.shape)
    return [flat, np.clip(shaded + noise, 0, 1).astype(np.float32)]


def save_variants(image: NDArray[np.float32], folder: Path, count: int = 40) -> None:
    """Write variants of a picture: its rows moved, its channels swapped."""
    from livecl.image.reading import save_image

    folder.mkdir()
    for number in range(count):
        save_image(folder / f"{number:02}.png", np.roll(np.roll(image, number, axis=0), number, axis=2))


def made(case: Case, photo: str | None = None, device: int | str | None = None) -> Drawing:
    """Return the drawing of a short run; for larger canvases than `SIDE`, enlarged and trained on."""
    import livecl

    if case.picture == "covers":
        return covers(case.paths, case.side)
    side = min(case.side, SIDE)
    options = livecl.Options.paper(iterations=ITERATIONS)
    image = picture(case.picture, side, photo)
    drawing = livecl.vectorize(image, case.paths, schedule=case.schedule, options=options, device=device).drawing
    if case.side == side:
        return drawing
    drawing = drawing.replace(points=drawing.points * (case.side / side), size=(case.side, case.side))
    trained = training(picture(case.picture, case.side, photo), drawing, device)
    for _ in range(ITERATIONS):
        trained.step()
    return trained.state.drawing


def covers(num_layers: int, side: int) -> Drawing:
    """Return translucent layers that each cover nearly all of the canvas, with an outline of their own within it."""
    from livecl.drawing.drawing import Drawing

    rng = np.random.default_rng(0)
    angles = 2 * np.pi * np.arange(12) / 12
    radii = side * rng.uniform(0.5, 0.75, (num_layers, 12, 1))
    directions = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    points: NDArray[Any] = side / 2 + radii * directions
    colors = np.concatenate([rng.uniform(size=(num_layers, 3)), np.full((num_layers, 1), 0.05)], axis=1)
    return Drawing(points=points.reshape(-1, 3, 2), colors=colors, size=(side, side))


def save_scene(path: Path, drawing: Drawing) -> None:
    """Write a drawing with its exact numbers, which an SVG would round."""
    names = ("points", "colors", "subpath_offsets", "layer_offsets")
    np.savez(path, size=drawing.size, **{name: getattr(drawing, name) for name in names})


def load_scene(path: Path) -> Drawing:
    """Read a drawing written by :func:`save_scene`."""
    from livecl.drawing.drawing import Drawing

    with np.load(path) as file:
        arrays: dict[str, Any] = dict(file)
    height, width = map(int, arrays.pop("size"))
    return Drawing(size=(height, width), **arrays)
