#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Print the licences of all that livecl needs, with all that this needs in turn, as the table of docs/dependencies.md.

What is installed in the environment is listed, as its metadata says it; `pip install -e '.[dev,vtracer]'` brings all.
"""

from __future__ import annotations

import argparse
import importlib.metadata
import re
import sys

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

#: Packages whose metadata say nothing: what their licence files say.
BY_HAND = {
    "pocl-binary-distribution": "MIT (PoCL), Apache-2.0 WITH LLVM-exception (LLVM), BSD (hwloc)",
    "resvg-py": "MIT",
}
#: Names in use for one licence, as patterns, and its name here.
NAMES = (
    (r"apache", "Apache-2.0"),
    (r"mozilla|mpl", "MPL-2.0"),
    (r"lgpl", "LGPL-3.0-or-later"),
    (r"python software foundation|psf|license agreement for matplotlib", "PSF-2.0"),
    (r"isc", "ISC"),
    (r"bsd.?2", "BSD-2-Clause"),
    (r"bsd.?3", "BSD-3-Clause"),
    (r"bsd", "BSD"),
    (r"mit", "MIT"),
)
#: Columns: the extras that are counted in each.
GROUPS = {"core": ("",), "cluster": ("cluster",), "plots": ("plots",), "video": ("video",), "vtracer": ("vtracer",)}
DEVELOPMENT = ("test", "dev")


def licence_of(name: str) -> str:
    """Return the licence of an installed package: its SPDX expression, else what its other metadata come to."""
    name = canonicalize_name(name)
    if name in BY_HAND:
        return BY_HAND[name]
    metadata = importlib.metadata.metadata(name)
    expression = metadata.get("License-Expression")
    if expression:
        return str(expression)
    text = str(metadata.get("License") or "").strip()
    if re.fullmatch(r"[\w.-]+( (AND|OR|WITH) [\w.-]+)+", text):
        return text
    classifiers = [str(line) for line in metadata.get_all("Classifier") or [] if str(line).startswith("License")]
    for source in (text.split("\n")[0], *classifiers):
        for pattern, licence in NAMES:
            if re.search(pattern, source, re.IGNORECASE):
                return licence
    return "not stated"


def needed(extra: str, root: str = "livecl") -> set[str]:
    """Return the installed packages that an extra of livecl (or "" for the core) needs, and what these need in turn."""
    found: set[str] = set()
    pending = [(root, extra)]
    seen = set(pending)
    while pending:
        name, wanted = pending.pop()
        for line in importlib.metadata.requires(name) or ():
            requirement = Requirement(line)
            if requirement.marker is not None:
                if not requirement.marker.evaluate({"extra": wanted}):
                    continue
                if wanted and name == root and requirement.marker.evaluate({"extra": ""}):
                    continue  # the core's own
            elif wanted and name == root:
                continue
            package = canonicalize_name(requirement.name)
            try:
                importlib.metadata.distribution(package)
            except importlib.metadata.PackageNotFoundError:
                print(f"list_licences.py: {package} is not installed", file=sys.stderr)
                continue
            if package != root:
                found.add(package)
            for further in ("", *requirement.extras) if package != root else requirement.extras:
                if (package, further) not in seen:
                    seen.add((package, further))
                    pending.append((package, further))
    return found


def table() -> str:
    """Return the table: a row for each licence, in each column the packages that the columns before do not have."""
    listed: set[str] = set()
    columns: dict[str, dict[str, list[str]]] = {}
    for title, extras in {**GROUPS, "tests, development": DEVELOPMENT}.items():
        packages = set().union(*(needed(extra) for extra in extras)) - listed
        listed |= packages
        columns[title] = {}
        for package in sorted(packages):
            columns[title].setdefault(licence_of(package), []).append(package)
    licences = sorted({licence for column in columns.values() for licence in column}, key=str.lower)
    rows = [f"| licence | {' | '.join(columns)} |", "|---" * (len(columns) + 1) + "|"]
    for licence in licences:
        rows.append(f"| {licence} | {' | '.join(', '.join(column.get(licence, ())) for column in columns.values())} |")
    return "\n".join(rows)


def main(argv: list[str] | None = None) -> int:
    """Print the table."""
    argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter).parse_args(argv)
    print(table())
    return 0


if __name__ == "__main__":
    sys.exit(main())
