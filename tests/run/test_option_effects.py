# SPDX-License-Identifier: Apache-2.0
"""Every option has an effect."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from support.runs import QUICK, SMALL

from livecl import Options, vectorize

CHANGES: dict[str, tuple[Options, dict[str, Any]]] = {
    "iterations": (QUICK, {"iterations": 7}),
    "segments": (QUICK, {"segments": 5}),
    "loss": (QUICK, {"loss": "mse"}),
    "xing_weight": (Options.diffvg(iterations=6), {"xing_weight": 1.0}),
    "max_segments": (Options(iterations=2, revisions=0, max_segments=4), {"max_segments": 12}),
    "placement": (QUICK, {"placement": "random"}),
    "placement by regions": (QUICK, {"placement": "region"}),
    "shape": (QUICK, {"shape": "random"}),
    "shape by fit": (QUICK, {"shape": "outline"}),
    "holes": (Options(iterations=2, revisions=0), {"holes": False}),
    "merge": (Options(iterations=2, revisions=0, full_rate_side=0.0), {"merge": False}),
    "settle": (QUICK, {"settle": 0.1}),
    "revisions": (Options(iterations=10, revisions=0), {"revisions": 3}),
    "prune": (Options(iterations=2, revisions=0), {"prune": 0.1}),
    "target_mse": (QUICK, {"target_mse": 0.9}),
    "path_gain": (QUICK, {"path_gain": 0.9}),
    "untangle": (Options.diffvg(iterations=40, learning_rate=2.0), {"untangle": True}),
    "background": (QUICK, {"background": "#8080ff"}),
    "radius": (QUICK, {"radius": 3.0}),
    "tau": (QUICK, {"tau": 4.0}),
    "color_threshold": (QUICK, {"color_threshold": 1.5}),
    "bins": (QUICK, {"bins": 1}),
    "learning_rate": (QUICK, {"learning_rate": 0.5}),
    "color_learning_rate": (QUICK, {"color_learning_rate": 0.05}),
    "full_rate_side": (QUICK, {"full_rate_side": 48.0}),
    "decay": (Options.paper(iterations=30), {"decay": 0.01}),
    "new_color": (QUICK, {"new_color": "random"}),
    "opacity": (Options.paper(iterations=30), {"opacity": "opaque"}),
    "variant": (QUICK, {"variant": "released"}),
}


def _ring() -> NDArray[np.float64]:
    rows, columns = np.indices((24, 24)) + 0.5
    distance = np.hypot(rows - 12, columns - 12)
    return np.where(((distance > 5) & (distance < 9))[..., None], (0.8, 0.2, 0.1), (1.0, 1.0, 1.0))


@pytest.mark.parametrize("name", CHANGES)
def test_every_option_changes_the_result(name: str, device: int) -> None:
    base, changes = CHANGES[name]
    image = _ring() if name in ("holes", "merge") else SMALL
    results = [vectorize(image, 3, [1, 2], dataclasses.replace(base, **c), device).svg for c in ({}, changes)]
    assert results[0] != results[1]


def test_no_option_is_left_out_above() -> None:
    changed = {field for _, changes in CHANGES.values() for field in changes}
    assert changed == {field.name for field in dataclasses.fields(Options)}


def test_the_program_s_weight_goes_with_paths_on_top_only() -> None:
    for changes in ({"placement": "region"}, {"revisions": 1}):
        with pytest.raises(ValueError, match=r"^variant: "):
            Options.released(**changes)
