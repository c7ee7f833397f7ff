# SPDX-License-Identifier: Apache-2.0
"""Files that are either written whole or left as they were."""

from __future__ import annotations

import contextlib
import os
import secrets


def write_atomically(path: str | os.PathLike[str], data: str | bytes) -> None:
    """Write a file so that a reader, or a crash, meets the old content or the new, never a part.

    The data goes to a temporary file beside the target, is flushed to disk and takes the target's name. An existing
    file keeps its permission bits, a symbolic link stays one, and what is no regular file (a pipe, ``/dev/null``) is
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
    target = os.path.realpath(path)
    if os.path.exists(target) and not os.path.isfile(target):
        with open(target, "wb") as stream:
            stream.write(content)
        return
    temporary = os.path.join(os.path.dirname(target), f".livecl-{secrets.token_hex(8)}.tmp")
    try:
        with open(temporary, "xb") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        with contextlib.suppress(FileNotFoundError):
            os.chmod(temporary, os.stat(target).st_mode & 0o7777)
        os.replace(temporary, target)
    except BaseException:
        with contextlib.suppress(FileNotFoundError):
            os.unlink(temporary)
        raise
