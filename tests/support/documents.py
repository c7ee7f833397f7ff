# SPDX-License-Identifier: Apache-2.0
"""The pages for readers, their code blocks, and a folder in which the commands run as in a clone."""

from __future__ import annotations

import dataclasses
import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from PIL import Image

ROOT = Path(__file__).resolve().parents[2]
DOCUMENTS = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]
#: Languages of the blocks that are run.
RUN = ("sh", "python")
#: What a clone has that the commands use.
PARTS = ("examples", "livecl", "kernels", "tools", "docs")
#: Commands that the package installs, and the modules whose `main` they call.
COMMANDS = {
    "livecl": "livecl.cli.command",
    "livecl-interpolate": "livecl.cli.interpolate",
    "livecl-sequence": "livecl.cli.sequence",
}
#: The comment above a block that says why it is not run.
NOT_RUN = re.compile(r"^\s*<!-- not run: (.+) -->\s*$")
#: Factor by which a clone's pictures are reduced.
REDUCED = 3
#: Longest time of a block, s.
TIMEOUT = 300


@dataclasses.dataclass(frozen=True)
class Block:
    """A fenced block: where its first line is, its language, its text, and why it is not run, if it is not."""

    document: Path
    line: int
    language: str
    code: str
    reason: str | None

    def __str__(self) -> str:
        return f"{self.document.relative_to(ROOT)}:{self.line}"


def blocks(document: Path) -> list[Block]:
    """Return the fenced blocks of a page."""
    found: list[Block] = []
    lines = document.read_text(encoding="utf-8").splitlines()
    start: tuple[int, str, str] | None = None
    for number, line in enumerate(lines, start=1):
        if not (fence := re.match(r"^( *)```(\S*)", line)):
            continue
        if start is None:
            start = number, fence[1], fence[2]
            continue
        first, indent, language = start
        code = "".join(f"{text.removeprefix(indent)}\n" for text in lines[first : number - 1])
        reason = NOT_RUN.match(lines[first - 2]) if first > 1 else None
        found.append(Block(document, first + 1, language, code, reason[1] if reason else None))
        start = None
    assert start is None, f"{document}: the block of line {start} is not closed"
    return found


def prose(document: Path) -> str:
    """Return a page's text without its fenced blocks."""
    return re.sub(r"^ *```.*?^ *```$", "", document.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)


def commands(code: str) -> Iterator[list[str]]:
    """Yield the commands of a shell block, in words, without redirections and comments."""
    for line in code.replace("\\\n", " ").splitlines():
        words: list[str] = []
        for word in [*shlex.split(line, comments=True), ";"]:
            if word in (";", "&&", "||", "|", "&"):
                if words:
                    yield words
                words = []
            else:
                words.append(word)


def start(command: str) -> str:
    """Return the words after `python` that start an installed command."""
    return f"-c {shlex.quote(f'import sys; from {COMMANDS[command]} import main; sys.exit(main())')}"


class Clone:
    """A folder with what a clone has, and its commands and `python` as in an environment that is activated.

    Its example pictures are smaller: whether commands work does not depend on that.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder / "clone"
        for part in PARTS:
            shutil.copytree(ROOT / part, self.folder / part, ignore=shutil.ignore_patterns("__pycache__"))
        for picture in (self.folder / "examples").glob("*.png"):
            with Image.open(picture) as image:
                image.reduce(REDUCED).save(picture)
        bin_folder = folder / "bin"
        bin_folder.mkdir()
        for name, words in (("python", ""), ("python3", ""), *((name, start(name)) for name in COMMANDS)):
            script = bin_folder / name
            script.write_text(f'#!/bin/sh\nexec {shlex.quote(sys.executable)} {words} "$@"\n')
            script.chmod(0o755)
        inherited = {name: value for name, value in os.environ.items() if name not in ("LIVECL_DEVICE", "PYTHONHOME")}
        self._environment = {
            **inherited,
            "PATH": f"{bin_folder}{os.pathsep}{os.environ['PATH']}",
            "PYTHONPATH": str(self.folder),
            "MPLBACKEND": "Agg",
        }
        self._namespace: dict[str, Any] = {"__name__": "__main__"}

    def run(self, block: Block) -> None:
        """Run a block; what Python blocks define stays. Any failure is raised, with the place in the page."""
        if block.language == "python":
            source = "\n" * (block.line - 1) + block.code
            exec(compile(source, str(block.document), "exec"), self._namespace)
            return
        done = self.shell(block.code)
        assert done.returncode == 0, f"{block}: exit code {done.returncode}\n{done.stdout}\n{done.stderr}"

    def shell(self, code: str, **variables: str) -> subprocess.CompletedProcess[str]:
        """Run a shell script in the folder."""
        return subprocess.run(
            ["bash", "-euo", "pipefail", "-c", code],
            cwd=self.folder,
            env={**self._environment, **variables},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=TIMEOUT,
            check=False,
        )
