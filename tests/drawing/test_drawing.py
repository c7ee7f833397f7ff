# SPDX-License-Identifier: Apache-2.0
"""`Drawing` refuses arguments that do not fit, by name; none is cast to something else in silence."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from livecl.drawing import Drawing, concatenate

FITTING: dict[str, Any] = {
    "points": np.zeros((6, 3, 2)),
    "colors": np.zeros((2, 4)),
    "size": (8, 9),
    "background": (1, 1, 1),
    "subpath_offsets": [0, 3, 6],
    "layer_offsets": [0, 1, 2],
    "stages": [0, 1],
    "names": ["a", "b"],
}
#: What is no array of numbers.
NO_NUMBERS = [
    "abc",
    [["1", "2"]],
    {},
    object,
    [None],
    [[1.0], [1.0, 2.0]],
    [10**400],
    [1j],
    np.zeros((6, 3, 2), complex),
]


def refusal(**changes: Any) -> str:
    with pytest.raises(ValueError) as caught:
        Drawing(**{**FITTING, **changes})
    message = str(caught.value)
    assert message.startswith(tuple(changes)) and message.isprintable() and len(message) < 300
    return message


def test_what_fits() -> None:
    drawing = Drawing(**{**FITTING, "names": np.array(["a", "b"]), "stages": np.array([3.0, -1.0])})
    assert drawing.stages.tolist() == [3, -1] and drawing.names == ("a", "b")


@pytest.mark.parametrize("value", NO_NUMBERS)
@pytest.mark.parametrize("name", ["points", "colors", "background", "subpath_offsets", "layer_offsets", "stages"])
def test_arrays_of_anything_but_numbers(name: str, value: Any) -> None:
    assert "wanted an array of numbers" in refusal(**{name: value})


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, 1.1e6, 1e308])
def test_coordinates_that_are_too_large_or_none(value: float) -> None:
    points = np.zeros((6, 3, 2))
    points[5, 2, 1] = value
    assert "finite and within" in refusal(points=points)


@pytest.mark.parametrize("value", [math.nan, math.inf, -0.1, 1.1])
def test_colours_beyond_their_range(value: float) -> None:
    assert "finite and within [0, 1]" in refusal(colors=[[0, 0, 0, 1], [0, 0, value, 1]])
    assert "finite and within [0, 1]" in refusal(background=[0, 0, value])


@pytest.mark.parametrize("name", ["subpath_offsets", "layer_offsets", "stages"])
@pytest.mark.parametrize("value", [1.5, 2**32 + 1, -(2**31) - 1, math.nan, 1e300])
def test_whole_numbers_are_neither_cut_nor_wrapped(name: str, value: float) -> None:
    """Cast to 32 bits, 2^32 + 1 is 1, and so is 1.5."""
    refusal(**{name: [0, value, 6] if name == "subpath_offsets" else [0, value, 2][: 3 - (name == "stages")]})


@pytest.mark.parametrize(
    "offsets", [[0, 3], [0, 3, 5], [1, 3, 6], [0, 0, 6], [0, 7, 6], [[0, 3, 6]], [], [0, 3, 6, 6], 3]
)
def test_offsets_that_do_not_rise_to_the_end(offsets: Any) -> None:
    refusal(subpath_offsets=offsets, layer_offsets=[0, 1, 2])


@pytest.mark.parametrize(
    "size", [(math.inf, 3), (math.nan, 3), (3, 2.5), (0, 3), (3, 32769), (10**400, 3), "ab", None, 7, (1, 2, 3), {}]
)
def test_sizes_that_are_none(size: Any) -> None:
    assert "wanted" in refusal(size=size)


@pytest.mark.parametrize("names", ["ab", ["a"], ["a", 1], 3, [b"a", b"b"], ["a"] * 10_000])
def test_names_that_are_none(names: Any) -> None:
    assert "wanted 2 texts, one for each layer" in refusal(names=names)


def test_replace_names_what_was_given() -> None:
    drawing = Drawing(**FITTING)
    for change, message in (
        ({"points": np.zeros((4, 3, 2))}, "points: the drawing's own subpath_offsets no longer fit"),
        ({"colors": np.zeros((1, 4))}, "colors: the drawing's own layer_offsets no longer fit"),
        ({"names": ["a"]}, r"names: got \['a'\]"),
    ):
        with pytest.raises(ValueError, match=f"^{message}"):
            drawing.replace(**change)
    with pytest.raises(TypeError, match="no argument 'color'; did you mean 'colors'"):
        drawing.replace(color=np.zeros((2, 4)))


def test_concatenate() -> None:
    below = Drawing(**FITTING)
    above = below.replace(names=["c", "d"], background=None)
    both = concatenate(below, above)
    assert both.names == ("a", "b", "c", "d") and both.layer_offsets.tolist() == [0, 1, 2, 3, 4]
    np.testing.assert_array_equal(both.background, below.background)
    with pytest.raises(ValueError, match=r"^above: a canvas of \(4, 4\) px, wanted that of below"):
        concatenate(below, above.replace(size=(4, 4)))
    with pytest.raises(TypeError, match=r"^above: got list, wanted a livecl\.Drawing"):
        concatenate(below, [above])  # type: ignore[arg-type]


def test_a_drawing_shows_itself_in_a_line() -> None:
    drawing = Drawing(**FITTING)
    assert repr(drawing) == "<Drawing of 2 layers, 6 segments, 9 x 8 px, background #ffffff>"
    assert repr(drawing.replace(background=None)).endswith(", no background>")
