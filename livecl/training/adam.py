# SPDX-License-Identifier: Apache-2.0
"""Adam (Kingma and Ba 2015) for parameters of different ages, and the decay of its learning rate."""

from __future__ import annotations

import dataclasses
import functools
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from livecl.arrays import FloatArray

BETA1, BETA2, EPSILON = 0.9, 0.999, 1e-8
#: Steps after which the bias corrections are exactly 1 in float64: BETA2^t is less than half of 2^-52.
UNBIASED_AGE = 37000


@functools.cache
def _corrections() -> tuple[FloatArray, FloatArray]:
    """Return sqrt(1 - BETA2^t) / (1 - BETA1^t) and sqrt(1 - BETA2^t) for t up to `UNBIASED_AGE`; 0 and 1 for t = 0."""
    ages = np.arange(1, UNBIASED_AGE + 1)
    root = np.sqrt(1 - BETA2**ages)
    return np.append(0.0, root / (1 - BETA1**ages)), np.append(1.0, root)


@dataclasses.dataclass
class Adam:
    """First and second moments of an array of parameters, whose rows may have been added at different times.

    Attributes
    ----------
    mean, square : (K, ...) float64
        Moving averages of the gradient and of its square.
    ages : (K,) int64
        Steps that each row has taken.
    """

    mean: FloatArray
    square: FloatArray
    ages: NDArray[np.int64]

    @classmethod
    def start(cls, shape: tuple[int, ...]) -> Adam:
        """Return the state before the first step."""
        return cls(np.zeros(shape), np.zeros(shape), np.zeros(shape[0], np.int64))

    def extend(self, count: int) -> None:
        """Append `count` rows of age 0; the others keep their moments."""
        more = Adam.start((count, *self.mean.shape[1:]))
        self.mean = np.concatenate([self.mean, more.mean])
        self.square = np.concatenate([self.square, more.square])
        self.ages = np.concatenate([self.ages, more.ages])

    def subset(self, rows: Any) -> Adam:
        """Return a copy of some of the rows, by index, mask or slice."""
        return Adam(self.mean[rows].copy(), self.square[rows].copy(), self.ages[rows].copy())

    def forget(self, rows: Any) -> None:
        """Reset some of the rows to the state before their first step."""
        self.mean[rows], self.square[rows], self.ages[rows] = 0, 0, 0

    def step(self, gradient: FloatArray, learning_rate: ArrayLike) -> FloatArray:
        """Update the moments by a gradient, and return the change of the parameters.

        Parameters
        ----------
        gradient : (K, ...) float64
            dL/dparameters.
        learning_rate : float or (K,) array_like
            Step length, in units of the parameters.

        Returns
        -------
        (K, ...) float64
            Step to add to the parameters.
        """
        self.ages += 1
        self.mean += (1 - BETA1) * (gradient - self.mean)
        self.square += (1 - BETA2) * (gradient * gradient - self.square)
        correction, root = (table.take(self.ages, mode="clip") for table in _corrections())
        shape = (-1, *[1] * (gradient.ndim - 1))
        scale = np.sqrt(self.square)
        scale += (EPSILON * root).reshape(shape)
        change = self.mean * np.multiply(learning_rate, correction).reshape(shape)
        change /= scale
        return np.negative(change, out=change)


def decayed(ages: NDArray[np.int64], factor: float, period: int) -> FloatArray:
    """Return the factor of the learning rate at each age: `factor` every `period` steps, linear in between."""
    whole, part = np.divmod(ages, period)
    start = np.power(float(factor), whole)
    return np.asarray(start * (1 - part / period * (1 - factor)), dtype=np.float64)


def settling(progress: float, left: float) -> float:
    """Return the factor of the learning rate at a point of a stage: 1 up to the middle, then falling to `left`."""
    return 1 - (1 - left) * max(0.0, 2 * progress - 1)
