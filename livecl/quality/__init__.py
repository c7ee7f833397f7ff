# SPDX-License-Identifier: Apache-2.0
"""Measures of drawings: how close to the picture, how clean the layers."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
