# SPDX-License-Identifier: Apache-2.0
"""Colour words against what people say: swatches by hand, CSS names, and the survey's own colours."""

from __future__ import annotations

import re

import numpy as np
import pytest

from livecl.drawing import color_words
from livecl.drawing.color_words import BASIC_WORDS, color_names
from livecl.drawing.colors import parse_color

SWATCHES = {
    "black": "#000000 #0a0a0a #141414",
    "dark gray": "#404040 #4a4a4a #333639",
    "gray": "#808080 #a0a0a0 #636363 #9b9b9b #5d6771",
    "light gray": "#cacaca #e0e0e0 #e6e6e6 #eeeeee",
    "white": "#ffffff #f4f4f4 #fafafa",
    "red": "#ff0000 #e50000 #f8312f #dc143c",
    "dark red": "#840000 #8b0000",
    "pink": "#ff69b4 #ff81c0 #f08080",
    "orange": "#ffa500 #f97306 #ff8c00 #ffb02e",
    "yellow": "#ffff00 #fcd53f #fcc73d #ffd700",
    "green": "#00ff00 #228b22 #15b01a #00d26a #008000",
    "dark green": "#033500 #1c4422 #006400",
    "light green": "#96f97b #98fb98",
    "blue": "#0000ff #4169e1 #3661a5 #1e90ff #00a6ed #4682b4",
    "dark blue": "#000080 #00035b #1f3a68",
    "light blue": "#87ceeb #add8e6 #95d0fc",
    "turquoise": "#40e0d0 #00ffff",
    "purple": "#800080 #7e1e9c #8d65c5",
    "brown": "#664e27 #6d4534 #8b4513",
    "dark brown": "#3b2314",
    "beige": "#e6daa6 #d1b26f",
}


@pytest.mark.parametrize(("name", "codes"), SWATCHES.items())
def test_swatches(name: str, codes: str) -> None:
    found = {code: color_names([parse_color(code)])[0] for code in codes.split()}
    assert found == dict.fromkeys(codes.split(), name)


def test_most_css_names_end_with_the_word() -> None:
    """Of the CSS names that end with a basic word; they were no part of the survey, and some contradict it."""
    from PIL import ImageColor

    basic = {last: word for word, lasts in BASIC_WORDS.items() for last in lasts.split()}
    names = {name: next((w for last, w in basic.items() if name.endswith(last)), None) for name in ImageColor.colormap}
    known = {name: word for name, word in names.items() if word is not None}
    agree = [color_names([parse_color(name)])[0].split()[-1] == word for name, word in known.items()]
    assert len(known) > 90 and np.mean(agree) > 0.65


def test_the_survey_finds_its_own_names_without_the_colour_itself() -> None:
    words, places = color_words._survey()
    assert len(words) == len(places) > 700
    found = []
    for number in range(0, len(words), 7):
        kept = np.arange(len(words)) != number
        name = color_words._name(places[number], [w for w, k in zip(words, kept, strict=True) if k], places[kept])
        found.append(name.split()[-1] == words[number])
    assert np.mean(found) > 0.75


def test_names_are_one_or_two_plain_words_and_all_at_once() -> None:
    colors = np.random.default_rng(3).uniform(size=(200, 3))
    names = color_names(colors)
    assert all(re.fullmatch("((dark|light) )?[a-z]+", name) for name in names)
    assert names == [color_names(color[None])[0] for color in colors]
    assert color_names(np.zeros((0, 3))) == []
