# SPDX-License-Identifier: Apache-2.0
from .callbacks import Step as Step
from .control import Control as Control
from .recipe import Recipe as Recipe
from .recipe import vectorize as vectorize
from .result import Result as Result
from .result import RunError as RunError
from .sequences import SequenceResult as SequenceResult
from .sequences import vectorize_sequence as vectorize_sequence

__all__ = [
    "Control",
    "Recipe",
    "Result",
    "RunError",
    "SequenceResult",
    "Step",
    "vectorize",
    "vectorize_sequence",
]
