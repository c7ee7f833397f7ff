# SPDX-License-Identifier: Apache-2.0
"""Style declarations of SVG: simple style sheets, what an element inherits."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from xml.etree.ElementTree import Element

#: Properties that an element takes from its parent where it does not state them.
INHERITED = ("color", "fill", "fill-opacity", "fill-rule", "stroke", "stroke-opacity", "stroke-width", "visibility")

_SELECTOR = re.compile(r"(\*|[a-zA-Z][\w-]*)?((?:[.#][\w-]+)*)")


class StyleSheet:
    """Rules of a document's ``<style>`` elements whose selectors are ``*``, ``tag``, ``.class``, ``#id`` or joined so.

    Parameters
    ----------
    texts : iterable of str
        Text of each ``<style>`` element, in document order.
    """

    def __init__(self, texts: Iterable[str]) -> None:
        self.num_unknown = 0
        """Number of rules that were not understood: combinators, pseudo-classes, at-rules."""
        self._rules: list[tuple[tuple[int, int], str, frozenset[str], dict[str, str]]] = []
        for text in texts:
            for rule in re.sub(r"/\*.*?(\*/|$)", " ", text, flags=re.DOTALL).split("}"):
                selectors, brace, body = rule.partition("{")
                if brace:
                    self._add(selectors, _declarations(body))
                elif selectors.strip():
                    self.num_unknown += 1
        self._rules.sort(key=lambda rule: rule[0])  # stable: later rules win among equals

    def _add(self, selectors: str, declarations: dict[str, str]) -> None:
        for selector in selectors.split(","):
            match = _SELECTOR.fullmatch(selector.strip())
            if not match or not selector.strip():
                self.num_unknown += 1
                continue
            marks = frozenset(re.findall(r"[.#][\w-]+", match[2]))
            tag = match[1] if match[1] and match[1] != "*" else ""
            num_ids = sum(mark[0] == "#" for mark in marks)
            weight = (num_ids, 2 * (len(marks) - num_ids) + bool(tag))
            self._rules.append((weight, tag, marks, declarations))

    def declarations(self, element: Element, tag: str) -> dict[str, str]:
        """Return an element's own properties: its attributes, beneath matching rules, beneath its style attribute."""
        own = {name: value.strip() for name, value in element.attrib.items() if not name.startswith("{")}
        marks = {f".{name}" for name in own.get("class", "").split()} | {f"#{own.get('id', '')}"}
        for _, wanted_tag, wanted_marks, declarations in self._rules:
            if wanted_tag in ("", tag) and wanted_marks <= marks:
                own.update(declarations)
        own.update(_declarations(own.get("style", "")))
        return own


def inherit(parent: Mapping[str, str], own: Mapping[str, str]) -> dict[str, str]:
    """Return the inherited properties of an element with its own declarations applied."""
    style = dict(parent)
    for name in INHERITED:
        if own.get(name, "inherit") != "inherit":
            style[name] = own[name]
    return style


def _declarations(text: str) -> dict[str, str]:
    found = {}
    for declaration in text.split(";"):
        name, colon, value = declaration.partition(":")
        if colon:
            found[name.strip().lower()] = value.replace("!important", "").strip()
    return found
