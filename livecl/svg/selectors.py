# SPDX-License-Identifier: Apache-2.0
"""Match CSS selectors against an SVG tree, with a bound on the work.

cssselect2 compiles and tests selectors; the elements and the matcher here count its comparisons, since a chain of
descendant combinators takes depth to the power of its length.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any
from xml.etree.ElementTree import Element

import cssselect2
import tinycss2

#: Most comparisons of elements with selectors, so that no file takes minutes.
MAX_COMPARISONS = 2_000_000
#: Longest selector compiled, tokens: its tests are nested functions, one for each combinator.
MAX_SELECTOR_TOKENS = 60


class _Work:
    """Number of comparisons so far."""

    def __init__(self) -> None:
        self.count = 0

    def add(self, looks: int) -> None:
        self.count += looks
        if self.count > MAX_COMPARISONS:
            raise ValueError("style rules for too many elements; save it without a style sheet")


class _Node(cssselect2.ElementWrapper):  # type: ignore[misc]  # cssselect2 has no types
    """An element of the tree that counts comparisons with its ancestors and siblings."""

    def __init__(self, etree_element: Element, parent: _Node | None, index: int, *rest: Any, **more: Any) -> None:
        self.work: _Work = _Work() if parent is None else parent.work
        self.work.add(1)
        super().__init__(etree_element, parent, index, *rest, **more)

    @property
    def index(self) -> int:
        """Index among the siblings; tests that need it compare up to that many."""
        self.work.add(self._index)
        return self._index

    @index.setter
    def index(self, value: int) -> None:
        self._index = value

    @property
    def ancestors(self) -> tuple[_Node, ...]:
        """Elements around this one, from the root."""
        found = tuple(_chain(self.parent, "parent"))[::-1]
        self.work.add(len(found))
        return found

    @property
    def previous_siblings(self) -> tuple[_Node, ...]:
        """Siblings before this one, in document order."""
        found = tuple(_chain(self.previous, "previous"))[::-1]
        self.work.add(len(found))
        return found


def _chain(node: _Node | None, link: str) -> Iterator[_Node]:
    while node is not None:
        yield node
        node = getattr(node, link)


class Matcher(cssselect2.Matcher):  # type: ignore[misc]  # cssselect2 has no types
    """Selectors and their payloads, matched against the elements of one tree."""

    def __init__(self, root: Element) -> None:
        super().__init__()
        self._root = root
        self._nodes: dict[Element, _Node] = {}

    def add(self, prelude: list[Any], namespaces: dict[str | None, str], payload: object) -> bool:
        """Add the selectors of a rule; False if one of them is unsupported, which makes CSS ignore the rule.

        Parameters
        ----------
        prelude : list of nodes of tinycss2
            The selectors, separated by commas.
        namespaces : dict of str
            URL of each namespace's prefix; that of None is the default.
        payload : object
            Value of :meth:`payloads` for elements that one of the selectors matches.
        """
        selectors: list[list[Any]] = [[]]
        for token in prelude:
            if token.type == "literal" and token.value == ",":
                selectors.append([])
            else:
                selectors[-1].append(token)
        if any(len(tinycss2.serialize(tokens)) > 20 * MAX_SELECTOR_TOKENS for tokens in selectors):
            return False
        if any(len(tokens) > MAX_SELECTOR_TOKENS for tokens in selectors):
            return False
        try:
            compiled = cssselect2.compile_selector_list(prelude, namespaces)
        except (cssselect2.SelectorError, NotImplementedError, SyntaxError, RecursionError):
            return False  # cssselect2 raises any of these for invalid and unsupported selectors
        for selector in compiled:
            if selector.pseudo_element is None:
                self.add_selector(selector, payload)
        return True

    def payloads(self, element: Element) -> list[Any]:
        """Return the payloads of the selectors that match an element, the most specific and latest last."""
        if not self.order:
            return []
        if not self._nodes:
            root = _Node.from_xml_root(self._root)
            self._nodes = {node.etree_element: node for node in root.iter_subtree()}
        node = self._nodes.get(element)
        return [] if node is None else [payload for *_, payload in self.match(node)]

    @staticmethod
    def add_relevant_selectors(element: _Node, selectors: list[Any], relevant_selectors: list[Any]) -> None:
        """Append the entries whose selectors match, counting each."""
        element.work.add(len(selectors))
        cssselect2.Matcher.add_relevant_selectors(element, selectors, relevant_selectors)
