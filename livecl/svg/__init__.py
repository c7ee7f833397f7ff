# SPDX-License-Identifier: Apache-2.0
"""Read and write SVG as `Drawing`.

A saved file holds exactly the drawing returned by :func:`quantize`, and :func:`read_svg` returns an equal one.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
