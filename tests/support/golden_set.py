# SPDX-License-Identifier: Apache-2.0
"""The golden set: numbers of fixed drawings and of runs on fixed pictures, as they should stay from version to version.

Three kinds, each with the bound that suits it (`FILE` holds the numbers, tools/renew_golden.py makes them anew):

- *renders*: statistics of the picture and the gradients of fixed drawings. Processors and compilers differ by rounding.
- *beginnings*: losses of the first iterations of runs, and how many layers and segments there are. Adam divides each
  gradient by its own size, which makes more of rounding than a render does.
- *outcomes*: errors of whole runs, in which a rounding may decide which region gets a path. What rounding does to them
  is measured: by runs on the same picture with noise of single precision's rounding on it.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import livecl
from livecl import Drawing, Options, Rasterizer, vectorize
from livecl.image.reading import as_image
from livecl.image.resizing import reduced
from support import drawings
from support.runs import new_run, three_shapes
from support.small_runs import glass, ring

FILE = Path(__file__).with_name("golden.json")
#: Where a failing test writes what it got.
GOT = Path(__file__).with_name("golden.got.json")
EXAMPLES = Path(__file__).resolve().parents[2] / "examples"

#: Relative. Measured (docs/reliability.md) between PoCL 3.0 and 3.1 with LLVM 14 and 15, kernels with and without fused
#: multiply-add, numbers of threads, and linear algebra for processors from SSE2 to AVX2: renders differed by up to
#: 1.8e-7, beginnings by up to 1.3e-6. Ten times that is allowed, as there are processors and compilers that were not
#: measured.
RENDER_TOLERANCE, BEGINNING_TOLERANCE = 1.8e-6, 1.3e-5
#: Tolerance of outcomes beyond the range of noise.
OUTCOME_FACTOR = 1.25
#: Noise of a rounding of single precision, and how many runs see one of their own.
NOISE, NOISY_RUNS = 2.0**-24, 6

#: Drawings by what they cover: none has a pixel at a kink of min(|A|, 1) within rounding.
RENDERED = ("translucent", "rgba", "holes", "across the canvas's borders", "tangles", "hidden below opaque")
SVGS = ("face", "fruit", "scene")
STEPS = 5
#: By preset its options, and the pictures on which the first placement does not hang on a rounding. Random places for
#: the paper's rules: its components are those of bins of equal population, and of the many equal pixels of a flat
#: picture one rounding sends thousands to the next bin.
BEGUN = {
    "default": (Options(iterations=200), ("three shapes", "ring", "face", "logo", "letter", "badge")),
    "paper": (Options.paper(iterations=200, placement="random"), ("three shapes", "ring", "badge")),
}
SHORT = Options(iterations=15, revisions=2)


def pictures() -> dict[str, NDArray[Any]]:
    """Return small pictures: drawn here, and examples reduced to 48 px."""
    own = {"three shapes": three_shapes(32), "glass": glass(), "ring": ring()}
    examples = {
        name: reduced(as_image(EXAMPLES / f"{name}.png"), (48, 48)) for name in ("face", "logo", "letter", "badge")
    }
    return {**own, **examples}


def renders(device: int | str | None = None) -> dict[str, dict[str, float]]:
    """Return numbers of the renders of fixed drawings, and of the gradients of a loss of them."""
    cases = {name: drawings.CASES[name]() for name in RENDERED}
    found = {name: _render(case.drawing, case.pieces, device) for name, case in cases.items()}
    for name in SVGS:
        drawing = livecl.read_svg(EXAMPLES / "sources" / f"{name}.svg")
        found[f"{name}.svg"] = _render(drawing, Rasterizer(drawing.size, device).pieces(drawing), device)
    return found


def _render(drawing: Drawing, pieces: NDArray[np.int32], device: int | str | None) -> dict[str, float]:
    rasterizer = Rasterizer(drawing.size, device)
    image = rasterizer.forward(drawing, pieces)
    rows, columns = np.indices(drawing.size)
    # A smooth target, and weights that tell left from right and top from bottom.
    target = 0.5 + 0.4 * np.stack([np.sin(0.3 * columns + 0.2 * rows + k) for k in range(image.shape[2])], axis=2)
    weight = 1 + 0.5 * np.cos(0.1 * columns) * np.sin(0.15 * rows)
    loss, gradients = rasterizer.loss_and_gradients(drawing, target, weight, pieces, scale=1 / image.size)
    distance = rasterizer.distance_weight(drawing, pieces=pieces)
    values = image.astype(np.float64)
    numbers = {
        "mean": values.mean(),
        "moment": np.mean(values * weight[..., None]),
        "contrast": values.std(),
        "loss": loss,
        "d_points": np.linalg.norm(gradients.points),
        "d_colors": np.linalg.norm(gradients.colors),
        "distance weight": np.linalg.norm(distance.astype(np.float64)),
    }
    return {name: float(value) for name, value in numbers.items()}


def beginnings(device: int | str | None = None) -> dict[str, dict[str, Any]]:
    """Return losses of the first iterations with two paths, and the sizes of the drawing."""
    found: dict[str, dict[str, Any]] = {}
    shown = pictures()
    for preset, (options, names) in BEGUN.items():
        for name in names:
            run = new_run(options, (2,), device, shown[name])
            assert run.begin()
            losses = [run.step() for _ in range(STEPS)]
            sizes = {"layers": run.state.drawing.num_layers, "segments": run.state.drawing.num_segments}
            found[f"{name}, {preset}"] = {**sizes, "losses": losses}
    return found


def outcomes(device: int | str | None = None, *, noisy: bool = False) -> dict[str, dict[str, float]]:
    """Return the errors of whole runs; with `noisy` also the least and the largest of runs on noisy pictures."""
    found = {}
    for number, (name, picture) in enumerate(pictures().items()):
        numbers = {"mse": _outcome(picture, device)}
        if noisy:
            rng = np.random.default_rng(number)
            around = [
                _outcome(np.clip(picture + rng.uniform(-NOISE, NOISE, picture.shape), 0, 1), device)
                for _ in range(NOISY_RUNS)
            ]
            numbers |= {"least": min(numbers["mse"], *around), "most": max(numbers["mse"], *around)}
        found[name] = numbers
    return found


def _outcome(picture: NDArray[Any], device: int | str | None) -> float:
    return vectorize(picture, 4, options=SHORT, device=device).mse


KINDS: dict[str, Callable[..., dict[str, dict[str, Any]]]] = {
    "renders": renders,
    "beginnings": beginnings,
    "outcomes": outcomes,
}


def stored() -> dict[str, dict[str, dict[str, Any]]]:
    """Return the golden numbers."""
    found: dict[str, dict[str, dict[str, Any]]] = json.loads(FILE.read_text(encoding="utf-8"))
    return found


def misses(kind: str, found: dict[str, dict[str, Any]], wanted: dict[str, dict[str, Any]]) -> list[str]:
    """Return a line for each number that is not what it should be."""
    if kind == "outcomes":
        return [
            f"{name}: mse {numbers['mse']:.6g}, wanted {wanted[name]['least']:.6g} to {wanted[name]['most']:.6g}"
            for name, numbers in found.items()
            if not wanted[name]["least"] / OUTCOME_FACTOR <= numbers["mse"] <= wanted[name]["most"] * OUTCOME_FACTOR
        ]
    tolerance = RENDER_TOLERANCE if kind == "renders" else BEGINNING_TOLERANCE
    return [
        f"{name}: {what} {value}, wanted {wanted[name][what]} within {tolerance:.0e} of it"
        for name, numbers in found.items()
        for what, value in numbers.items()
        if not np.allclose(value, wanted[name][what], rtol=tolerance if what != "layers" else 0, atol=0)
    ]


def largest_change(found: dict[str, dict[str, Any]], wanted: dict[str, dict[str, Any]]) -> float:
    """Return the largest relative difference of any two numbers."""
    return max(
        float(np.max(np.abs(np.subtract(value, wanted[name][what])) / np.abs(wanted[name][what])))
        for name, numbers in found.items()
        for what, value in numbers.items()
    )


def write_got(kind: str, found: dict[str, dict[str, Any]]) -> None:
    """Write this run's numbers beside the golden ones."""
    before = json.loads(GOT.read_text(encoding="utf-8")) if GOT.is_file() else {}
    GOT.write_text(json.dumps({**before, kind: found}, indent=1) + os.linesep, encoding="utf-8")
