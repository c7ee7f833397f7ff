# SPDX-License-Identifier: Apache-2.0
"""Neighbours in closed sequences are those of `np.roll`."""

from __future__ import annotations

import numpy as np
import pytest

from livecl.geometry import cyclic


@pytest.mark.parametrize("shape", [(0,), (1,), (5,), (0, 2), (1, 2), (4, 3, 2)])
@pytest.mark.parametrize("kind", [float, complex, bool])
def test_as_roll(shape: tuple[int, ...], kind: type) -> None:
    elements = np.arange(np.prod(shape)).reshape(shape).astype(kind)
    for found, shift in ((cyclic.following(elements), -1), (cyclic.preceding(elements), 1)):
        np.testing.assert_array_equal(found, np.roll(elements, shift, axis=0))
        assert found.dtype == elements.dtype
