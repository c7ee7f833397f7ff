# SPDX-License-Identifier: Apache-2.0
"""Drawings of odd geometry: each is refused by name, or rendered and differentiated to finite numbers, twice the same.

A part is compared with the slow reference in float64.
"""

from __future__ import annotations

import functools
import json
import math
import random
from typing import Any

import numpy as np
import reference
from reference.rounding import image_tolerance

from fuzzing.kind import Kind, one_line
from livecl.drawing.drawing import MAX_COORDINATE, Drawing
from livecl.geometry.bezier import pieces_for
from livecl.rendering.rasterizer import TOLERANCE, Rasterizer

#: Height and width of the canvases: a rasterizer is built once for each.
SIZES = ((1, 1), (1, 9), (9, 1), (8, 8), (16, 17), (33, 20), (3, 300), (300, 3))
#: Most lines times pixels that the reference is asked for.
MOST_WORK = 300_000
#: Further than this from the canvas, px, positions are rounded to more than 1e-4 px in float32, and are not compared.
MOST_REACH = 1000.0
ODD_NUMBERS = (
    *(0.0, -0.0, 1e-300, 1e-30, 1e-9, 0.5, 1.0, 8.0, MAX_COORDINATE, -MAX_COORDINATE, 1e6 + 1, 1e9, 1e308),
    *(math.nan, math.inf, -math.inf),
)
#: In place of an argument.
ODD_VALUES = (
    *(None, 3, "abc", "", {}, [], [0.5], [[1], [1, 2]], [2**40], [10**400], (math.inf, 3), (math.nan, 3), (3, 2.5)),
    *([0], [True], ["a"], ["a", "b"], [b"a"], [None], [1j], np.zeros(3, dtype=complex), (10**400, 1), object, (8, 8)),
)

Case = dict[str, Any]


def subpath(rng: random.Random, size: tuple[int, int], numbers: np.random.Generator) -> np.ndarray:
    """Return the segments (m, 3, 2) of one subpath, of one of many odd shapes."""
    height, width = size
    count = rng.choice((1, 1, 2, 3, 4, 4, 4, 8, 20))
    box = np.array([width, height], dtype=float)
    shape = rng.choice(
        ("tangle", "tangle", "far", "huge", "tiny", "point", "line", "grid", "rectangle", "doubled", "spike", "many")
    )
    points = numbers.uniform(-0.2, 1.2, (count, 3, 2)) * box
    if shape == "far":
        points += numbers.choice([-1, 1], 2) * 10 ** rng.uniform(1, 5)
    elif shape == "huge":
        points *= 10 ** rng.uniform(1, 5)
    elif shape == "tiny":
        points = points[:1, :1] + (points - points[:1, :1]) * 10 ** rng.uniform(-12, -1)
    elif shape == "point":
        points[:] = points[0, 0]
    elif shape == "line":
        points[..., rng.randrange(2)] = points[0, 0, 0]
    elif shape == "grid":
        points = np.round(points * rng.choice((1, 2, 0.125))) / rng.choice((1, 2))
    elif shape == "rectangle":
        corners = np.round(numbers.uniform(-1, max(size) + 1, (2, 2)), rng.choice((0, 0, 1, 3)))
        (x, y), (u, v) = corners
        start = np.array([(x, y), (u, y), (u, v), (x, v)])
        points = np.stack([start, start, np.roll(start, -1, axis=0)], axis=1)
    elif shape == "doubled":
        points = np.concatenate([points, points])
    elif shape == "spike":
        points[rng.randrange(count), rng.randrange(3)] *= 10 ** rng.uniform(1, 4)
    elif shape == "many":
        points = numbers.uniform(-0.2, 1.2, (rng.choice((100, 3000)), 3, 2)) * box
    return points


def make(rng: random.Random) -> Case:
    """Return arguments of a drawing; one in ten has an odd number, and one in ten an odd argument."""
    numbers = np.random.default_rng(rng.getrandbits(64))
    size = rng.choice(SIZES)
    num_layers = rng.choice((0, 1, 1, 2, 3, 8, 60))
    layers = [[subpath(rng, size, numbers) for _ in range(rng.choice((1, 1, 1, 2, 4)))] for _ in range(num_layers)]
    subpaths = [part for layer in layers for part in layer]
    points = np.concatenate([np.zeros((0, 3, 2)), *subpaths])
    colors = numbers.choice([0, 0.5, 1, numbers.uniform()], (num_layers, 4))
    case: Case = {
        "points": points,
        "colors": colors,
        "size": size,
        "background": rng.choice((None, [1.0, 1.0, 1.0], [0.2, 0.0, 0.9])),
        "subpath_offsets": np.cumsum([0, *map(len, subpaths)]),
        "layer_offsets": np.cumsum([0, *map(len, layers)]),
    }
    if rng.random() < 0.1 and num_layers:
        array = points if rng.random() < 0.7 else colors
        array.reshape(-1)[rng.randrange(array.size)] = rng.choice(ODD_NUMBERS)
    if rng.random() < 0.05:
        offsets = case[rng.choice(("subpath_offsets", "layer_offsets"))]
        offsets[rng.randrange(len(offsets))] = rng.choice((-1, 0, 1, len(points), len(points) + 1, 2**40))
    if rng.random() < 0.1:
        case[rng.choice(("stages", "names", *case))] = rng.choice(ODD_VALUES)
    return case


@functools.lru_cache(maxsize=len(SIZES))
def rasterizer(size: tuple[int, int]) -> Rasterizer:
    """Return the rasterizer of a canvas."""
    return Rasterizer(size)


def check(case: Case) -> str:
    """Render a drawing and differentiate it."""
    try:
        drawing = Drawing(**case)
    except ValueError as error:
        one_line(error)
        return "refused"
    own = rasterizer(drawing.size)
    image = own.forward(drawing)
    channels = 3 if drawing.background is not None else 4
    assert image.shape == (*drawing.size, channels) and image.dtype == np.float32, (image.shape, image.dtype)
    # Straight sums of shares, each rounded: what is above 1 or below 0 is so by rounding only.
    rounding = 4 * (drawing.num_layers + 1) * np.finfo(np.float32).eps
    assert np.isfinite(image).all(), "the image has numbers that are not finite"
    assert image.min() >= -rounding and image.max() <= 1 + rounding, (image.min(), image.max())
    d_image = np.random.default_rng(0).normal(size=image.shape)
    gradients = own.backward(d_image)
    for name in ("points", "colors", "background"):
        part = getattr(gradients, name)
        assert part is None or np.isfinite(part).all(), f"d_{name} has numbers that are not finite"
    again = own.forward(drawing)
    assert again.tobytes() == image.tobytes(), "rendered again, it is another image"
    assert own.backward(d_image).points.tobytes() == gradients.points.tobytes(), "differentiated again, it differs"
    return f"rendered, {_compared(drawing, image)}"


def _compared(drawing: Drawing, image: np.ndarray) -> str:
    """Compare an image with the reference, where that is quick and the positions are near enough to be held."""
    pieces = pieces_for(drawing.cubics, TOLERANCE)
    work = int(pieces.sum()) * drawing.size[0] * drawing.size[1]
    if work > MOST_WORK or (drawing.num_segments and np.abs(drawing.points).max() > MOST_REACH):
        return "not compared"
    error = float(np.max(np.abs(image - reference.render(drawing, pieces))))
    most = image_tolerance(drawing, pieces)
    assert error <= most, f"off from the reference by {error:.3g}, where {most:.3g} is allowed"
    return "compared"


def dump(case: Case) -> bytes:
    """Return a case as JSON, whose numbers are written in full."""
    listed = {name: value.tolist() if isinstance(value, np.ndarray) else value for name, value in case.items()}
    return json.dumps(listed, default=repr).encode()


KIND = Kind(make=make, check=check, dump=dump, suffix=".json", seconds=60.0, megabytes=8000)
