#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Vectorize a picture from a checkout; the same as the installed command ``livecl``."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from livecl.cli.command import main

if __name__ == "__main__":
    sys.exit(main())
