# SPDX-License-Identifier: Apache-2.0
"""Things of layers: parts drawn alone, and how they are matched."""

from __future__ import annotations

import numpy as np
import pytest

from livecl.quality.things import match_things, things_of

RED, BLUE = (0.9, 0.1, 0.1), (0.1, 0.1, 0.9)


def test_parts_of_a_layer_are_things_and_hidden_parts_count() -> None:
    layers = np.zeros((2, 20, 30))
    layers[0, 2:12, 2:12] = layers[0, 2:12, 20:28] = 1
    layers[1, 2:12, 7:15] = 1
    things = things_of(layers, np.array([RED, BLUE]))
    assert len(things) == 3 and sorted(things.layers.tolist()) == [0, 0, 1]
    assert sorted(things.masks.sum(axis=(1, 2)).tolist()) == [80, 80, 100]
    assert things.hidden.max() == pytest.approx(0.5) and np.count_nonzero(things.hidden) == 1


def test_things_of_another_color_or_place_do_not_match() -> None:
    layers = np.zeros((2, 20, 30))
    layers[0, 2:12, 2:12] = layers[1, 2:12, 16:26] = 1
    true = things_of(layers, np.array([RED, BLUE]))
    scores, partners = match_things(true, things_of(layers[:, :, ::1], np.array([RED, RED])))
    assert scores.tolist() == [1.0, 0.0] and partners.tolist() == [0, -1]
