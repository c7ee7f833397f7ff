# SPDX-License-Identifier: Apache-2.0
"""An SVG file's bytes to its element tree: refused before the tree is built where that could harm."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any
from xml.etree import ElementTree
from xml.parsers import expat

from livecl.errors import SvgError
from livecl.svg.writer import SVG_NAMESPACE

#: Largest file read, bytes.
MAX_BYTES = 50_000_000
#: Deepest nesting followed.
MAX_DEPTH = 100


def read_document(source: str | os.PathLike[str] | bytes) -> tuple[str, bytes]:
    """Return what messages call an SVG, and its content, at most a byte more than is read."""
    if isinstance(source, bytes):
        return "SVG data", source
    name = os.fspath(source)
    try:
        with Path(source).open("rb") as stream:
            return name, stream.read(MAX_BYTES + 1)
    except OSError as error:
        raise SvgError(f"{name}: {error.strerror or error}; check the path") from error


def parse_document(data: bytes) -> ElementTree.Element:
    """Return the root of an SVG document.

    Raises
    ------
    ValueError
        If it is too large or nested too deep, not a whole XML document, no SVG, or refers to entities or other files.
    """
    if len(data) > MAX_BYTES:
        raise ValueError(f"larger than {MAX_BYTES // 1_000_000} MB; remove embedded pictures or simplify its paths")
    try:
        _guard().Parse(data, True)
        root = ElementTree.fromstring(data)
    except (expat.ExpatError, ElementTree.ParseError, LookupError) as error:
        raise ValueError(f"not a whole XML document ({error}); save it again as plain SVG") from error
    if tag_of(root) != "svg":
        raise ValueError(f"its outermost element is <{root.tag[:60]}>, wanted <svg>")
    return root


def tag_of(element: ElementTree.Element) -> str | None:
    """Return the name of an SVG element, with or without its namespace; None for one of another namespace."""
    if element.tag.startswith("{"):
        namespace, _, name = element.tag[1:].partition("}")
        return name if namespace == SVG_NAMESPACE else None
    return element.tag


def _guard() -> expat.XMLParserType:
    """Return a parser that builds nothing and refuses what could harm."""
    depth = 0

    def refuse_entity(*_: Any) -> None:
        raise ValueError("declares XML entities, which are not read; save it as plain SVG")

    def refuse_definition(_: str, system_id: str | None, *__: Any) -> None:
        if system_id and not re.match(r"https?://www\.w3\.org/", system_id):
            raise ValueError("refers to a document type in another file; save it as plain SVG")

    def refuse_sheet(target: str, _: str) -> None:
        if target == "xml-stylesheet":
            raise ValueError("takes its style from another file; save it with the style inside")

    def enter(*_: Any) -> None:
        nonlocal depth
        depth += 1
        if depth > MAX_DEPTH:
            raise ValueError(f"nested deeper than {MAX_DEPTH}; ungroup it")

    def leave(_: str) -> None:
        nonlocal depth
        depth -= 1

    parser = expat.ParserCreate()
    parser.StartDoctypeDeclHandler = refuse_definition
    parser.EntityDeclHandler = refuse_entity
    parser.ProcessingInstructionHandler = refuse_sheet
    parser.StartElementHandler = enter
    parser.EndElementHandler = leave
    return parser
