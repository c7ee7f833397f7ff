# SPDX-License-Identifier: Apache-2.0
"""Configuration files: options read from TOML, and written so that they read back equal."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

from livecl.errors import name_hint


def read_config(path: str | os.PathLike[str], known: Iterable[str]) -> dict[str, Any]:
    """Read a file of options.

    Parameters
    ----------
    path : path
        The TOML file: keys and values, no tables.
    known : iterable of str
        Keys that it may have.

    Returns
    -------
    dict
        Values by key: bool, int, float, text, or a list of these.

    Raises
    ------
    ValueError
        If the file cannot be read, or holds another key; the message names the known one that is nearest.
    """
    name, known = os.fspath(path), sorted(known)
    try:
        values = tomllib.loads(Path(path).read_bytes().decode())
    except OSError as error:
        raise ValueError(f"{name}: cannot be read ({error.strerror or error})") from error
    except ValueError as error:  # tomllib's, and of text that is no UTF-8
        raise ValueError(f"{name}: is not TOML: {error}") from error
    for key, value in values.items():
        if key not in known:
            raise ValueError(f"{name}: no option {key!r}; {name_hint(key.replace('-', '_'), known)}")
        for item in value if isinstance(value, list) else [value]:
            if not isinstance(item, (bool, int, float, str)):
                raise ValueError(f"{name}: {key}: got {item!r}, wanted a number, text, true or false")
    return values


def format_config(values: Mapping[str, Any]) -> str:
    """Return options as TOML, one a line; None is left out.

    >>> print(format_config({"paths": 8, "loss": "mse", "untangle": True, "device": None}), end="")
    paths = 8
    loss = "mse"
    untangle = true
    """
    # Numbers, lists of numbers, true, false and double-quoted text are written the same way in JSON and in TOML, apart
    # from pairs of surrogates, which only JSON has, and the one control character that only TOML wants escaped.
    written = {key: json.dumps(value, ensure_ascii=False) for key, value in values.items() if value is not None}
    return "".join(f"{key} = {text}\n" for key, text in written.items()).replace("\x7f", "\\u007f")
