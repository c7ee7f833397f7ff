# SPDX-License-Identifier: Apache-2.0
"""The method's parameters as arguments of the command line, made from the fields of `Options`."""

from __future__ import annotations

import argparse
import contextlib
import dataclasses
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any, get_args, get_type_hints

from livecl.options import Options

_METAVARS = {int: "N", float: "X", str: "COLOR"}


def add_method(add: Callable[..., argparse.Action]) -> None:
    """Add an argument for each field, without a default: that is the preset's."""
    hints = get_type_hints(Options)
    for field in dataclasses.fields(Options):
        default = str(field.default).lower() if hints[field.name] is bool else field.default
        text = f"{field.metadata['help'].replace('`', '')} (default: {default})".replace("%", "%%")
        option = f"--{field.name.replace('_', '-')}"
        if hints[field.name] is bool:
            add(option, action=argparse.BooleanOptionalAction, default=None, help=text)
        elif choices := get_args(hints[field.name]):
            add(option, choices=choices, help=text)
        else:
            kind = hints[field.name]
            add(option, type=_converter(field.name, kind), metavar=_METAVARS[kind], help=text)


def given_options(arguments: argparse.Namespace) -> Options:
    """Return the options: the preset's, as changed by the arguments.

    Raises ValueError if they do not go together.
    """
    names = [field.name for field in dataclasses.fields(Options)]
    given = {name: getattr(arguments, name) for name in names if getattr(arguments, name) is not None}
    # Random places have no region to fit an outline to.
    if arguments.placement == "random" and Options.preset(arguments.preset).shape == "outline":
        given.setdefault("shape", "circle")
    return Options.preset(arguments.preset, **given)


def palette_text(text: str) -> str:
    """Return the colours of a file (``#rrggbb`` or GIMP's lines), separated by commas; other text unchanged.

    Raises argparse.ArgumentTypeError if the file has no colours, or if text that looks like a file name names none.
    """
    if not Path(text).is_file():
        if text and (Path(text).is_dir() or re.search(r"[^\s,()]\.[A-Za-z]\w*$", text)):
            raise argparse.ArgumentTypeError(f"{text}: there is no such file; colours are such as #rrggbb,navy")
        return text
    content = Path(text).read_text(encoding="utf-8", errors="replace")
    found = re.findall(r"#[0-9a-fA-F]{6}\b", content)
    if not found:
        levels = re.findall(r"^\s*(\d{1,3})\s+(\d{1,3})\s+(\d{1,3})\b", content, flags=re.MULTILINE)
        found = [f"rgb({' '.join(triple)})" for triple in levels]
    if not found:
        raise argparse.ArgumentTypeError(f"{text}: holds no colours, wanted #rrggbb or lines of red, green and blue")
    return ",".join(dict.fromkeys(found))


def _converter(name: str, kind: type) -> Callable[[str], Any]:
    """Return a converter of text to a field's value that refuses values refused by `Options`."""

    def convert(text: str) -> Any:
        value: Any = palette_text(text) if name == "palette" else text
        with contextlib.suppress(ValueError):  # it stays text, which is refused below
            value = kind(text)
        try:
            Options(**{name: value})
        except ValueError as error:
            reason = str(error).removeprefix(f"{name}: ")
            reason = re.sub(r"^got .*?, wanted", lambda _: f"got {text!r}, wanted", reason)
            raise argparse.ArgumentTypeError(reason) from error
        return value

    return convert
