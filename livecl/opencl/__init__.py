# SPDX-License-Identifier: Apache-2.0
"""OpenCL devices, caches, programs and launches: the only package that imports pyopencl."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
