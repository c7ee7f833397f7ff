# SPDX-License-Identifier: Apache-2.0
"""livecl: turns a picture into a layered, human-editable SVG of few closed Bézier paths.

An implementation of LIVE ("Towards Layer-wise Image Vectorization", CVPR 2022) on OpenCL. Names are loaded on first
use, so that ``import livecl`` is fast and working with SVG needs no OpenCL device.
"""

import lazy_loader

from livecl.version import __version__ as __version__

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
