# SPDX-License-Identifier: Apache-2.0
"""Style declarations of SVG: simple style sheets, what an element inherits."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from xml.etree.ElementTree import Element

#: Properties that an element takes from its parent where it does not state them.
INHERITED = ("color", "fill", "fill-opacity", "fill-rule", "stroke", "stroke-opacity", "stroke-width", "visibility")

_SELECTOR = re.compile(r"(\*|[a-zA-Z][\w-]*)?((?:[.#][\w-]+)*)")


#: Most comparisons of elements with rules, so that no file takes minutes.
MAX_COMPARISONS = 5_000_000

_Declarations = dict[str, str]


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
        self._num_comparisons = 0
        self._rules: list[tuple[tuple[int, int], str, frozenset[str], tuple[_Declarations, _Declarations]]] = []
        for text in texts:
            text = re.sub(r"/\*.*?(\*/|$)|@charset[^;{}]*;", " ", text, flags=re.DOTALL)
            text, num_statements = re.subn(r"@[^;{}]*;", " ", text)
            self.num_unknown += num_statements
            for rule in text.split("}"):
                selectors, brace, body = rule.partition("{")
                if brace:
                    self._add(selectors, _declarations(body))
                elif selectors.strip():
                    self.num_unknown += 1
        self._rules.sort(key=lambda rule: rule[0])  # stable: later rules win among equals

    def _add(self, selectors: str, declarations: tuple[_Declarations, _Declarations]) -> None:
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
        """Return an element's own properties.

        From the weakest: its attributes, rules that match, its style attribute, and what is ``!important`` of both.
        """
        self._num_comparisons += len(self._rules)
        if self._num_comparisons > MAX_COMPARISONS:
            raise ValueError(f"{len(self._rules)} style rules for too many elements; save it without a style sheet")
        own = {name: value.strip() for name, value in element.attrib.items() if not name.startswith("{")}
        marks = {f".{name}" for name in own.get("class", "").split()} | {f"#{own.get('id', '')}"}
        matching = [
            declarations
            for _, wanted_tag, wanted_marks, declarations in self._rules
            if wanted_tag in ("", tag) and wanted_marks <= marks
        ]
        if "style" in own:
            matching.append(_declarations(own["style"]))
        for important in (False, True):
            for declarations in matching:
                own.update(declarations[important])
        return own


def inherit(parent: Mapping[str, str], own: Mapping[str, str]) -> dict[str, str]:
    """Return the inherited properties of an element with its own declarations applied."""
    style = dict(parent)
    for name in INHERITED:
        if own.get(name, "inherit") != "inherit":
            style[name] = own[name]
    return style


def _declarations(text: str) -> tuple[_Declarations, _Declarations]:
    """Return the declarations of a rule or a style attribute, those that are ``!important`` apart."""
    found: tuple[_Declarations, _Declarations] = {}, {}
    for declaration in text.split(";"):
        name, colon, value = declaration.partition(":")
        value, mark, _ = value.partition("!")
        if colon:
            found[bool(mark)][name.strip().lower()] = value.strip()
    return found
