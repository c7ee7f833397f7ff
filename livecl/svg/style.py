# SPDX-License-Identifier: Apache-2.0
"""The cascade: each element's properties from style sheets, style attributes and presentation attributes."""

from __future__ import annotations

import collections
import functools
import re
from collections.abc import Mapping
from typing import Any
from xml.etree.ElementTree import Element

import tinycss2

from livecl.svg.coordinates import is_length
from livecl.svg.document import tag_of
from livecl.svg.paint import is_valid
from livecl.svg.selectors import Matcher

#: Inherited properties, with their initial values.
INHERITED = {
    "color": "black",
    "color-interpolation": "srgb",
    "fill": "black",
    "fill-opacity": "1",
    "fill-rule": "nonzero",
    "font-size": "medium",
    "shape-rendering": "auto",
    "stroke": "none",
    "paint-order": "normal",
    "stroke-dasharray": "none",
    "stroke-dashoffset": "0",
    "stroke-linecap": "butt",
    "stroke-linejoin": "miter",
    "stroke-miterlimit": "4",
    "stroke-opacity": "1",
    "stroke-width": "1",
    "visibility": "visible",
}
#: Deepest nesting of brackets in CSS.
MAX_NESTING = 32

_GEOMETRY = {"cx", "cy", "d", "height", "r", "rx", "ry", "width", "x", "y"}
#: Properties without a presentation attribute.
_ONLY_CSS = {
    "animation",
    "animation-name",
    "background",
    "background-color",
    "font",
    "isolation",
    "mask-image",
    "mix-blend-mode",
    "offset-path",
    "rotate",
    "scale",
    "translate",
}
#: Properties that are read, or that warnings name as unsupported.
_PROPERTIES = (
    INHERITED.keys()
    | _GEOMETRY
    | _ONLY_CSS
    | {"clip", "clip-path", "display", "filter", "marker", "marker-end", "marker-mid", "marker-start", "mask"}
    | {"opacity", "overflow", "stop-color", "stop-opacity", "transform", "transform-box", "transform-origin"}
    | {"vector-effect", "viewport-fill"}
)
#: Properties whose values are case-insensitive keywords.
_WORDS = {"color-interpolation", "display", "fill-rule", "overflow", "shape-rendering", "transform-box", "visibility"}
_WIDE = {"inherit", "initial", "unset", "revert", "revert-layer"}
#: At-rules without effect on shapes.
_HARMLESS = {"charset", "color-profile", "counter-style", "font-face", "font-feature-values", "page", "property"}
#: Media queries, and their results for a static picture on a light page.
_MEDIA = {
    **dict.fromkeys(("", "all", "screen", "only screen", "(prefers-color-scheme: light)"), True),
    **dict.fromkeys(("print", "speech", "braille", "embossed", "handheld", "projection", "tty", "tv", "aural"), False),
    **dict.fromkeys(("not all", "not screen", "(prefers-color-scheme: dark)"), False),
}

#: (property, value, whether it is important) of each declaration.
_Declarations = tuple[tuple[str, str, bool], ...]


class StyleSheet:
    """The style sheets of a document, and the properties of each element.

    Unreadable parts are counted in `left_out`. Raises ValueError if a sheet nests brackets too deep, or sheets take too
    much work.
    """

    def __init__(self, root: Element, left_out: collections.Counter[str]) -> None:
        self._left_out = left_out
        self._matcher = Matcher(root)
        for element in root.iter():
            if tag_of(element) != "style" or not _is_css(element.get("type")):
                continue
            if self._applies(element.get("media", "")):
                text = "".join(element.itertext())
                _check_nesting(text)
                self._add(tinycss2.parse_stylesheet(text, skip_comments=True, skip_whitespace=True), {})

    def _add(self, rules: list[Any], namespaces: dict[str | None, str]) -> None:
        for rule in rules:
            if rule.type == "qualified-rule":
                declarations, whole = _declarations_of(rule.content)
                if not self._matcher.add(rule.prelude, namespaces, declarations) or not whole:
                    self._left_out["style rules"] += 1
            elif rule.type == "at-rule" and rule.lower_at_keyword == "media" and rule.content is not None:
                if self._applies(tinycss2.serialize(rule.prelude)):
                    content = tinycss2.parse_rule_list(rule.content, skip_comments=True, skip_whitespace=True)
                    self._add(content, namespaces)
            elif rule.type == "at-rule" and rule.lower_at_keyword == "namespace":
                names = [token for token in rule.prelude if token.type not in ("whitespace", "comment")]
                url = next((token.value for token in names if token.type in ("string", "url")), "")
                namespaces[names[0].value if names and names[0].type == "ident" else None] = url
            elif rule.type != "at-rule" or rule.lower_at_keyword not in _HARMLESS:
                keyframes = rule.type == "at-rule" and rule.lower_at_keyword.endswith("keyframes")
                self._left_out["animations" if keyframes else "style rules"] += 1

    def _applies(self, queries: str) -> bool:
        """Whether one of a list of media queries matches a static picture on a light page; unknown ones do not."""
        found = False
        for query in queries.split(","):
            words = " ".join(query.lower().replace(":", ": ").split())
            if words not in _MEDIA:
                self._left_out["style rules"] += 1
            found = found or _MEDIA.get(words, False)
        return found

    def properties(self, element: Element, parent: Mapping[str, str]) -> dict[str, str]:
        """Return the attributes of an element, and its properties by the cascade.

        In rising precedence: presentation attributes, matching rules, the style attribute, and ``!important``
        declarations of both. Invalid values are ignored and counted. `parent` has the properties of the parent, for
        ``inherit``.
        """
        own: dict[str, str] = {}
        for name, value in element.attrib.items():
            if not name.startswith("{") and name not in _ONLY_CSS:
                self._state(own, name, value.strip())
        declared: list[_Declarations] = self._matcher.payloads(element)
        if "style" in own:
            declared.append(_declarations(own["style"]))
        if declared:
            for important in (False, True):
                for name, value, is_important in (item for declarations in declared for item in declarations):
                    if is_important == important:
                        self._state(own, name, value, is_css=True)
        for name in [name for name, value in own.items() if value in _WIDE and name in _PROPERTIES]:
            word = own.pop(name)
            if word == "initial" and name in INHERITED:
                own[name] = INHERITED[name]
            elif word == "inherit" and name not in INHERITED.keys() | _GEOMETRY and name in parent:
                own[name] = parent[name]
        return own

    def _state(self, own: dict[str, str], name: str, value: str, is_css: bool = False) -> None:
        if name in _WORDS:
            value = value.lower()
        if value.lower() in _WIDE and name in _PROPERTIES:
            own[name] = value.lower()
        elif is_valid(name, value) and not (is_css and name in _GEOMETRY - {"d"} and not is_length(value)):
            own[name] = value
        else:
            colors = name in ("fill", "stroke", "color", "stop-color")
            self._left_out["unknown colours" if colors else "unknown values of properties"] += 1


def inherit(parent: Mapping[str, str], own: Mapping[str, str]) -> dict[str, str]:
    """Return the inherited properties of an element with its own applied."""
    style = dict(parent)
    for name in INHERITED:
        if name in own:
            style[name] = own[name]
    return style


def _is_css(kind: str | None) -> bool:
    return kind is None or kind.partition(";")[0].strip().lower() in ("", "text/css")


@functools.lru_cache(maxsize=4096)
def _declarations(text: str) -> _Declarations:
    """Return the declarations of a style attribute."""
    _check_nesting(text)
    return _declarations_of(text)[0]


def _declarations_of(content: Any) -> tuple[_Declarations, bool]:
    """Return the declarations of a block, and whether it contains nothing else."""
    found, whole = [], True
    for node in tinycss2.parse_blocks_contents(content, skip_comments=True, skip_whitespace=True):
        if node.type != "declaration":
            whole = whole and node.type == "error"  # CSS ignores errors
        elif node.lower_name in _PROPERTIES:
            value = [token for token in node.value if token.type != "comment"]
            found.append((node.lower_name, tinycss2.serialize(value).strip(), node.important))
    return tuple(found), whole


def _check_nesting(text: str) -> None:
    """Refuse CSS with brackets nested too deep for recursive functions."""
    depth = deepest = 0
    for bracket in re.findall(r"[(\[{)\]}]", text):
        depth = depth + 1 if bracket in "([{" else max(0, depth - 1)
        deepest = max(deepest, depth)
    if deepest > MAX_NESTING:
        raise ValueError(f"style sheets with brackets nested deeper than {MAX_NESTING}; save it without a style sheet")
