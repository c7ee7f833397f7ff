# SPDX-License-Identifier: Apache-2.0
"""A run from picture to result: stages, checkpoints, interruption, sequences."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
