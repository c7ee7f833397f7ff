# SPDX-License-Identifier: Apache-2.0
"""Dependencies: lower bounds that can be tested, licences that are written down."""

from __future__ import annotations

import importlib.metadata
import re
from pathlib import Path

import check_lower_bounds
import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "dependencies.md").read_text(encoding="utf-8")


def core_names() -> set[str]:
    return {canonicalize_name(Requirement(line).name) for line in check_lower_bounds.core_requirements()}


def test_each_core_dependency_has_a_lower_bound() -> None:
    constraints = check_lower_bounds.lower_bounds(check_lower_bounds.core_requirements())
    assert {canonicalize_name(Requirement(line).name) for line in constraints} == core_names()
    for line in constraints:
        assert [specifier.operator for specifier in Requirement(line).specifier] == ["=="], line


def test_lower_bounds_are_read_with_extras_and_markers() -> None:
    marker = 'sys_platform == "linux"'
    assert check_lower_bounds.lower_bounds([f"a[b,c] >=1.2, <3; {marker}", "d>=4"]) == [f"a==1.2; {marker}", "d==4"]
    for line in ("a", "a <3", "a ==1"):
        with pytest.raises(ValueError, match="has no lower bound, wanted name >=version"):
            check_lower_bounds.lower_bounds([line])


def test_the_licence_of_each_core_dependency_is_written_down() -> None:
    columns = [line.split("|")[2] for line in PAGE.splitlines() if line.startswith("|")]
    listed = {canonicalize_name(name) for column in columns for name in re.findall(r"[\w.-]+", column)}
    # tomli is the core's on Python 3.10 only, so the table may have it among the tests' dependencies.
    assert core_names() - {"tomli"} <= listed
    assert "tomli" in PAGE


def test_no_core_dependency_is_under_the_gpl() -> None:
    for name in core_names() | {"pocl-binary-distribution"}:
        try:
            metadata = importlib.metadata.metadata(name)
        except importlib.metadata.PackageNotFoundError:
            continue  # not wanted on this platform or Python
        stated = [metadata.get("License-Expression"), metadata.get("License"), *(metadata.get_all("Classifier") or ())]
        assert not re.search(r"(?<!L)GPL|General Public", "\n".join(filter(None, stated)).split("\n\n")[0]), name
