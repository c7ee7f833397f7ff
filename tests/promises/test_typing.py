# SPDX-License-Identifier: Apache-2.0
"""What type checkers see of the package: its names, and that there are no others."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

SCRIPT = """
import livecl
from livecl import Options, Step

livecl.vectorise("picture.png")
livecl.vectorize("picture.png", path=3)
drawing: livecl.Drawing = livecl.read_svg("drawing.svg")
"""


@pytest.mark.slow
def test_misspelled_names_are_found(tmp_path: Path) -> None:
    api = pytest.importorskip("mypy.api")
    script = tmp_path / "script.py"
    script.write_text(SCRIPT)
    root = Path(__file__).resolve().parents[2]
    cache = root / ".mypy_cache"  # as `tools/check` fills it
    if not os.access(root, os.W_OK):
        cache = tmp_path / "cache"
    stdout, stderr, code = api.run(
        ["--config-file", str(root / "pyproject.toml"), "--cache-dir", str(cache), str(script)]
    )
    errors = [line for line in stdout.splitlines() if "error:" in line]
    assert code == 1 and not stderr
    assert len(errors) == 2, stdout
    assert 'script.py:5: error: Module has no attribute "vectorise"' in errors[0].replace(str(tmp_path) + "/", "")
    assert "script.py:6: error" in errors[1] and '"path"' in errors[1]
