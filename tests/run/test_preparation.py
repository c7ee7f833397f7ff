# SPDX-License-Identifier: Apache-2.0
"""Preparation of the device beside other work."""

from __future__ import annotations

import subprocess
import sys
import threading

import pytest
from support.runs import SMALL

import livecl
from livecl import DeviceError, Options
from livecl.run import preparation
from livecl.run.preparation import Preparation

IMAGE = SMALL.astype("float32")


def test_a_run_is_got_ready_without_scipy() -> None:
    """It takes as long as everything else together; placement by structure or region loads it when it begins."""
    script = "import sys, livecl.run.vectorization; print('scipy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", script], capture_output=True, text=True).stdout == "False\n"


def test_kernels_are_compiled_in_a_thread_and_once(device: int, monkeypatch: pytest.MonkeyPatch) -> None:
    threads: list[threading.Thread] = []
    monkeypatch.setattr(preparation, "_prepared", set())
    monkeypatch.setattr(preparation, "warm_up", lambda *arguments: threads.append(threading.current_thread()))
    for background in ((1, 1, 1), (1, 1, 1), None):
        Preparation(IMAGE, Options(), background, device).wait()
    assert len(threads) == 2 and threading.current_thread() not in threads


def test_what_fails_is_told_when_the_run_asks_for_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(preparation, "_prepared", set())
    Preparation(IMAGE, Options(), (1, 1, 1), "no such device").wait()
    with pytest.raises(DeviceError, match="no such device"):
        livecl.vectorize(IMAGE, 1, device="no such device")
