# SPDX-License-Identifier: Apache-2.0
from .adam import Adam as Adam

__all__ = [
    "Adam",
]
