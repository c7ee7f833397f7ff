# SPDX-License-Identifier: Apache-2.0
"""A kind of input for the fuzzer's own test, of which some cases go wrong in each of the ways that are looked for."""

from __future__ import annotations

import os
import time

import numpy as np
from fuzzing.kind import Kind
from hypothesis import strategies as st

WAYS = ("well", "refused", "error", "abort", "loop", "memory", "sleep")


def check(case: str) -> str:
    if case == "error":
        raise ZeroDivisionError("planted")
    if case == "abort":
        os.abort()
    while case == "loop":
        pass
    if case == "memory":
        np.ones(10**9)
    if case == "sleep":
        time.sleep(1000)  # takes no processor time, as what waits for a lock
    return case


KIND = Kind(cases=st.sampled_from(WAYS), others=st.sampled_from(WAYS), check=check, seconds=0.25, megabytes=500)
