# SPDX-License-Identifier: Apache-2.0
"""Colour names: name colours by basic words, from the survey in color_survey.txt.

The survey's nearest colours vote for the words in their names: fully for the last word, as "blue" in "dark sky blue",
half for others, as in "blue green" or "bluish grey". Distances are in Oklab, a perceptually uniform colour space, with
lightness weighted by half, as names depend on hue more than on lightness. The survey has few pale and few neutral
colours, so greys are named by lightness alone.
"""

from __future__ import annotations

import functools
import re
from importlib import resources

import numpy as np
from numpy.typing import ArrayLike

from livecl.arrays import FloatArray
from livecl.drawing.colors import oklab, parse_color

#: Basic words, each with its synonyms among the last words of the survey's names.
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
#: Number of the survey's colours that vote, weight of lightness in the distance, and vote for a word that is not the
#: last.
VOTERS, LIGHTNESS, HALF = 5, 0.5, 0.5
#: Endings that a word may have in a name, as in "greenish blue".
ENDINGS = ("ish", "dish", "nish", "y", "ey")
#: Oklab chroma below which a colour is grey, and the largest lightness of black, dark, plain and light grey.
NEUTRAL_CHROMA = 0.02
NEUTRALS = ((0.2, "black"), (0.45, "dark gray"), (0.8, "gray"), (0.96, "light gray"), (np.inf, "white"))
#: Oklab lightness below which a colour is "dark", and from which on it is "light"; words without bounds get neither.
DARK_LIGHT = {
    "red": (0.4, 2.0),
    "pink": (0.0, 0.85),
    "purple": (0.4, 0.75),
    "blue": (0.4, 0.75),
    "green": (0.45, 0.8),
    "brown": (0.36, 0.6),
    "gray": (0.45, 0.8),
}
#: Oklab chroma from which on a colour is too vivid to be called light, as pure green.
VIVID = 0.2


def color_names(rgb: ArrayLike) -> list[str]:
    """Name sRGB colours (N, 3) in [0, 1] by basic words, as "light blue"."""
    votes, places = _survey()
    return [_name(place, votes, places) for place in oklab(rgb).reshape(-1, 3)]


def _name(place: FloatArray, votes: list[dict[str, float]], places: FloatArray) -> str:
    """Name a colour in Oklab (3,) by the votes of the survey's colours at places (N, 3)."""
    lightness, chroma = float(place[0]), float(np.hypot(*place[1:]))
    if chroma < NEUTRAL_CHROMA:
        return next(name for limit, name in NEUTRALS if lightness <= limit)
    distances = np.linalg.norm((places - place) * (LIGHTNESS, 1, 1), axis=1)
    counts: dict[str, float] = {}
    for nearest in np.argsort(distances, kind="stable")[:VOTERS]:
        for word, vote in votes[nearest].items():
            counts[word] = counts.get(word, 0.0) + vote / (distances[nearest] + 0.01)
    word = max(counts, key=counts.__getitem__)
    dark, light = DARK_LIGHT.get(word, (0.0, np.inf))
    if lightness < dark:
        return f"dark {word}"
    return f"light {word}" if lightness >= light and chroma < VIVID else word


def words_of(name: str) -> dict[str, float]:
    """Return the basic words in a name of the survey with their votes: the last word counts 1, others half."""
    basic = {last: word for word, lasts in BASIC_WORDS.items() for last in lasts.split()}
    *others, last = re.split("[ /]", name)
    votes = {basic[last]: 1.0} if last in basic else {}
    for part in others:
        stem = next((part.removesuffix(end) for end in ENDINGS if part.removesuffix(end) in basic), part)
        if stem in basic:
            votes.setdefault(basic[stem], HALF)
    return votes


@functools.cache
def _survey() -> tuple[list[dict[str, float]], FloatArray]:
    """Return the basic words and the Oklab coordinates (N, 3) of the survey's colours."""
    entries = survey_entries()
    return [words_of(name) for _, name in entries], oklab([parse_color(code) for code, _ in entries])


def survey_entries() -> list[tuple[str, str]]:
    """Return code and name of each colour of the survey."""
    text = resources.files(__package__).joinpath("color_survey.txt").read_text(encoding="utf-8")
    lines = [line.partition(" ") for line in text.splitlines() if not line.startswith("# ")]
    return [(code, name) for code, _, name in lines]
