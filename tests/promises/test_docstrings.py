# SPDX-License-Identifier: Apache-2.0
"""Examples in docstrings do what they say."""

from __future__ import annotations

import doctest
import importlib
import pathlib

import pytest

import livecl

FOLDER = pathlib.Path(livecl.__file__).parent
#: Modules with an example in a docstring, found without an import of all.
MODULES = sorted(
    ".".join(path.relative_to(FOLDER.parent).with_suffix("").parts)
    for path in FOLDER.rglob("*.py")
    if ">>> " in path.read_text(encoding="utf-8")
)


@pytest.mark.parametrize("module", MODULES)
def test_examples(module: str) -> None:
    failed, tried = doctest.testmod(importlib.import_module(module))

    assert tried > 0
    assert not failed
