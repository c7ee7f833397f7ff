# SPDX-License-Identifier: Apache-2.0
"""Whole runs on tiny random pictures, of few iterations: a finite result, whose SVG is read back as its drawing."""

from __future__ import annotations

import random
from typing import Any, get_args, get_type_hints

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from fuzzing.kind import CHOSEN, EVEN, Kind
from fuzzing.svgs import same
from livecl.options import PRESETS, Options
from livecl.run.recipe import Recipe
from livecl.svg import format_svg, read_svg

#: Sides of the pictures, px.
SIDES = (1, 1, 2, 3, 7, 8, 9, 16, 24, 33)

Case = dict[str, Any]


def picture(rng: random.Random) -> np.ndarray:
    """Return noise, areas of few colours, a gradient or a single colour, with or without alpha."""
    numbers = np.random.default_rng(rng.getrandbits(64))
    height, width, channels = rng.choice(SIDES), rng.choice(SIDES), rng.choice((3, 3, 4))
    way = rng.choice(("noise", "areas", "areas", "gradient", "flat", "dots"))
    if way == "noise":
        pixels = numbers.uniform(size=(height, width, channels))
    elif way == "areas":
        coarse = numbers.choice([0.0, 0.5, 1.0], (-(-height // 6), -(-width // 6), channels))
        pixels = np.kron(coarse, np.ones((6, 6, 1)))[:height, :width]
    elif way == "gradient":
        pixels = np.linspace(numbers.uniform(size=(width, channels)), numbers.uniform(size=(width, channels)), height)
    else:
        pixels = np.broadcast_to(numbers.choice([0.0, 0.3, 1.0], channels), (height, width, channels)).copy()
        if way == "dots":
            pixels[numbers.uniform(size=(height, width)) < 0.1] = numbers.choice([0.0, 1.0])
    return pixels


def make(rng: random.Random) -> Case:
    """Return a recipe of few iterations and a few changes of a preset."""
    hints = get_type_hints(Options)
    choices = {name: get_args(hint) or (False, True) for name, hint in hints.items() if hint is bool or get_args(hint)}
    choices.pop("variant")  # goes with few others, which the preset of that name has
    numbers = {
        "segments": (1, 2, 5),
        "background": ("white", "none", "auto", "train", "picture", "#123456"),
        "learning_rate": (1e-6, 1.0, 1e3),
        "color_learning_rate": (1e-6, 0.01, 10.0),
        "xing_weight": (0.0, 0.01, 1e3),
        "radius": (1e-3, 5.0, 100.0),
        "tau": (1e-3, 10.0, 1e3),
        "path_gain": (0.0, 1e-3),
    }
    names = rng.sample([*choices, *numbers], rng.choice((0, 1, 2, 4)))
    changes = {name: rng.choice(choices.get(name) or numbers[name]) for name in names}
    return {
        "preset": rng.choice(list(PRESETS)),
        "changes": changes | {"iterations": rng.randint(1, 3), "revisions": rng.choice((0, 0, 1))},
        "schedule": rng.choice(("1", "1,1", "1,2", "3,1,1")),
        "size": rng.choice((0, 0, 5)),
        "precision": rng.choice((0, 3, 6)),
        "seed": rng.randrange(1000),
    }


def check(case: Case) -> str:
    """Run it, unless its options do not go together."""
    try:
        options = PRESETS[case["preset"]](**case["changes"])
    except ValueError:
        return "options refused"
    recipe = Recipe(options=options, **{name: case[name] for name in ("schedule", "size", "precision", "seed")})
    result = recipe.vectorize(case["pixels"].astype(np.float32))
    assert np.isfinite(result.mse) and result.mse >= 0, result.mse
    assert result.drawing.size == case["pixels"].shape[:2], result.drawing.size
    text = recipe.svg(result.drawing)
    again = read_svg(text.encode())
    same(result.drawing, again, with_stages=True)
    assert format_svg(again, recipe.precision) == text
    return f"done, {'some' if result.drawing.num_layers else 'no'} layers"


PIXELS = st.tuples(st.integers(1, 12), st.integers(1, 12), st.sampled_from((3, 4))).flatmap(
    lambda shape: arrays(np.float64, shape, elements=st.sampled_from((0.0, 1.0, 0.5)) | st.floats(0, 1))
)
CASES, OTHERS = (
    st.builds(lambda case, pixels: {**case, "pixels": pixels}, numbers.map(make), pixels)
    for numbers, pixels in ((CHOSEN, PIXELS), (EVEN, EVEN.map(picture)))
)
KIND = Kind(cases=CASES, others=OTHERS, check=check, seconds=120.0, megabytes=8000)
