# SPDX-License-Identifier: Apache-2.0
"""Write files atomically; check before the work that a file can be written."""

from __future__ import annotations

import contextlib
import hashlib
import os
import secrets
import tempfile
from pathlib import Path

#: Free space required in a folder before the work, bytes: that of a drawing of hundreds of paths.
MIN_ROOM = 1 << 16


def write_atomically(path: str | os.PathLike[str], data: str | bytes) -> None:
    """Write a file atomically: a reader, or a crash, finds the old content or the new, never a part.

    The data goes to a temporary file beside the target, is flushed to disk and takes the target's name. An existing
    file keeps its permission bits, a symbolic link stays one, and a file that is not regular (a pipe, ``/dev/null``) is
    written to directly.

    Parameters
    ----------
    path : path
        File to write.
    data : str or bytes
        Its content; text is written as UTF-8, with its line ends as they are.

    Raises
    ------
    OSError
        If the file cannot be written; nothing is left beside it.
    """
    content = data.encode() if isinstance(data, str) else data
    target = Path(path).resolve()
    if target.exists() and not target.is_file():
        with target.open("wb") as stream:
            stream.write(content)
        return
    temporary = target.with_name(f"{_temporary_prefix(target)}{secrets.token_hex(8)}.tmp")
    try:
        with temporary.open("xb") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        with contextlib.suppress(FileNotFoundError):
            temporary.chmod(target.stat().st_mode & 0o7777)
        temporary.replace(target)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


def remove_leftovers(path: str | os.PathLike[str]) -> None:
    """Delete temporary files beside a file that were left by killed writes.

    No other process may be writing the file.
    """
    target = Path(path).resolve()
    for leftover in target.parent.glob(f"{_temporary_prefix(target)}*.tmp"):
        leftover.unlink(missing_ok=True)


def _temporary_prefix(target: Path) -> str:
    """Return the prefix of a file's temporary names: a digest, as the name itself may have the maximum length."""
    return f".livecl-{hashlib.sha256(os.fsencode(target.name)).hexdigest()[:16]}-"


def check_file(file: Path) -> None:
    """Raise ValueError, before the work, if a file could not be written after it."""
    if file.is_dir():
        raise ValueError(f"{file}: is a folder, wanted a file to write")
    if not file.exists() or file.is_file():
        check_folder(file.resolve().parent, file)


def check_folder(folder: Path, wanted: Path) -> None:
    """Raise ValueError, naming the file `wanted`, if no file can be created in a folder.

    A file is created to find out: access rights are not conclusive (superuser, read-only or full disks).
    """
    if not folder.exists():
        raise ValueError(f"{wanted}: the folder {folder} does not exist")
    if not folder.is_dir():
        raise ValueError(f"{wanted}: {folder} is not a folder")
    try:
        with tempfile.TemporaryFile(dir=folder) as file:
            file.write(bytes(MIN_ROOM))
    except OSError as error:
        raise ValueError(f"{wanted}: cannot write into {folder}: {error.strerror or error}") from error
