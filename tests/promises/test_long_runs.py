# SPDX-License-Identifier: Apache-2.0
"""Long runs leak no memory and do not slow down. Ratios within one run are compared, and no times between runs."""

from __future__ import annotations

import itertools
import json
import os
import statistics
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

SCRIPT = Path(__file__).resolve().parents[1] / "support" / "long_runs.py"
#: Bytes of the smallest block that malloc gives out on 64 bits: what a leak costs at least each time.
MIN_BLOCK = 32
#: Memory that the heap may grow by when nothing leaks, as freed blocks of other sizes lie in between.
SLACK = 1 << 20
#: The runtime sometimes takes one larger piece of memory, once; a leak grows in each tenth of a run.
ONE_PIECE = 8 * SLACK
#: One part of a run may take so much more processor time than another: outlines grow, and machines are shared. Were
#: each iteration to look at all those before, the last tenth would take nineteen times as long as the first.
MAX_SLOWDOWN = 2.0

pytestmark = pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="memory is read from /proc")


def long_run(kind: str, count: int) -> list[dict[str, Any]]:
    """Return what a long run says after each tenth."""
    environment = {**os.environ, "PYTHONPATH": str(SCRIPT.parents[1])}
    command = [sys.executable, str(SCRIPT), kind, str(count)]
    done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    assert done.returncode == 0, done.stderr
    rows = [json.loads(line) for line in done.stdout.splitlines()]
    assert [row["done"] for row in rows] == [tenth * (count // 10) for tenth in range(1, 11)]
    return rows


def growth(rows: list[dict[str, Any]]) -> float:
    """Return by how many bytes memory grew after the first tenth, in which caches fill, were each tenth the median."""
    memory = [row["memory"] for row in rows]
    assert memory[-1] - memory[0] < ONE_PIECE
    return 9 * statistics.median(after - before for before, after in itertools.pairwise(memory))


def slowdown(rows: list[dict[str, Any]]) -> float:
    """Return the time of the later parts over that of the earlier ones, without the first, which builds kernels."""
    seconds = [row["seconds"] for row in rows[1:]]
    return statistics.median(seconds[-3:]) / statistics.median(seconds[:3])


@pytest.mark.full
def test_a_hundred_thousand_iterations() -> None:
    rows = long_run("steps", 100_000)
    assert growth(rows) < 90_000 * MIN_BLOCK, "a block is lost each iteration"
    assert slowdown(rows) < MAX_SLOWDOWN


@pytest.mark.full
def test_three_hundred_runs() -> None:
    rows = long_run("calls", 300)
    assert growth(rows) < SLACK, "270 runs lose 4 kB each"
    assert slowdown(rows) < MAX_SLOWDOWN


@pytest.mark.full
def test_a_thousand_rasterizers() -> None:
    rows = long_run("rasterizers", 1000)
    assert growth(rows) < SLACK, "900 rasterizers lose 1 kB each; the smallest has buffers of 10 kB"
    assert slowdown(rows) < MAX_SLOWDOWN


@pytest.mark.slow
def test_two_thousand_iterations() -> None:
    assert growth(long_run("steps", 2000)) < SLACK, "1 800 iterations lose 600 bytes each"


@pytest.mark.slow
def test_a_hundred_rasterizers() -> None:
    assert growth(long_run("rasterizers", 100)) < SLACK, "90 rasterizers lose 12 kB each, a plane of their pixels"


def test_growth_tells_a_leak_from_one_piece() -> None:
    def rows(*memory: int) -> list[dict[str, Any]]:
        return [{"memory": bytes_used} for bytes_used in memory]

    assert growth(rows(*range(0, 10 * SLACK // 5, SLACK // 5))) > SLACK
    assert growth(rows(*[0] * 4, *[2 * SLACK] * 6)) == 0
    with pytest.raises(AssertionError):
        growth(rows(*[0] * 4, *[9 * SLACK] * 6))
