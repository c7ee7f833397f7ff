# SPDX-License-Identifier: Apache-2.0
"""Colour words: names of colours by the survey in color_survey.txt.

A colour has the word that most of the survey's nearest colours end with, as "blue" in "dark sky blue"; distance is that
in Oklab, a perceptually uniform colour space. The survey has few pale and few neutral colours, so greys go by their
lightness alone.
"""

from __future__ import annotations

import functools
from importlib import resources

import numpy as np
from numpy.typing import ArrayLike, NDArray

from livecl.drawing.colors import oklab, parse_color

#: Basic words, each with the last words of the survey's names that stand for it.
BASIC_WORDS = {
    "gray": "grey gray",
    "black": "black",
    "white": "white",
    "red": "red maroon crimson scarlet burgundy",
    "pink": "pink rose salmon",
    "magenta": "magenta fuchsia",
    "purple": "purple violet lavender lilac mauve plum indigo",
    "blue": "blue navy azure",
    "turquoise": "turquoise cyan aqua aquamarine",
    "teal": "teal",
    "green": "green",
    "lime": "lime",
    "olive": "olive khaki",
    "yellow": "yellow gold mustard",
    "orange": "orange",
    "peach": "peach",
    "beige": "beige tan cream sand",
    "brown": "brown chocolate rust sienna umber ochre",
}
#: Colours of the survey that vote; with 5, 80 % of its own names are found by the others.
VOTERS = 5
#: Oklab chroma under which a colour is a grey, and lightness up to which it is black, dark, plain and light.
NEUTRAL_CHROMA = 0.02
NEUTRALS = ((0.2, "black"), (0.45, "dark gray"), (0.8, "gray"), (0.96, "light gray"), (np.inf, "white"))
#: Oklab lightness under which a word gets "dark", and from which it gets "light"; words without bounds get neither.
DARK_LIGHT = {
    "red": (0.4, 2.0),
    "pink": (0.0, 0.85),
    "purple": (0.4, 0.75),
    "blue": (0.4, 0.75),
    "green": (0.45, 0.8),
    "brown": (0.36, 0.6),
    "gray": (0.45, 0.8),
}
#: Oklab chroma from which a colour is too vivid to be called light, as pure green.
VIVID = 0.2

FloatArray = NDArray[np.float64]


def color_names(rgb: ArrayLike) -> list[str]:
    """Name sRGB colours (N, 3) in [0, 1] by basic words, as "light blue"."""
    words, places = _survey()
    return [_name(place, words, places) for place in oklab(rgb).reshape(-1, 3)]


def _name(place: FloatArray, words: list[str], places: FloatArray) -> str:
    """Name a colour in Oklab (3,)."""
    lightness, chroma = float(place[0]), float(np.hypot(*place[1:]))
    if chroma < NEUTRAL_CHROMA:
        return next(name for limit, name in NEUTRALS if lightness <= limit)
    distances = np.linalg.norm(places - place, axis=1)
    votes: dict[str, float] = {}
    for nearest in np.argsort(distances, kind="stable")[:VOTERS]:
        votes[words[nearest]] = votes.get(words[nearest], 0.0) + 1 / (distances[nearest] + 0.01)
    word = max(votes, key=votes.__getitem__)
    dark, light = DARK_LIGHT.get(word, (0.0, np.inf))
    if lightness < dark:
        return f"dark {word}"
    return f"light {word}" if lightness >= light and chroma < VIVID else word


@functools.cache
def _survey() -> tuple[list[str], FloatArray]:
    """Return the basic word and the place in Oklab (N, 3) of each colour of the survey."""
    text = resources.files(__package__).joinpath("color_survey.txt").read_text(encoding="utf-8")
    basic = {last: word for word, lasts in BASIC_WORDS.items() for last in lasts.split()}
    entries = [line.split(" ", 1) for line in text.splitlines() if not line.startswith("# ")]
    return [basic[name.split()[-1]] for _, name in entries], oklab([parse_color(code) for code, _ in entries])
