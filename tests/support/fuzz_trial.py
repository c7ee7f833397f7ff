# SPDX-License-Identifier: Apache-2.0
"""A kind of input for the fuzzer's own test, of which some cases go wrong in each of the ways that are looked for."""

from __future__ import annotations

import os
import random
import time

import numpy as np
from fuzzing.kind import Kind

WAYS = ("well", "refused", "error", "abort", "loop", "memory", "sleep")


def make(rng: random.Random) -> str:
    return rng.choice(WAYS)


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


KIND = Kind(make=make, check=check, dump=str.encode, suffix=".txt", seconds=0.25, megabytes=500)
