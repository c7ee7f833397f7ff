# SPDX-License-Identifier: Apache-2.0
"""livecl: turns a picture into a layered, human-editable SVG of few closed Bézier paths.

An implementation of LIVE ("Towards Layer-wise Image Vectorization", CVPR 2022) on OpenCL. Names are loaded when first
used, so that ``import livecl`` is quick and SVG work needs no OpenCL device.
"""

import lazy_loader

from livecl.version import __version__ as __version__

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
