# SPDX-License-Identifier: Apache-2.0
"""Vectorize many pictures, on this machine or on a Dask cluster."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
