# SPDX-License-Identifier: Apache-2.0
"""Editable outlines: few nodes, smooth joins, straight sides, circles, ellipses, rectangles, few colours, cut-outs."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
