# SPDX-License-Identifier: Apache-2.0
"""Make the tests' folder importable, for its slow references, pictures and drawings."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parent.parent / "tests"))
