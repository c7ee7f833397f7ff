# SPDX-License-Identifier: Apache-2.0
"""Importing this makes the tests' folder importable: its slow references, and its makers of pictures and drawings."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parent.parent / "tests"))
