# SPDX-License-Identifier: Apache-2.0
"""Groups of an SVG: written around a drawing's layers, its own or one for each stage, and read back."""

from __future__ import annotations

import dataclasses
import itertools
import re
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Literal, TypeVar, get_args

from livecl.svg.markup import quoteattr

if TYPE_CHECKING:
    from livecl.drawing.drawing import Drawing

#: Ways of grouping layers.
GroupKind = Literal["thing", "stage", "none"]
#: Deepest nesting written; the reader refuses files nested deeper than a hundred elements.
MAX_DEPTH = 60

Key = TypeVar("Key")


@dataclasses.dataclass(frozen=True)
class Group:
    """A group: id, label, whether Inkscape lists it as a layer, and its members: layers, by index, and groups."""

    identifier: str
    label: str
    is_layer: bool
    members: list[Group | int]


def groups_of(drawing: Drawing, kind: GroupKind | None) -> list[Group | int]:
    """Return the groups of a drawing's layers, and the layers outside of groups, in paint order.

    Parameters
    ----------
    drawing : Drawing
        Any drawing.
    kind : {"thing", "stage", "none"} or None
        ``thing``: those of the drawing; ``stage``: one for each run of layers that one stage added; ``none``: none.
        None: those of the drawing, or if it has none, its stages.

    Raises
    ------
    ValueError
        If there is no such kind.
    """
    if kind is not None and kind not in get_args(GroupKind):
        raise ValueError(f"groups: got {kind!r}, wanted one of {', '.join(get_args(GroupKind))}")
    if kind is None:
        kind = "thing" if any(drawing.groups) else "stage"
    if kind == "none":
        return list(range(drawing.num_layers))
    names = unique_ids()
    if kind == "stage":
        found: list[Group | int] = []
        for stage, run in itertools.groupby(range(drawing.num_layers), lambda layer: int(drawing.stages[layer])):
            found.append(Group(names(f"stage-{stage + 1}"), f"stage {stage + 1}", True, list(run)))
        return found
    root = Group("", "", False, [])
    stack = [root]
    for layer, whole in enumerate(drawing.groups):
        path = whole[:MAX_DEPTH]
        kept = _common(path, [group.label for group in stack[1:]])
        del stack[kept + 1 :]
        for label in path[kept:]:
            stack[-1].members.append(group := Group(names(label), label, False, []))
            stack.append(group)
        stack[-1].members.append(layer)
    return root.members


def group_ids(members: Sequence[Group | int]) -> Iterator[str]:
    """Yield the ids of groups, and of those in them."""
    for member in members:
        if isinstance(member, Group):
            yield member.identifier
            yield from group_ids(member.members)


def format_members(members: Sequence[Group | int], elements: Sequence[str | None], indent: str = "  ") -> Iterator[str]:
    """Yield the lines of groups and layers; `elements` has each layer's, or None if another's element shows it."""
    for member in members:
        if isinstance(member, int):
            element = elements[member]
            if element is not None:
                yield indent + element
            continue
        layer = 'inkscape:groupmode="layer" ' if member.is_layer else ""
        yield f'{indent}<g {layer}inkscape:label={quoteattr(member.label)} id="{member.identifier}">'
        yield from format_members(member.members, elements, indent + "  ")
        yield f"{indent}</g>"


def unique_ids(reserved: Sequence[str] = ()) -> Callable[[str], str]:
    """Return a function that makes unique ids from names: without spaces and signs, numbered from 2 if taken."""
    taken, counts = set(reserved), dict.fromkeys(reserved, 1)

    def make(name: str) -> str:
        base = identifier = re.sub(r"[^\w.-]+", "-", name)
        while identifier in taken:
            counts[base] = counts.get(base, 1) + 1
            identifier = f"{base}-{counts[base]}"
        taken.add(identifier)
        return identifier

    return make


def told_apart(paths: Sequence[Sequence[tuple[Key, str]]]) -> list[tuple[str, ...]]:
    """Return the names of the groups around each layer, given as (key, name), the outermost first.

    A group that follows another one of the same name gets a number; otherwise they would become one group.
    """
    result: list[tuple[str, ...]] = []
    keys: list[Key] = []
    for path in paths:
        kept = _common([key for key, _ in path], keys)
        names = list(result[-1][:kept]) if result else []
        for depth, (_, name) in enumerate(path[kept:], start=kept):
            before = result[-1][depth] if result and depth < len(result[-1]) and depth == kept else None
            names.append(_next_name(name, before) if before is not None else name)
        result.append(tuple(names))
        keys = [key for key, _ in path]
    return result


def _next_name(name: str, before: str) -> str:
    """Return a name, with the next number if the name before is the same, numbered or not."""
    if before == name:
        return f"{name} 2"
    number = before.removeprefix(f"{name} ")
    return f"{name} {int(number) + 1}" if number != before and re.fullmatch(r"[1-9]\d{0,6}", number) else name


def _common(first: Sequence[object], second: Sequence[object]) -> int:
    """Return the length of the common beginning of two sequences."""
    return next(
        (n for n, (a, b) in enumerate(zip(first, second, strict=False)) if a != b), min(len(first), len(second))
    )
