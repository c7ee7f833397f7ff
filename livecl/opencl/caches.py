# SPDX-License-Identifier: Apache-2.0
"""Cache folders of compiled kernels: unusable ones are replaced for the lifetime of the process.

PoCL lists no device if it cannot write to its cache, and crashes the process if a library in it is truncated, as by a
full disk or a power failure. Both are prevented here, before PoCL is first used.
"""

from __future__ import annotations

import contextlib
import errno
import functools
import logging
import os
import struct
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from livecl.errors import DeviceError

#: Environment variables with the folder of PoCL's cache, and that of all programs' caches.
POCL_VARIABLE, CACHES_VARIABLE = "POCL_CACHE_DIR", "XDG_CACHE_HOME"

_log = logging.getLogger(__name__)


def pocl_cache() -> Path:
    """Return the folder where PoCL keeps its cache, by PoCL's own rule."""
    if folder := os.environ.get(POCL_VARIABLE):
        return Path(folder)
    if folder := os.environ.get(CACHES_VARIABLE):
        return Path(folder, "pocl", "kcache")
    if folder := os.environ.get("HOME"):
        return Path(folder, ".cache", "pocl", "kcache")
    return Path("/tmp/pocl/kcache")


@functools.cache
def prepare_pocl_cache() -> None:
    """Ensure that PoCL, which reads its variable once, finds a writable cache without broken files.

    Broken files are deleted, so that PoCL compiles their kernels anew. If that fails, PoCL gets a temporary folder. A
    warning is logged in both cases.
    """
    if sys.platform != "linux":
        return  # PoCL is untested there, and its files are of other kinds
    folder = pocl_cache()
    try:
        _require_writable(folder)
        for path in _broken_files(folder):
            _log.warning("%s is broken; it is deleted, and its kernel is compiled anew", path)
            path.unlink(missing_ok=True)
    except OSError as error:
        os.environ[POCL_VARIABLE] = str(_temporary_folder() / "pocl")
        _log.warning(
            "PoCL cannot keep compiled kernels in %s (%s): this process compiles them into a temporary folder; set "
            "%s to a folder that can be written to",
            folder,
            error.strerror,
            CACHES_VARIABLE,
        )


@contextlib.contextmanager
def pyopencl_cache(broken: Exception | None = None) -> Iterator[None]:
    """Context manager: let pyopencl open its caches, if necessary in a temporary folder.

    `broken` is the error of the cache opened last, if it cannot be used.
    """
    problem = broken or _problem_of_pyopencl_cache()
    if problem is None:
        yield
        return
    before = os.environ.get(CACHES_VARIABLE)
    os.environ[CACHES_VARIABLE] = str(_temporary_folder())
    try:
        yield
    finally:
        if before is None:
            del os.environ[CACHES_VARIABLE]
        else:
            os.environ[CACHES_VARIABLE] = before


@functools.cache
def _problem_of_pyopencl_cache() -> OSError | None:
    folder = Path(os.environ.get(CACHES_VARIABLE) or Path("~/.cache").expanduser())
    try:
        _require_writable(folder)
    except OSError as error:
        _log.warning("pyopencl cannot keep its cache in %s (%s) and gets a temporary folder", folder, error.strerror)
        return error
    return None


def _temporary_folder() -> Path:
    """Return a folder that is deleted at the end of the process (unless it is killed)."""
    return Path(_made_temporary_folder().name)


@functools.cache
def _made_temporary_folder() -> tempfile.TemporaryDirectory[str]:
    try:
        return tempfile.TemporaryDirectory(prefix="livecl-", ignore_cleanup_errors=True)
    except OSError as error:
        raise DeviceError(
            f"compiled kernels can be kept nowhere ({error}); set {CACHES_VARIABLE} to a folder that can be written to"
        ) from error


def _require_writable(folder: Path) -> None:
    """Raise OSError unless files can be created in a folder, or in its nearest existing parent."""
    while not folder.exists():
        folder = folder.parent
    for code, is_so in ((errno.ENOTDIR, not folder.is_dir()), (errno.EACCES, not os.access(folder, os.W_OK | os.X_OK))):
        if is_so:
            raise OSError(code, os.strerror(code), str(folder))


def _broken_files(cache: Path) -> list[Path]:
    """Return the truncated files of PoCL's cache; raise OSError if one cannot be read, or its folder not be written to.

    An entry is a folder ``AB/CDEF…`` of a program: ``program.bc``, in LLVM's bitcode, and libraries
    ``kernel/work-group size/kernel.so``. Files being written lie beside the entries until they are complete.
    """
    broken = []
    for folder, _, names in os.walk(cache, onerror=_raise):
        _require_writable(Path(folder))
        for name in names if Path(folder) != cache else ():
            path = Path(folder, name)
            is_whole = {".bc": is_whole_bitcode, ".so": is_whole_library}.get(path.suffix)
            with contextlib.suppress(FileNotFoundError):  # another process has deleted it
                if is_whole is not None and not is_whole(path):
                    broken.append(path)
    return broken


def _raise(error: OSError) -> None:
    if not isinstance(error, FileNotFoundError):  # no cache yet, or another process has tidied up
        raise error


def is_whole_bitcode(path: Path) -> bool:
    """Return whether a file is LLVM bitcode: the magic number and top-level blocks, the last of which ends the file.

    A block is a word with its kind (its lowest two bits are 1), its length in words of four bytes, and its content.
    """
    with path.open("rb") as file:
        size = os.fstat(file.fileno()).st_size
        if file.read(4) != b"BC\xc0\xde":
            return False
        end = 4
        while end < size:
            file.seek(end)
            header = file.read(8)
            if len(header) < 8:
                return False
            kind, words = struct.unpack("<2I", header)
            if kind & 3 != 1:
                return False
            end += 8 + 4 * words
    return 4 < end == size


def is_whole_library(path: Path) -> bool:
    """Return whether a file is an ELF library that contains its table of sections, which linkers write last."""
    with path.open("rb") as file:
        size = os.fstat(file.fileno()).st_size
        header = file.read(64)
    if len(header) < 64 or header[:4] != b"\x7fELF":
        return False
    if header[4:6] != b"\x02\x01":  # not 64 bits, little-endian
        return True
    (start,) = struct.unpack_from("<Q", header, 0x28)
    entry_size, count = struct.unpack_from("<2H", header, 0x3A)
    return start > 0 and bool(start + entry_size * count <= size)
