# SPDX-License-Identifier: Apache-2.0
"""The command line: arguments, files, exit codes, progress."""

import os

import lazy_loader

# Matrices are small here: threads of OpenBLAS, which reads this when NumPy is first imported, wait for each other only.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
