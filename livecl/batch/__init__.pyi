# SPDX-License-Identifier: Apache-2.0
from .batch import vectorize_files as vectorize_files

__all__ = [
    "vectorize_files",
]
