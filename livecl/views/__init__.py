# SPDX-License-Identifier: Apache-2.0
"""Views of drawings and runs: report, sheet, films, notebook."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
