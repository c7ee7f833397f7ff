# SPDX-License-Identifier: Apache-2.0
"""Drawings of odd geometry: each is refused, or rendered and differentiated to finite numbers, twice the same.

Some are compared with the slow reference in float64.
"""

from __future__ import annotations

import functools
import math
from typing import Any

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from reference import images
from reference.rounding import image_tolerance

from fuzzing.kind import Kind, one_line
from livecl.drawing.drawing import Drawing
from livecl.drawing.fills import MAX_COORDINATE, SOLID, Fills
from livecl.geometry.bezier import pieces_for
from livecl.rendering.device_canvas import TOLERANCE
from livecl.rendering.rasterizer import Rasterizer

#: Height and width of the canvases: a rasterizer is built once for each.
SIZES = ((1, 1), (1, 9), (9, 1), (8, 8), (16, 17), (33, 20), (3, 300), (300, 3))
#: Largest number of lines times pixels for the reference.
MAX_WORK = 300_000
#: Positions farther than this from the canvas, px, are rounded to more than 1e-4 px in float32, and not compared.
MAX_REACH = 1000.0
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


@functools.cache
def coordinates(size: tuple[int, int]) -> st.SearchStrategy[float]:
    """Return what coordinates are drawn from: whole ones and others, on the canvas and near it."""
    side = max(size)
    return st.integers(-2, side + 2).map(float) | st.floats(-2, side + 2)


def odd_segments(seed: int, size: tuple[int, int]) -> np.ndarray:
    """Return the segments (m, 3, 2) of a subpath of one of many odd shapes, chosen by a seed."""
    numbers = np.random.default_rng(seed)
    count = int(numbers.choice((1, 2, 3, 4, 8, 20)))
    points = numbers.uniform(-0.2, 1.2, (count, 3, 2)) * size[::-1]
    shape = numbers.choice(("tangle", "far", "huge", "tiny", "point", "line", "grid", "doubled", "spike", "many"))
    if shape == "far":
        points += numbers.choice([-1, 1], 2) * 10 ** numbers.uniform(1, 5)
    elif shape == "huge":
        points *= 10 ** numbers.uniform(1, 5)
    elif shape == "tiny":
        points = points[:1, :1] + (points - points[:1, :1]) * 10 ** numbers.uniform(-12, -1)
    elif shape == "point":
        points[:] = points[0, 0]
    elif shape == "line":
        points[..., numbers.integers(2)] = points[0, 0, 0]
    elif shape == "grid":
        points = np.round(points * numbers.choice((1, 2, 0.125))) / numbers.choice((1, 2))
    elif shape == "doubled":
        points = np.concatenate([points, points])
    elif shape == "spike":
        points[numbers.integers(count), numbers.integers(3)] *= 10 ** numbers.uniform(1, 4)
    elif shape == "many":
        points = numbers.uniform(-0.2, 1.2, (int(numbers.choice((100, 3000))), 3, 2)) * size[::-1]
    return points


def odd_fills(seed: int, size: tuple[int, int], num_layers: int) -> dict[str, Any]:
    """Return the arguments of fills of odd kinds, chosen by a seed."""
    numbers = np.random.default_rng(seed)
    kinds = numbers.integers(0, 3, num_layers)
    geometry = numbers.uniform(-0.3, 1.3, (num_layers, 3, 2)) * size[::-1]
    counts = np.where(kinds == SOLID, 0, numbers.choice((2, 2, 3, 7, 40), num_layers))
    positions = [np.sort(numbers.uniform(size=count)) for count in counts]
    for layer in range(num_layers):
        shape = numbers.choice(("plain", "plain", "point", "short", "flat", "far", "grid", "steps", "near"))
        origin, scale = geometry[layer, :1], 10 ** numbers.uniform(-330, 0)
        if shape == "point":
            geometry[layer] = origin
        elif shape == "short":
            geometry[layer] = (origin if numbers.uniform() < 0.5 else 0) + (geometry[layer] - origin) * scale
        elif shape == "flat":
            geometry[layer, 2] = origin + (geometry[layer, 1] - origin) * numbers.choice((1, -1, 1 + scale))
        elif shape == "far":
            geometry[layer] *= 10 ** numbers.uniform(0, 4)
        elif shape == "grid":
            geometry[layer] = np.round(2 * geometry[layer]) / 2
        elif shape == "steps":
            positions[layer] = np.round(2 * positions[layer]) / 2
        elif shape == "near":
            positions[layer] = positions[layer] * scale
    return {
        "kinds": kinds,
        "geometry": geometry,
        "stop_offsets": np.cumsum([0, *counts]),
        "stop_positions": np.concatenate([np.zeros(0), *positions]),
        "stop_colors": np.round(numbers.uniform(-0.1, 1.1, (counts.sum(), 4)), 3).clip(0, 1),
    }


@st.composite
def cases(draw: st.DrawFn, *, odd_shapes: bool) -> Case:
    """Return arguments of a drawing, at most one of them odd; its outlines of odd shapes, or of a few chosen points."""
    size = draw(st.sampled_from(SIZES))
    few = st.integers(1, 6).flatmap(lambda count: arrays(np.float64, (count, 3, 2), elements=coordinates(size)))
    subpaths = st.integers(0, 2**32).map(lambda seed: odd_segments(seed, size)) if odd_shapes else few
    most = draw(st.sampled_from((4, 4, 60))) if odd_shapes else 4
    layers = draw(st.lists(st.lists(subpaths, min_size=1, max_size=3), max_size=most))
    parts = [part for layer in layers for part in layer]
    shares = st.sampled_from((0.0, 1.0, 0.5)) | st.floats(0, 1)
    case: Case = {
        "points": np.concatenate([np.zeros((0, 3, 2)), *parts]),
        "colors": draw(arrays(np.float64, (len(layers), 4), elements=shares)),
        "size": size,
        "background": draw(st.none() | st.lists(shares, min_size=3, max_size=3)),
        "subpath_offsets": np.cumsum([0, *map(len, parts)]),
        "layer_offsets": np.cumsum([0, *map(len, layers)]),
    }
    if draw(st.booleans()):
        case["fills"] = odd_fills(draw(st.integers(0, 2**32)), size, len(layers))
    odd = draw(st.sampled_from(("none", "none", "none", "number", "fills", "offset", "argument")))
    if odd == "number" and layers:
        array = case[draw(st.sampled_from(("points", "colors")))].reshape(-1)
        array[draw(st.integers(0, array.size - 1))] = draw(st.sampled_from(ODD_NUMBERS) | st.floats())
    elif odd == "fills" and "fills" in case:
        array = case["fills"][draw(st.sampled_from(tuple(case["fills"])))].reshape(-1)
        if array.size:
            number = draw(st.sampled_from(ODD_NUMBERS) | st.floats())
            array[draw(st.integers(0, array.size - 1))] = number if array.dtype.kind == "f" else int(number > 1)
    elif odd == "offset":
        offsets = case[draw(st.sampled_from(("subpath_offsets", "layer_offsets")))]
        offsets[draw(st.integers(0, len(offsets) - 1))] = draw(st.integers(-2, len(case["points"]) + 2))
    elif odd == "argument":
        case[draw(st.sampled_from(("stages", "names", *case)))] = draw(st.sampled_from(ODD_VALUES))
    return case


@functools.lru_cache(maxsize=len(SIZES))
def rasterizer(size: tuple[int, int]) -> Rasterizer:
    """Return the rasterizer of a canvas."""
    return Rasterizer(size)


def check(case: Case) -> str:
    """Render a drawing and differentiate it."""
    try:
        fills = case.get("fills")
        drawing = Drawing(**(case | {"fills": Fills(**fills)} if isinstance(fills, dict) and fills else case))
    except ValueError as error:
        one_line(error)
        return "refused"
    own = rasterizer(drawing.size)
    image = own.forward(drawing)
    channels = 3 if drawing.background is not None else 4
    assert image.shape == (*drawing.size, channels) and image.dtype == np.float32, (image.shape, image.dtype)
    # Straight sums of shares, each rounded: values above 1 or below 0 come from rounding only.
    rounding = 4 * (drawing.num_layers + 1) * np.finfo(np.float32).eps
    assert np.isfinite(image).all(), "the image has numbers that are not finite"
    assert image.min() >= -rounding and image.max() <= 1 + rounding, (image.min(), image.max())
    d_image = np.random.default_rng(0).normal(size=image.shape)
    gradients = own.backward(d_image)
    parts = {name: getattr(gradients, name) for name in ("points", "colors", "background")}
    parts |= {} if gradients.fills is None else vars(gradients.fills)
    for name, part in parts.items():
        assert part is None or np.isfinite(part).all(), f"d_{name} has numbers that are not finite"
    again = own.forward(drawing)
    assert again.tobytes() == image.tobytes(), "rendered again, it is another image"
    assert own.backward(d_image).points.tobytes() == gradients.points.tobytes(), "differentiated again, it differs"
    return f"rendered, {_compared(drawing, image)}"


def _compared(drawing: Drawing, image: np.ndarray) -> str:
    """Compare an image with the reference, if that is fast and positions are near enough for single precision."""
    pieces = pieces_for(drawing.cubics, TOLERANCE)
    work = int(pieces.sum()) * drawing.size[0] * drawing.size[1]
    if work > MAX_WORK or (drawing.num_segments and np.abs(drawing.points).max() > MAX_REACH):
        return "not compared"
    error = np.abs(image - images.render(drawing, pieces))
    most = float(np.max(error / image_tolerance(drawing, pieces)))
    assert most <= 1, f"off from the reference by {error.max():.3g}, at worst {most:.3g} times the tolerance"
    return "compared"


KIND = Kind(cases=cases(odd_shapes=False), others=cases(odd_shapes=True), check=check, seconds=60.0, megabytes=8000)
