# SPDX-License-Identifier: Apache-2.0
"""Colours and style declarations of SVG: CSS colours, simple style sheets, what an element inherits."""

from __future__ import annotations

import colorsys
import math
import re
from collections.abc import Iterable, Mapping
from xml.etree.ElementTree import Element

#: Properties that an element takes from its parent where it does not state them.
INHERITED = ("color", "fill", "fill-opacity", "fill-rule", "stroke", "stroke-opacity", "stroke-width", "visibility")

_HEX = re.compile(r"#([0-9a-f]{3,4}|[0-9a-f]{6}|[0-9a-f]{8})")
_FUNCTION = re.compile(r"(rgb|hsl)a?\(([^()]*)\)")
_SELECTOR = re.compile(r"(\*|[a-zA-Z][\w-]*)?((?:[.#][\w-]+)*)")

Rgba = tuple[float, float, float, float]


def parse_rgba(text: str) -> Rgba:
    """Return the straight RGBA in [0, 1] of a CSS colour: a name, ``#`` and 3, 4, 6 or 8 digits, ``rgb()``, ``hsl()``.

    Raises
    ------
    ValueError
        If `text` is no such colour.
    """
    from PIL import ImageColor

    word = text.strip().lower()
    if word == "transparent":
        return 0.0, 0.0, 0.0, 0.0
    if word in ImageColor.colormap:
        red, green, blue = ImageColor.getrgb(word)[:3]
        return red / 255, green / 255, blue / 255, 1.0
    if match := _HEX.fullmatch(word):
        digits = match[1] if len(match[1]) > 4 else "".join(2 * digit for digit in match[1])
        levels = bytes.fromhex(digits.ljust(8, "f"))
        return levels[0] / 255, levels[1] / 255, levels[2] / 255, levels[3] / 255
    if match := _FUNCTION.fullmatch(word):
        parts = re.split(r"\s*[,/]\s*|\s+", match[2].strip())
        if len(parts) in (3, 4):
            try:
                alpha = share(parts[3]) if len(parts) == 4 else 1.0
                if match[1] == "rgb":
                    return share(parts[0], 255.0), share(parts[1], 255.0), share(parts[2], 255.0), alpha
                hue = float(parts[0].removesuffix("deg")) / 360 % 1
                if math.isfinite(hue):
                    return (*colorsys.hls_to_rgb(hue, share(parts[2], 100.0), share(parts[1], 100.0)), alpha)
            except ValueError:
                pass  # a part that is no number: reported like any other text that is no colour
    raise ValueError(f"got {text!r}, wanted a colour: a CSS name such as 'white', '#rgb', '#rrggbb' or 'rgb(r, g, b)'")


def parse_color(text: str) -> tuple[float, float, float]:
    """Return the RGB in [0, 1] of an opaque CSS colour: ``white``, ``#rgb``, ``#rrggbb``, ``rgb(r, g, b)``.

    Raises
    ------
    ValueError
        If `text` is no colour, or a translucent one.
    """
    if not isinstance(text, str):
        raise ValueError(f"color: got {text!r}, wanted text such as 'white' or '#rrggbb'")
    try:
        red, green, blue, alpha = parse_rgba(text)
    except ValueError as error:
        raise ValueError(f"color: {error}") from None
    if alpha < 1:
        raise ValueError(f"color: got {text!r}, wanted an opaque colour")
    return red, green, blue


def share(text: str, whole: float = 1.0) -> float:
    """Return a number of `whole`, or a percentage, as a share clipped to [0, 1]; ValueError where it is neither."""
    text = text.strip()
    value = float(text[:-1]) / 100 if text.endswith("%") else float(text) / whole
    if math.isnan(value):
        raise ValueError(f"got {text!r}, wanted a number or a percentage")
    return min(max(value, 0.0), 1.0)


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
