# SPDX-License-Identifier: Apache-2.0
"""Findings: errors of one kind of number of one drawing."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from livecl.arrays import FloatArray

#: Relative tolerance of a derivative by differences, over the norm of the gradient: see reference/differences.py.
RELATIVE = 1e-6
LOSSES = ("linear", "quadratic")
#: Entries of each kind that are moved in each drawing.
ENTRIES = 8


def least(d_image: FloatArray) -> float:
    """Return a norm that is small for the loss: differences have rounding errors even if no layer is visible."""
    return 1e-3 * float(np.linalg.norm(d_image))


@dataclasses.dataclass(frozen=True, kw_only=True)
class Finding:
    """One kind of number of one drawing, such as the control points' gradient of one loss.

    Attributes
    ----------
    index : int
        The drawing.
    what : str
        The kind of number.
    relative : float
        Norm of the error over the norm of the exact value; 0 if both are 0.
    of_rounding : float
        Largest error over the bound of rounding (or of the method of differences): above 1, it has another cause.
    of_allowed : float
        The same with the uncertainty at kinks of min(|A|, 1) added to the bound: above 1, it is wrong.
    """

    index: int
    what: str
    relative: float
    of_rounding: float
    of_allowed: float

    @classmethod
    def of(
        cls,
        index: int,
        what: str,
        found: FloatArray,
        exact: FloatArray,
        rounding: FloatArray | float,
        kinks: FloatArray | float = 0.0,
        norm: float | None = None,
    ) -> Finding:
        """Return the finding of numbers that should be `exact`, with the tolerances of each or of all.

        `norm` is that of all numbers, where these are only some of them.
        """
        errors, norm = np.abs(found - exact), float(np.linalg.norm(exact)) if norm is None else norm
        error = float(np.linalg.norm(errors))
        with np.errstate(divide="ignore", invalid="ignore"):  # no error where none is allowed is none
            of_rounding = np.nan_to_num(errors / rounding, nan=0.0, posinf=np.inf)
            of_allowed = np.nan_to_num(errors / (rounding + kinks), nan=0.0, posinf=np.inf)
        finite = bool(np.isfinite(found).all())
        return cls(
            index=index,
            what=what,
            relative=0.0 if error == 0 else error / norm if norm else np.inf,
            of_rounding=float(np.max(of_rounding, initial=0.0)) if finite else np.inf,
            of_allowed=float(np.max(of_allowed, initial=0.0)) if finite else np.inf,
        )


def table(findings: Sequence[Finding]) -> str:
    """Return the distribution of the errors of each kind of number, as a Markdown table."""
    rows = [
        "| | median | 99.9 % | worst | beyond rounding, at kinks | wrong |",
        "|---|--:|--:|--:|--:|--:|",
    ]
    for what in dict.fromkeys(finding.what for finding in findings):
        own = [finding for finding in findings if finding.what == what]
        relative = np.array([finding.relative for finding in own])
        middle, high = np.quantile(relative, [0.5, 0.999], method="higher")
        wrong = sum(not finding.of_allowed <= 1 for finding in own)
        kinks = sum(finding.of_rounding > 1 for finding in own) - wrong
        rows.append(f"| {what} | {middle:.1e} | {high:.1e} | {relative.max():.1e} | {kinks} | {wrong} |")
    return "\n".join(rows)
