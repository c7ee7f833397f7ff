# SPDX-License-Identifier: Apache-2.0
"""Options: the presets are what they are named for, and wrong values are refused by the field's name."""

from __future__ import annotations

import dataclasses
import inspect
import math
from typing import Any, get_args, get_type_hints

import numpy as np
import pytest

from livecl.options import PRESETS, Options

# The paper's text, and what it leaves open as settled for this project. A new option has to say here what makes it what
# the paper does, which says nothing of most of them.
PAPER = {
    "pixels_per_path": 0,
    "iterations": 500,
    "segments": 4,
    "loss": "udf",
    "xing_weight": 0.01,
    "placement": "component",
    "shape": "circle",
    "background": "white",
    "radius": 5.0,
    "tau": 10.0,
    "color_threshold": 0.1,
    "bins": 200,
    "learning_rate": 1.0,
    "color_learning_rate": 0.01,
    "new_color": "target",
    "variant": "paper",
    # no part of the paper, off:
    "max_segments": 4,
    "holes": False,
    "merge": False,
    "settle": 1.0,
    "end_early": False,
    "revisions": 0,
    "prune": 0.0,
    "target_mse": 0.0,
    "path_gain": 0.0,
    "simplify": False,
    "primitives": False,
    "colors": 0,
    "palette": "",
    "untangle": False,
    "trim": False,
    "full_rate_side": 0.0,
    "decay": 1.0,
    "opacity": "train",
    "fills": "solid",
    "strokes": "off",
}


def test_paper_is_the_paper_s_text() -> None:
    assert dataclasses.asdict(Options.paper()) == PAPER


def test_released_differs_from_it_as_the_program_does() -> None:
    # Learning rates fall to 0.4 in 500 steps, a further factor of 1e-3 on the Xing loss; the weight map, the Xing
    # loss's paths and the squared difference's bins come with the variant.
    changes = {"variant": "released", "decay": 0.4, "xing_weight": 0.01 * 1e-3}
    assert dataclasses.asdict(Options.released()) == {**PAPER, **changes}


def test_diffvg_is_the_paper_s_comparison() -> None:
    changes = {"loss": "mse", "xing_weight": 0.0, "placement": "random", "shape": "random", "new_color": "random"}
    assert dataclasses.asdict(Options.diffvg()) == {**PAPER, **changes}


def test_presets_by_name() -> None:
    assert {name: preset() for name, preset in PRESETS.items()} == {
        "default": Options(),
        "paper": Options.paper(),
        "released": Options.released(),
        "diffvg": Options.diffvg(),
        "icon": Options(opacity="opaque", prune=2e-4),
        "clipart": Options(prune=2e-5),
        "photo": Options(),
        "draft": Options(iterations=60, revisions=0),
    }


@pytest.mark.parametrize("name", PRESETS)
def test_presets_take_changes(name: str) -> None:
    options = PRESETS[name](iterations=7, background="#102030")
    assert options == dataclasses.replace(PRESETS[name](), iterations=7, background="#102030")
    with pytest.raises(ValueError, match=r"^iterations: got 0"):
        PRESETS[name](iterations=0)


def test_options_are_frozen_and_equal_by_value() -> None:
    with pytest.raises(dataclasses.FrozenInstanceError):
        Options().iterations = 3  # type: ignore[misc]
    assert Options.paper() == Options.paper() and Options.paper() != Options.released()
    assert hash(Options()) == hash(Options())


COUNTS = [name for name, hint in get_type_hints(Options).items() if hint is int]
NUMBERS = [name for name, hint in get_type_hints(Options).items() if hint is float]
WORDS = {name: get_args(hint) for name, hint in get_type_hints(Options).items() if get_args(hint)}
FLAGS = [name for name, hint in get_type_hints(Options).items() if hint is bool]


def test_every_option_is_of_a_kind_that_is_checked() -> None:
    assert {*COUNTS, *NUMBERS, *WORDS, *FLAGS, "background", "palette"} == {
        field.name for field in dataclasses.fields(Options)
    }


@pytest.mark.parametrize("value", [-1, 2.0, "3", None, True, math.nan])
@pytest.mark.parametrize("name", COUNTS)
def test_counts_are_whole_numbers(name: str, value: Any) -> None:
    with pytest.raises(ValueError, match=rf"^{name}: got .*, wanted a whole number of at least [01]$"):
        Options(**{name: value})


@pytest.mark.parametrize("name", COUNTS)
def test_counts_may_be_small(name: str) -> None:
    assert getattr(Options(**{name: 1}), name) == 1
    if name in ("revisions", "colors", "pixels_per_path"):
        assert getattr(Options(**{name: 0}), name) == 0
    else:
        with pytest.raises(ValueError, match=rf"^{name}: got 0, wanted a whole number of at least 1$"):
            Options(**{name: 0})


@pytest.mark.parametrize("value", ["blurple", "red,", "#12345", "rgb(1 2 3 / .5)", 3, None, ["red"]])
def test_palettes_are_colors(value: Any) -> None:
    with pytest.raises(ValueError, match=r"^palette: got "):
        Options(palette=value)
    assert Options(palette="red, #123456").palette == "red, #123456"


@pytest.mark.parametrize("value", [-0.5, math.inf, -math.inf, math.nan, "1", None, [1.0], 10**400, True])
@pytest.mark.parametrize("name", NUMBERS)
def test_numbers_are_finite_and_not_negative(name: str, value: Any) -> None:
    with pytest.raises(ValueError, match=rf"^{name}: got "):
        Options(**{name: value})


def test_what_was_got_is_quoted_in_part_where_it_is_long() -> None:
    with pytest.raises(ValueError, match=r"^tau: got 'xxx") as caught:
        Options(tau="x" * 10_000)  # type: ignore[arg-type]
    assert len(str(caught.value)) < 100
    with pytest.raises(ValueError, match=r"^background: got \[1000") as caught:
        Options(background=[10**400])  # type: ignore[arg-type]
    assert len(str(caught.value)) < 300


@pytest.mark.parametrize("name", ["radius", "tau", "learning_rate", "color_learning_rate", "decay"])
def test_lengths_and_rates_are_positive(name: str) -> None:
    with pytest.raises(ValueError, match=rf"^{name}: got 0, wanted a positive number$"):
        Options(**{name: 0})
    assert getattr(Options(**{name: 1}), name) == 1


@pytest.mark.parametrize("name", ["xing_weight", "settle", "color_threshold"])
def test_weights_may_be_zero(name: str) -> None:
    assert getattr(Options(**{name: 0.0}), name) == 0


@pytest.mark.parametrize("value", ["", "UDF", "none", 1, None, ["udf"]])
@pytest.mark.parametrize("name", WORDS)
def test_words_are_among_those_named(name: str, value: Any) -> None:
    with pytest.raises(ValueError, match=rf"^{name}: got .*, wanted '") as caught:
        Options(**{name: value})
    assert all(repr(word) in str(caught.value) for word in WORDS[name])


@pytest.mark.parametrize(("name", "word"), [(name, word) for name, words in WORDS.items() for word in words])
def test_all_words_are_taken(name: str, word: str) -> None:
    assert getattr(Options.paper(**{name: word}), name) == word


@pytest.mark.parametrize("value", ["no", "false", 2, None])
@pytest.mark.parametrize("name", FLAGS)
def test_flags_are_true_or_false(name: str, value: Any) -> None:
    with pytest.raises(ValueError, match=rf"^{name}: got "):
        Options(**{name: value})


@pytest.mark.parametrize("value", ["", "whit", "#12", "#gggggg", "rgba(1, 2, 3, 0.5)", "transparent", None, 3])
def test_background_is_an_opaque_color(value: Any) -> None:
    with pytest.raises(ValueError, match=r"^background: ") as caught:
        Options(background=value)
    assert "\n" not in str(caught.value)


def test_an_outline_needs_a_region() -> None:
    for placement in ("region", "component"):
        assert Options(placement=placement, shape="outline").shape == "outline"
    with pytest.raises(ValueError, match=r"^shape: 'outline' needs a region to fit"):
        Options(placement="random", shape="outline")


def test_unknown_names_are_refused() -> None:
    with pytest.raises(TypeError, match="radios"):
        Options(radios=3)  # type: ignore[call-arg]


def test_choosing_paths_sets_a_gain_unless_there_is_one() -> None:
    chosen = Options(iterations=9).choosing_paths()
    assert chosen.path_gain > 0 and dataclasses.replace(chosen, path_gain=0.0) == Options(iterations=9)
    assert Options(path_gain=0.25).choosing_paths() == Options(path_gain=0.25)


def test_presets_are_those_of_the_command_line() -> None:
    assert Options.preset("default") == Options()
    assert Options.preset("paper", iterations=7) == Options.paper(iterations=7)
    assert Options.preset("icon").opacity == "opaque" and Options.preset("icon").prune > Options().prune
    with pytest.raises(ValueError, match=r"^preset: got 'icons', wanted 'default' or "):
        Options.preset("icons")


def test_numbers_of_numpy_are_kept_as_pythons_own() -> None:
    options = Options(iterations=np.int64(7), settle=np.float32(0.5), holes=np.bool_(False))
    assert options == Options(iterations=7, settle=0.5, holes=False)
    assert [type(value) for value in (options.iterations, options.settle, options.holes)] == [int, float, bool]
    with pytest.raises(ValueError, match=r"^iterations: got 7\.5"):
        Options(iterations=np.float64(7.5))


def test_the_docstring_has_every_field() -> None:
    text = inspect.getdoc(Options) or ""
    assert "\nRaises\n------\n" in text and max(map(len, text.splitlines())) <= 120
    assert '\nloss : "udf" or "mse"\n    Loss: squared error weighted by distance (udf, eq. 1-2) or ' in text
    for field in dataclasses.fields(Options):
        assert f"\n{field.name} : " in text


def test_unknown_fields_get_a_hint() -> None:
    for make in (Options, Options.paper, lambda **values: Options.preset("icon", **values)):
        with pytest.raises(TypeError, match="there is no field 'prun'; did you mean 'prune'"):
            make(prun=1e-3)
    assert inspect.signature(Options).parameters["prune"].default == 5e-6
