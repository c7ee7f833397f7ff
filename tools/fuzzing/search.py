# SPDX-License-Identifier: Apache-2.0
"""Hypothesis looks for cases that go wrong, and makes each as small as it can.

The makers of cases are the fuzzer's own, on random numbers that Hypothesis chooses, and so can make smaller. Where
their content hangs on NumPy's generators, which it cannot choose for, cases are made of strategies here. Small means
few and simple choices: of a picture file few changes are left, but no smaller file. Cases are tried in this process:
what crashes it, fills the memory or never ends is for the worker to find.
"""

from __future__ import annotations

import collections
import dataclasses
import random
from typing import Any

import numpy as np
from hypothesis import HealthCheck, Phase, Verbosity, given, settings
from hypothesis import seed as seeded
from hypothesis import strategies as st
from hypothesis.errors import Flaky
from hypothesis.extra.numpy import arrays

from fuzzing import drawings, runs
from fuzzing.kind import Kind
from fuzzing.mutation import mutated
from fuzzing.svgs import Grammar
from fuzzing.worker import described, strictly_checked

#: Most subpaths of a layer and layers of a drawing; `tools/fuzz.py` tries many without Hypothesis.
MOST_SUBPATHS, MOST_LAYERS = 3, 4
#: Most segments of a subpath.
MOST_SEGMENTS = 6
#: Side, px, of the largest pictures that are vectorized.
LARGEST_SIDE = 12


@dataclasses.dataclass(frozen=True)
class Smallest:
    """The smallest case found that goes wrong at a place; `always` is False where it did not do so again."""

    what: str
    case: Any
    always: bool = True


def search(
    kind: Kind, cases: st.SearchStrategy[Any], *, seed: int, most: int
) -> tuple[collections.Counter[str], list[Smallest]]:
    """Look for cases that go wrong.

    Parameters
    ----------
    kind : Kind
        What has to hold of each.
    cases : SearchStrategy
        What they are drawn from.
    seed : int
        The same seed gives the same cases.
    most : int
        Number of cases, besides those that are tried to make one smaller.

    Returns
    -------
    counts : Counter
        Outcomes of those that went well.
    found : list of Smallest
        The smallest case of each place where something goes wrong.
    """
    counts: collections.Counter[str] = collections.Counter()
    last: dict[str, Smallest] = {}

    @seeded(seed)
    @settings(
        max_examples=most,
        database=None,  # what was found before is found again by its seed
        deadline=None,
        phases=(Phase.generate, Phase.shrink),
        suppress_health_check=list(HealthCheck),
        verbosity=Verbosity.quiet,
    )
    @given(cases)
    def holds(case: Any) -> None:
        try:
            counts[strictly_checked(kind, case)] += 1
        except Exception as error:
            where, what = described(error)
            last[where] = Smallest(what, case)
            raise

    try:
        holds()
    except Flaky:
        return counts, [dataclasses.replace(one, always=False) for one in last.values()]
    except Exception:
        if not last:  # no case's error
            raise
    # Hypothesis tries the smallest case of each place last.
    return counts, list(last.values())


def cases_of(name: str, kind: Kind) -> st.SearchStrategy[Any]:
    """Return what the cases of a kind are drawn from."""
    numbers = st.randoms(use_true_random=False)
    made = numbers.map(kind.make)
    return {"svgs": numbers.map(document), "drawings": drawing_cases(), "runs": run_cases(made)}.get(name, made)


def document(rng: random.Random) -> bytes:
    """Return a document by the grammar, some changed bytewise; a whole file is few choices, but no small case."""
    made = Grammar(rng, rng.choice((0.0, 0.003, 0.05))).document()
    return made if rng.random() < 0.7 else mutated(rng, made, [made])


@st.composite
def drawing_cases(draw: st.DrawFn) -> drawings.Case:
    """Return arguments of a drawing, at most one of them odd."""
    size = draw(st.sampled_from(drawings.SIZES))
    near = st.integers(-2, max(size) + 2).map(float) | st.floats(-2, max(size) + 2)
    far = st.floats(-drawings.MAX_COORDINATE, drawings.MAX_COORDINATE)
    coordinates = draw(st.sampled_from((near, near, near | far)))
    subpaths = st.integers(1, MOST_SEGMENTS).flatmap(
        lambda count: arrays(np.float64, (count, 3, 2), elements=coordinates)
    )
    layers = draw(st.lists(st.lists(subpaths, min_size=1, max_size=MOST_SUBPATHS), max_size=MOST_LAYERS))
    parts = [part for layer in layers for part in layer]
    shares = st.sampled_from((0.0, 1.0, 0.5)) | st.floats(0, 1)
    case: drawings.Case = {
        "points": np.concatenate([np.zeros((0, 3, 2)), *parts]),
        "colors": draw(arrays(np.float64, (len(layers), 4), elements=shares)),
        "size": size,
        "background": draw(st.none() | st.lists(shares, min_size=3, max_size=3)),
        "subpath_offsets": np.cumsum([0, *map(len, parts)]),
        "layer_offsets": np.cumsum([0, *map(len, layers)]),
    }
    odd = draw(st.sampled_from(("none", "none", "none", "number", "offset", "argument")))
    if odd == "number" and layers:
        array = case[draw(st.sampled_from(("points", "colors")))].reshape(-1)
        array[draw(st.integers(0, array.size - 1))] = draw(st.sampled_from(drawings.ODD_NUMBERS) | st.floats())
    elif odd == "offset":
        offsets = case[draw(st.sampled_from(("subpath_offsets", "layer_offsets")))]
        offsets[draw(st.integers(0, len(offsets) - 1))] = draw(st.integers(-2, len(case["points"]) + 2))
    elif odd == "argument":
        case[draw(st.sampled_from(("stages", "names", *case)))] = draw(st.sampled_from(drawings.ODD_VALUES))
    return case


@st.composite
def run_cases(draw: st.DrawFn, made: st.SearchStrategy[runs.Case]) -> runs.Case:
    """Return a recipe as the fuzzer makes it, and a picture of a few colours, pixel by pixel."""
    shape = (draw(st.integers(1, LARGEST_SIDE)), draw(st.integers(1, LARGEST_SIDE)), draw(st.sampled_from((3, 4))))
    pixels = arrays(np.float64, shape, elements=st.sampled_from((0.0, 1.0, 0.5)) | st.floats(0, 1))
    return draw(made) | {"pixels": draw(pixels)}
