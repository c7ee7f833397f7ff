# SPDX-License-Identifier: Apache-2.0
"""Hints for unknown keyword arguments."""

from __future__ import annotations

import dataclasses
import difflib
import functools
import inspect
from collections.abc import Callable
from typing import ParamSpec, TypeVar

from livecl.errors import name_hint
from livecl.options import Options

P = ParamSpec("P")
T = TypeVar("T")


def with_hints(function: Callable[P, T]) -> Callable[P, T]:
    """Decorator: for an unknown keyword, raise TypeError that names the nearest parameter or option."""
    known = tuple(inspect.signature(function).parameters)

    @functools.wraps(function)
    def checked(*args: P.args, **kwargs: P.kwargs) -> T:
        for name in kwargs:
            if name not in known:
                raise TypeError(f"{function.__name__}: there is no parameter {name!r}; {_hint(name, known)}")
        return function(*args, **kwargs)

    return checked


def _hint(name: str, known: tuple[str, ...]) -> str:
    fields = [field.name for field in dataclasses.fields(Options)]
    if name in fields:
        return f"it is one of the method's options: options=Options({name}=...)"
    if not difflib.get_close_matches(name, known, 1) and (near := difflib.get_close_matches(name, fields, 1)):
        return f"did you mean options=Options({near[0]}=...)?"
    return name_hint(name, known)
