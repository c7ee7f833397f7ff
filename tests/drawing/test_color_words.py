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
    "dark brown": "#3b2314 #4a3419",
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


#: CIEDE2000 difference within which the survey's names of other colours count as names of a colour, too.
SAME = 4.0


def test_people_of_the_survey_would_accept_the_words() -> None:
    """Each colour of the survey, named by the others: 95 % get a basic word that the survey's people gave to it, or to
    a colour that is hardly another (R. Munroe's survey of 2010, CC0: 222 500 sessions, the names given most)."""
    from skimage.color import deltaE_ciede2000, rgb2lab

    entries = color_words.survey_entries()
    votes, places = color_words._survey()
    assert len(votes) == len(places) == len(entries) > 700
    lab = rgb2lab(np.array([parse_color(code) for code, _ in entries]))
    accepted = same = 0
    for number in range(len(entries)):
        kept = np.arange(len(votes)) != number
        others = [vote for vote, k in zip(votes, kept, strict=True) if k]
        word = color_words._name(places[number], others, places[kept]).split()[-1]
        near = np.flatnonzero(deltaE_ciede2000(lab, lab[[number]]) <= SAME)
        accepted += any(word in votes[k] for k in near)
        same += word in votes[number]
    assert accepted >= 0.95 * len(entries)
    assert same >= 0.85 * len(entries)


def test_words_in_names() -> None:
    assert color_words.words_of("dark sky blue") == {"blue": 1}
    assert color_words.words_of("greenish blue") == color_words.words_of("green/blue") == {"blue": 1, "green": 0.5}
    assert color_words.words_of("reddish brown") == {"brown": 1, "red": 0.5}
    assert color_words.words_of("windows") == {}


def test_names_are_one_or_two_plain_words_and_all_at_once() -> None:
    colors = np.random.default_rng(3).uniform(size=(200, 3))
    names = color_names(colors)
    assert all(re.fullmatch("((dark|light) )?[a-z]+", name) for name in names)
    assert names == [color_names(color[None])[0] for color in colors]
    assert color_names(np.zeros((0, 3))) == []
