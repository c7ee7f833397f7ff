# SPDX-License-Identifier: Apache-2.0
"""`write_atomically`: content, permissions, links, and leftovers of a failure."""

from __future__ import annotations

import os
import stat
from pathlib import Path

import pytest

from livecl.files import write_atomically


def mode(path: Path) -> int:
    return stat.S_IMODE(path.stat().st_mode)


@pytest.mark.parametrize(
    ("data", "content"),
    [("über\n", "über\n".encode()), ("a\r\nb\n", b"a\r\nb\n"), (b"\x00\xff", b"\x00\xff"), ("", b"")],
)
def test_writes_and_replaces(tmp_path: Path, data: str | bytes, content: bytes) -> None:
    target = tmp_path / "out.svg"
    for _ in range(2):
        write_atomically(str(target), data)
        assert target.read_bytes() == content
    assert os.listdir(tmp_path) == ["out.svg"]  # noqa: PTH208 -- names, not paths


def test_relative_path(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    write_atomically("a.txt", "x")
    assert (tmp_path / "a.txt").read_text(encoding="utf-8") == "x"


@pytest.mark.skipif(os.name != "posix", reason="permission bits are POSIX's")
def test_permissions(tmp_path: Path) -> None:
    before = os.umask(0o027)
    try:
        write_atomically(tmp_path / "new", "x")
        assert mode(tmp_path / "new") == 0o640
        (tmp_path / "new").chmod(0o604)
        write_atomically(tmp_path / "new", "y")
        assert mode(tmp_path / "new") == 0o604
    finally:
        os.umask(before)


@pytest.mark.skipif(os.name != "posix", reason="links need rights elsewhere")
def test_writes_through_a_link(tmp_path: Path) -> None:
    (tmp_path / "deep").mkdir()
    (tmp_path / "deep" / "real").write_text("old")
    (tmp_path / "link").symlink_to(tmp_path / "deep" / "real")
    write_atomically(tmp_path / "link", "new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "deep" / "real").read_text(encoding="utf-8") == "new"


@pytest.mark.skipif(os.name != "posix", reason="pipes are POSIX's")
def test_pipe_is_written_to_and_stays(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    try:
        write_atomically(pipe, "through")
        assert os.read(reader, 100) == b"through"
    finally:
        os.close(reader)
    assert pipe.is_fifo()


def test_failure_leaves_the_old_file_and_no_other(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    target = tmp_path / "out"
    target.write_text("old")

    def fail(descriptor: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", fail)
    with pytest.raises(OSError, match="No space left"):
        write_atomically(target, "new")
    assert target.read_text(encoding="utf-8") == "old"
    assert list(tmp_path.iterdir()) == [target]


def test_errors_of_the_system_pass_through(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        write_atomically(tmp_path / "nowhere" / "out", "x")
    with pytest.raises(OSError):
        write_atomically(tmp_path, "x")
    assert list(tmp_path.iterdir()) == []
