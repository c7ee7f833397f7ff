# SPDX-License-Identifier: Apache-2.0
from .adam import Adam as Adam
from .state import State as State

__all__ = [
    "Adam",
    "State",
]
