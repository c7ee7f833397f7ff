# SPDX-License-Identifier: Apache-2.0
"""Which layers do least for the picture: those that a revision takes out and places anew, and those worth nothing."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from livecl.drawing import Drawing
from livecl.metrics import layer_alphas, removal_changes
from livecl.rasterizer import Rasterizer


def least_useful(drawing: Drawing, rasterizer: Rasterizer, target: NDArray[Any]) -> NDArray[np.intp]:
    """Return the layers in the order of what the picture loses without them, the least first: (N,)."""
    changes = removal_changes(drawing, layer_alphas(drawing, rasterizer), target)
    return np.argsort(changes, kind="stable")
