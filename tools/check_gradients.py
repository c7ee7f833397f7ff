#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Check the gradients of random drawings: float kernels against the double build, and that against differences.

Prints the distribution of relative errors. Errors larger than rounding allows must be due to pixels at a kink of the
coverage, min(|A|, 1) with |A| near 0 or 1, where both precisions may be right; otherwise the drawing is reported as
wrong. Gradient fills also have kinks at their stops.
"""

from __future__ import annotations

import argparse
import sys
import time

import with_tests  # noqa: F401  # before what imports the references
from gradient_checks.comparisons import Comparer
from gradient_checks.findings import Finding, table
from gradient_checks.scenes import random_scene

EPILOG = """\
exit codes: 0 all within tolerance, 1 some are not, 2 bad arguments
"""


def describe(finding: Finding, seed: int, fills: bool) -> str:
    """Return a line on a finding and its drawing."""
    scene = random_scene(seed, finding.index, fills)
    drawing = scene.case.drawing
    return (
        f"drawing {finding.index}: {finding.what}: relative {finding.relative:.2e}, {finding.of_rounding:.2g} times "
        f"rounding, {finding.of_allowed:.2g} times the tolerance; {drawing.size[0]}x{drawing.size[1]} px, "
        f"{', '.join(scene.kinds[:8])}{' ...' if len(scene.kinds) > 8 else ''}"
    )


def main(argv: list[str] | None = None) -> int:
    """Check and report; return the exit code."""
    parser = argparse.ArgumentParser(
        description=__doc__, epilog=EPILOG, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--drawings", type=int, default=300, metavar="N", help="float against double (%(default)s)")
    parser.add_argument(
        "--differences", type=int, metavar="N", help="the first N also against differences (a twentieth of them)"
    )
    parser.add_argument("--seed", type=int, default=0, metavar="S", help="of the drawings (%(default)s)")
    parser.add_argument("--first", type=int, default=0, metavar="I", help="begin with drawing I (%(default)s)")
    parser.add_argument("--fills", action="store_true", help="the same drawings with solid, linear and radial fills")
    parser.add_argument("--worst", type=int, default=5, metavar="N", help="describe the N worst (%(default)s)")
    parser.add_argument("--device", metavar="DEVICE", help="OpenCL device, by index or part of its name")
    arguments = parser.parse_args(argv)
    if arguments.drawings < 1 or arguments.seed < 0 or arguments.first < 0:
        parser.error("--drawings: wanted at least 1; --seed and --first: at least 0")
    differences = arguments.drawings // 20 if arguments.differences is None else arguments.differences
    comparer = Comparer(arguments.seed, arguments.device, arguments.fills)
    findings: list[Finding] = []
    start = time.perf_counter()
    for index in range(arguments.first, arguments.first + arguments.drawings):
        findings += comparer.single_with_double(index)
        if index < arguments.first + differences:
            findings += comparer.double_with_differences(index)
    seconds = time.perf_counter() - start
    print(f"{arguments.drawings} drawings of seed {arguments.seed}, {differences} by differences; {seconds:.0f} s\n")
    print(table(findings))
    beyond = sorted(findings, key=lambda finding: finding.of_allowed, reverse=True)
    largest = sorted(findings, key=lambda finding: finding.relative, reverse=True)
    for title, some in (("nearest to the tolerance, or beyond it", beyond), ("largest relative errors", largest)):
        print(f"\n{title}:")
        for finding in some[: arguments.worst]:
            print(describe(finding, arguments.seed, arguments.fills))
    return 1 if any(not finding.of_allowed <= 1 for finding in findings) else 0


if __name__ == "__main__":
    sys.exit(main())
