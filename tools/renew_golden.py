#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compare the golden numbers (tests/support/golden.json) with those of this checkout; with --write, replace them.

Use --write only for a change that is meant to change the results of runs, after checking the differences printed.
"""

from __future__ import annotations

import argparse
import json
import sys
from typing import Any

import with_tests  # noqa: F401  # before what imports from there
from support import golden_set


def main(argv: list[str] | None = None) -> int:
    """Compare or write; return 0 if all is as it was or is written, else 1."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", action="store_true", help="write the numbers of this checkout")
    parser.add_argument("--device", metavar="DEVICE", help="OpenCL device, by index or part of its name")
    arguments = parser.parse_args(argv)
    wanted = golden_set.stored() if golden_set.FILE.is_file() else {}
    found: dict[str, dict[str, Any]] = {}
    same = True
    for kind, numbers_of in golden_set.KINDS.items():
        noisy = {"noisy": True} if kind == "outcomes" and arguments.write else {}
        found[kind] = numbers_of(arguments.device, **noisy)
        before = wanted.get(kind, {})
        if sorted(before) != sorted(found[kind]):
            print(f"{kind}: other names than before")
            same = False
            continue
        missed = golden_set.misses(kind, found[kind], before)
        print(
            f"{kind}: largest relative change {golden_set.largest_change(found[kind], before):.1e}", *missed, sep="\n  "
        )
        same = same and not missed
    if arguments.write:
        golden_set.FILE.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
        golden_set.GOT.unlink(missing_ok=True)
        return 0
    return 0 if same else 1


if __name__ == "__main__":
    sys.exit(main())
