# SPDX-License-Identifier: Apache-2.0
"""`Drawing`: its layers, their labels and colours, and checks of its arguments."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
