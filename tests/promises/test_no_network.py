# SPDX-License-Identifier: Apache-2.0
"""No network is asked for at run time: runs, reports and the command line work where there is none."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from support.batches import make_pictures

#: Ends whatever asks for a socket or looks up a name: Python tells of each such call before it is made.
SITECUSTOMIZE = """
import os, sys

def refuse(event, arguments):
    if event.startswith("socket.") or event in ("urllib.Request", "http.client.connect"):
        os.write(2, f"network: {event} {arguments}\\n".encode())
        os._exit(77)

sys.addaudithook(refuse)
"""
WORK = """
import livecl

options = livecl.Options(iterations=3, revisions=0)
result = livecl.vectorize("in/picture-0.png", 2, options=options)
result.save_svg("library.svg")
livecl.read_svg("library.svg")
"""
COMMANDS = (
    ["-c", WORK],
    ["-m", "livecl", "in/picture-0.png", "-o", "command.svg", "--report", "report.html", "--preset", "draft"],
    ["-m", "livecl", "--list-devices"],
)


def _run(prefix: list[str], command: list[str], folder: Path, **changes: str) -> None:
    done = subprocess.run(
        [*prefix, sys.executable, *command],
        cwd=folder,
        env={**os.environ, **changes},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.slow
def test_no_socket_is_asked_for(tmp_path: Path) -> None:
    make_pictures(tmp_path / "in", 1)
    hook = tmp_path / "hook"
    hook.mkdir()
    (hook / "sitecustomize.py").write_text(SITECUSTOMIZE, encoding="utf-8")
    path = os.pathsep.join(filter(None, [str(hook), os.environ.get("PYTHONPATH")]))
    asking = [sys.executable, "-c", "import socket; socket.socket()"]
    asked = subprocess.run(asking, env={**os.environ, "PYTHONPATH": path}, capture_output=True, check=False)
    assert asked.returncode == 77, "the hook is not in effect, so the test would show nothing"
    for command in COMMANDS:
        _run([], command, tmp_path, PYTHONPATH=path)
    assert all((tmp_path / name).is_file() for name in ("library.svg", "command.svg", "report.html"))


@pytest.mark.full
def test_runs_where_there_is_no_network(tmp_path: Path) -> None:
    # Also programs other than Python: the OpenCL runtime and its compiler.
    alone = ["unshare", "--map-root-user", "--net"]
    if shutil.which("unshare") is None or subprocess.run([*alone, "true"], check=False, capture_output=True).returncode:
        pytest.skip("no network namespaces here")
    make_pictures(tmp_path / "in", 2)
    cache = {"XDG_CACHE_HOME": str(tmp_path / "cache")}  # kernels are built anew
    for command in (*COMMANDS, ["-m", "livecl", "in", "-o", "svgs", "--preset", "draft"]):
        _run(alone, command, tmp_path, **cache)
    assert len(list((tmp_path / "svgs").glob("*.svg"))) == 2
