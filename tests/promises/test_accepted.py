# SPDX-License-Identifier: Apache-2.0
"""Each public function takes each kind of argument that its documentation names, and refuses others by their names."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from support.shapes import BLUE, RED, build, circle, rectangle

import livecl
from livecl.drawing import concatenate
from livecl.image.reading import save_image

DRAWING = build([([circle((8, 8), 5)], RED), ([rectangle(13, 3, 19, 12)], BLUE)], (16, 20))
QUICK = livecl.Options(iterations=1, revisions=0)
#: A picture (H, W, 3) of levels of 8 bits.
LEVELS = np.full((16, 20, 3), 255, np.uint8)
LEVELS[4:12, 3:11] = (200, 30, 40)


def png() -> bytes:
    stream = io.BytesIO()
    Image.fromarray(LEVELS).save(stream, "PNG")
    return stream.getvalue()


#: Kinds of pictures, from a folder to write into.
PICTURES: dict[str, Callable[[Path], Any]] = {
    "str": lambda folder: str(folder / "a.png"),
    "path": lambda folder: folder / "a.png",
    "bytes": lambda folder: png(),
    "open file": lambda folder: (folder / "a.png").open("rb"),
    "stream": lambda folder: io.BytesIO(png()),
    "Pillow": lambda folder: Image.fromarray(LEVELS),
    "uint8": lambda folder: LEVELS,
    "uint16": lambda folder: LEVELS.astype(np.uint16) * 257,
    "float32": lambda folder: (LEVELS / 255).astype(np.float32),
    "float64": lambda folder: LEVELS / 255,
    "list": lambda folder: (LEVELS / 255).tolist(),
    "grey": lambda folder: LEVELS[..., 1],
    "alpha": lambda folder: np.dstack([LEVELS, LEVELS[..., 0]]),
}
#: Functions of a picture.
TAKES_PICTURE: dict[str, Callable[[Any], Any]] = {
    "read_image": livecl.read_image,
    "vectorize": lambda image: livecl.vectorize(image, 1, options=QUICK).drawing,
    "Recipe": lambda image: livecl.Recipe(paths=1, options=QUICK).vectorize(image).drawing,
    "vectorize_sequence": lambda image: livecl.vectorize_sequence([image], paths=1, options=QUICK).drawings[0],
}
#: `read_image` reads files; `livecl.image.as_image` takes arrays and pictures in memory.
FILES = ("str", "path", "bytes", "open file", "stream")


CASES = [(function, kind) for function in TAKES_PICTURE for kind in (FILES if function == "read_image" else PICTURES)]


@pytest.mark.parametrize(("function", "kind"), CASES)
def test_pictures(function: str, kind: str, tmp_path: Path) -> None:
    (tmp_path / "a.png").write_bytes(png())
    given = PICTURES[kind](tmp_path)
    made = TAKES_PICTURE[function](given)
    size = made.size if isinstance(made, livecl.Drawing) else made.shape[:2]
    assert size == (16, 20)


@pytest.mark.parametrize("kind", ["str", "path", "bytes"])
def test_svgs(kind: str, tmp_path: Path) -> None:
    file = tmp_path / "a.svg"
    DRAWING.save_svg(file)
    given = {"str": str(file), "path": file, "bytes": file.read_bytes()}
    assert livecl.read_svg(given[kind]).num_layers == 2


NUMBERS: dict[str, dict[str, Any]] = {
    "paths": {"paths": np.int64(1)},
    "auto": {"paths": "auto"},
    "seed": {"paths": 1, "seed": np.uint8(3)},
    "size": {"paths": 1, "size": np.int32(64)},
    "schedule, text": {"schedule": "1,1"},
    "schedule, list": {"schedule": [1, 1]},
    "schedule, array": {"schedule": np.array([1, 1])},
    "schedule, exp": {"schedule": "exp", "paths": 2},
    "start": {"start": DRAWING},
    "lock, list": {"start": DRAWING, "lock": [0]},
    "lock, array": {"start": DRAWING, "lock": np.array([1])},
    "lock, select": {"start": DRAWING, "lock": DRAWING.select("red")},
    "device": {"paths": 1, "device": np.int64(0)},
    "control": {"paths": 1, "control": livecl.Control(time_limit=np.float32(60.0))},
}


@pytest.mark.parametrize("name", NUMBERS)
def test_arguments_of_vectorize(name: str) -> None:
    assert livecl.vectorize(LEVELS, options=QUICK, **NUMBERS[name]).drawing.size == (16, 20)


@pytest.mark.parametrize("t", [0, 0.5, np.float32(0.5), np.float64(1)], ids=repr)
def test_places_of_interpolate(t: float) -> None:
    assert isinstance(livecl.interpolate(DRAWING, DRAWING, t), livecl.Drawing)


@pytest.mark.parametrize("t", [[0.5], (0, 1), np.linspace(0, 1, 3)], ids=["list", "tuple", "array"])
def test_lists_of_places_of_interpolate(t: Any) -> None:
    assert len(livecl.interpolate(DRAWING, DRAWING, t)) == len(t)


#: Calls with a list in place of a drawing, or a name in place of options, and the argument that is named.
REFUSED: dict[str, tuple[Callable[[], Any], str]] = {
    "forward": (lambda: livecl.Rasterizer(DRAWING.size).forward([DRAWING]), "drawing: got list"),
    "forward of an array": (lambda: livecl.Rasterizer(DRAWING.size).forward(LEVELS), "drawing: got ndarray"),
    "render": (lambda: livecl.render(None), "drawing: got NoneType"),
    "interpolate": (lambda: livecl.interpolate(DRAWING, [DRAWING], 0.5), "b: got list"),
    "concatenate": (lambda: concatenate(DRAWING, "a.svg"), "above: got str"),
    "start": (lambda: livecl.vectorize(LEVELS, start="a.svg"), "start: got str, wanted a livecl.Drawing"),
    "options": (lambda: livecl.vectorize(LEVELS, options="icon"), "options: got str, wanted livecl.Options"),
    "sequence": (lambda: livecl.vectorize_sequence([LEVELS], options={"tau": 3}), "options: got dict"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_other_kinds_are_refused_by_name(name: str) -> None:
    call, message = REFUSED[name]
    with pytest.raises(TypeError, match=f"^{message}"):
        call()


def test_inputs_of_batches(tmp_path: Path) -> None:
    for name in ("a", "b"):
        save_image(tmp_path / f"{name}.png", LEVELS / 255)
    recipe = livecl.Recipe(paths=np.int64(1), options=QUICK)
    inputs = [str(tmp_path), tmp_path, str(tmp_path / "*.png"), [tmp_path / "a.png", str(tmp_path / "b.png")]]
    for number, given in enumerate(inputs):
        outcomes = livecl.vectorize_files(given, tmp_path / f"out-{number}", recipe=recipe, workers=1)
        assert [outcome.status for outcome in outcomes] == ["done", "done"]
