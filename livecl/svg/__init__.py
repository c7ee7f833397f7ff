# SPDX-License-Identifier: Apache-2.0
"""Read and write SVG as `Drawing`.

A saved file holds the drawing of :func:`quantize`, to the last digit: :func:`read_svg` gives it back equal.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
