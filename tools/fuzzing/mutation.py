# SPDX-License-Identifier: Apache-2.0
"""Change bytes as damage or attacks do."""

from __future__ import annotations

import contextlib
import random
import struct
import zlib
from collections.abc import Callable, Sequence

#: Numbers that often cause failures.
EDGES = (0, 1, 2, 7, 8, 16, 127, 128, 255, 256, 32767, 32768, 65535, 65536, 2**24, 2**31 - 1, 2**31, 2**32 - 1)
#: Most changes of one input.
MAX_CHANGES = 6
PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_PNG_CHUNKS = (b"IHDR", b"PLTE", b"tRNS", b"gAMA", b"sRGB", b"iCCP", b"eXIf", b"IDAT", b"acTL", b"fcTL", b"fdAT")


def mutated(rng: random.Random, data: bytes, others: Sequence[bytes]) -> bytes:
    """Return bytes after some changes.

    Parameters
    ----------
    rng : Random
        Source of random numbers.
    data : bytes
        Bytes to change.
    others : sequence of bytes
        Sources of spliced parts.
    """
    if data.startswith(PNG_SIGNATURE) and rng.random() < 0.5:
        return _mutated_png(rng, data)
    for _ in range(rng.randint(1, MAX_CHANGES)):
        if not data:
            break
        change = rng.choice((*_CHANGES, None))
        data = change(rng, data) if change else _splice(rng, data, rng.choice(others))
    return data


def _place(rng: random.Random, data: bytes) -> int:
    """Return a place; half of them among the first 64 bytes, where headers are."""
    return rng.randrange(min(len(data), 64) if rng.random() < 0.5 else len(data))


def _flip(rng: random.Random, data: bytes) -> bytes:
    i = _place(rng, data)
    return data[:i] + bytes([data[i] ^ 1 << rng.randrange(8)]) + data[i + 1 :]


def _replace(rng: random.Random, data: bytes) -> bytes:
    i, count = _place(rng, data), rng.choice((1, 1, 1, 2, 4, 16))
    return data[:i] + rng.randbytes(count) + data[i + count :]


def _set_number(rng: random.Random, data: bytes) -> bytes:
    """Overwrite a number, which may be a length or an offset."""
    i, form = _place(rng, data), rng.choice(("B", "<H", ">H", "<I", ">I"))
    number = rng.choice((*EDGES, len(data), len(data) - i, rng.randrange(len(data)))) % 256 ** struct.calcsize(form)
    return data[:i] + struct.pack(form, number) + data[i + struct.calcsize(form) :]


def _truncate(rng: random.Random, data: bytes) -> bytes:
    return data[: rng.randrange(len(data))]


def _delete(rng: random.Random, data: bytes) -> bytes:
    i = _place(rng, data)
    return data[:i] + data[i + rng.choice((1, 2, 4, rng.randint(1, len(data)))) :]


def _insert(rng: random.Random, data: bytes) -> bytes:
    i = _place(rng, data)
    return data[:i] + rng.randbytes(rng.choice((1, 2, 4, 64))) + data[i:]


def _repeat(rng: random.Random, data: bytes) -> bytes:
    i = _place(rng, data)
    part = data[i : i + rng.randint(1, 64)]
    return data[:i] + part * rng.choice((2, 3, 50)) + data[i + len(part) :]


def _exchange(rng: random.Random, data: bytes) -> bytes:
    a, b, c = sorted(rng.randrange(len(data) + 1) for _ in range(3))
    return data[:a] + data[b:c] + data[a:b] + data[c:]


def _splice(rng: random.Random, data: bytes, other: bytes) -> bytes:
    """Return the beginning of one and the end of another."""
    i = rng.randrange(len(data))
    return data[:i] + other[i if rng.random() < 0.5 else rng.randrange(len(other)) :]


_CHANGES: tuple[Callable[[random.Random, bytes], bytes], ...] = (
    _flip,
    _flip,
    _replace,
    _set_number,
    _set_number,
    _truncate,
    _delete,
    _insert,
    _repeat,
    _exchange,
)


def _mutated_png(rng: random.Random, data: bytes) -> bytes:
    """Change chunks of a PNG that is whole, and give them right checksums, without which none is looked at."""
    chunks, i = [], len(PNG_SIGNATURE)
    while i < len(data):
        (length,) = struct.unpack_from(">I", data, i)
        chunks.append((data[i + 4 : i + 8], data[i + 8 : i + 8 + length]))
        i += 12 + length
    for _ in range(rng.randint(1, 3)):
        k = rng.randrange(len(chunks))
        name, content = chunks[k]
        way = rng.choice(("content", "content", "content", "repeat", "rename", "delete", "shuffle"))
        if way == "content" and content:
            chunks[k] = name, _changed_content(rng, name, content)
        elif way == "repeat":
            chunks.insert(rng.randrange(len(chunks) + 1), chunks[k])
        elif way == "rename":
            chunks[k] = rng.choice(_PNG_CHUNKS), content
        elif way == "delete" and len(chunks) > 1:
            del chunks[k]
        elif way == "shuffle":
            rng.shuffle(chunks)
    parts = [
        struct.pack(">I", len(content)) + name + content + struct.pack(">I", zlib.crc32(name + content))
        for name, content in chunks
    ]
    return PNG_SIGNATURE + b"".join(parts)


def _changed_content(rng: random.Random, name: bytes, content: bytes) -> bytes:
    """Change a chunk's content; mostly its uncompressed data, if it can be inflated."""
    change = rng.choice(_CHANGES)
    if name == b"IDAT" and rng.random() < 0.7:
        with contextlib.suppress(zlib.error):  # a chunk of another name, or changed before
            return zlib.compress(change(rng, zlib.decompress(content)), 1)
    return change(rng, content)
