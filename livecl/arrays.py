# SPDX-License-Identifier: Apache-2.0
"""Types of arrays by their numbers; shapes and units stand beside each argument."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Float32Array = NDArray[np.float32]
ComplexArray = NDArray[np.complexfloating[Any, Any]]
IntArray = NDArray[np.int64]
Int32Array = NDArray[np.int32]
BoolArray = NDArray[np.bool_]
#: Rows and columns of a picture.
Window = tuple[slice, slice]
