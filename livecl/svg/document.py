# SPDX-License-Identifier: Apache-2.0
"""Parse an SVG file to its element tree; files that could do harm are refused before the tree is built."""

from __future__ import annotations

import collections
import os
import re
import zlib
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
#: Most elements read.
MAX_ELEMENTS = 100_000
#: XML entities: most of them, how deep they may refer to each other, and what they expand to together, characters.
MAX_ENTITIES, MAX_ENTITY_DEPTH, MAX_EXPANSION = 500, 8, 5_000_000
#: Longest default value of an attribute that a document type declares, characters: each element may take it.
MAX_DEFAULT = 200


def read_document(source: str | os.PathLike[str] | bytes) -> tuple[str, bytes]:
    """Return the name of an SVG in messages, and its content, cut one byte beyond the largest size."""
    if isinstance(source, bytes):
        return "SVG data", source
    name = os.fspath(source)
    try:
        with Path(source).open("rb") as stream:
            return name, stream.read(MAX_BYTES + 1)
    except OSError as error:
        raise SvgError(f"{name}: {error.strerror or error}; check the path") from error


def decompressed(data: bytes) -> bytes:
    """Decompress ``.svgz``, cut one byte beyond the largest size; return other data as they are."""
    if not data.startswith(b"\x1f\x8b"):
        return data
    try:
        return zlib.decompressobj(wbits=zlib.MAX_WBITS | 16).decompress(data, MAX_BYTES + 1)
    except zlib.error as error:
        raise ValueError(f"compressed data is damaged ({error}); save it again") from error


def parse_document(data: bytes) -> ElementTree.Element:
    """Return the root of an SVG document.

    Raises ValueError if it is too large or nested too deep, is no complete XML document or no SVG, refers to other
    files, or has entities that expand too far.
    """
    data = decompressed(data)
    if len(data) > MAX_BYTES:
        raise ValueError(f"larger than {MAX_BYTES // 1_000_000} MB; remove embedded pictures or simplify its paths")
    try:
        _guard(data).Parse(data, True)
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


def _guard(data: bytes) -> expat.XMLParserType:
    """Return a parser that builds nothing and refuses harmful XML."""
    depth = count = 0
    entities: dict[str, str] = {}
    has_external = False

    def declare_entity(name: str, is_parameter: int, value: str | None, *_: Any) -> None:
        if is_parameter or value is None:
            raise ValueError("refers to XML entities in other files, which are not read; save it as plain SVG")
        entities.setdefault(name, value)
        if len(entities) > MAX_ENTITIES:
            raise ValueError(f"declares more than {MAX_ENTITIES} XML entities; save it as plain SVG")

    def declare_attribute(element: str, attribute: str, kind: str, default: str | None, required: int) -> None:
        if default is not None and ("&" in default or len(default) > MAX_DEFAULT):
            raise ValueError("declares long default values of attributes; save it as plain SVG")

    def refuse_definition(_: str, system_id: str | None, *__: Any) -> None:
        nonlocal has_external
        has_external = system_id is not None
        if system_id and not re.match(r"https?://www\.w3\.org/", system_id):
            raise ValueError("refers to a document type in another file; save it as plain SVG")

    def check_entities() -> None:
        if has_external and (name := _undeclared(entities, data)):
            raise ValueError(f"refers to the XML entity {name[:60]!r}, which it does not declare; save it as plain SVG")
        if entities and _expanded_length(entities, data) > MAX_EXPANSION:
            raise ValueError(f"its XML entities expand to more than {MAX_EXPANSION} characters; save it as plain SVG")

    def refuse_sheet(target: str, _: str) -> None:
        if target == "xml-stylesheet":
            raise ValueError("takes its style from another file; save it with the style inside")

    def enter(*_: Any) -> None:
        nonlocal depth, count
        depth += 1
        count += 1
        if depth > MAX_DEPTH:
            raise ValueError(f"nested deeper than {MAX_DEPTH}; ungroup it")
        if count > MAX_ELEMENTS:
            raise ValueError(f"more than {MAX_ELEMENTS} elements; simplify it first")

    def leave(_: str) -> None:
        nonlocal depth
        depth -= 1

    parser = expat.ParserCreate()
    parser.StartDoctypeDeclHandler = refuse_definition
    parser.EndDoctypeDeclHandler = check_entities
    parser.EntityDeclHandler = declare_entity
    parser.AttlistDeclHandler = declare_attribute
    parser.ProcessingInstructionHandler = refuse_sheet
    parser.StartElementHandler = enter
    parser.EndElementHandler = leave
    return parser


def _references(data: bytes) -> collections.Counter[str]:
    """Count the references to each entity, without those in comments and CDATA."""
    is_wide = b"\0" in data[:4] or data[:2] in (b"\xff\xfe", b"\xfe\xff")
    text = data.decode("utf-16" if is_wide else "utf-8", "replace")
    return collections.Counter(
        re.findall(r"&([^\s&;#<>]+);", re.sub(r"(?s)<!--.*?(?:-->|\Z)|<!\[CDATA\[.*?(?:\]\]>|\Z)", "", text))
    )


def _undeclared(entities: dict[str, str], data: bytes) -> str | None:
    """Return an entity that is used but not declared, if any: the parser would skip it silently."""
    known = entities.keys() | {"amp", "lt", "gt", "quot", "apos"}
    return next((name for name in _references(data) if name not in known), None)


def _expanded_length(entities: dict[str, str], data: bytes) -> int:
    """Return a bound on the characters that all references to entities in a document expand to.

    Raises ValueError if an entity refers to itself, or they nest too deep.
    """
    lengths: dict[str, int] = {}

    def length(name: str, depth: int) -> int:
        if depth > MAX_ENTITY_DEPTH:
            raise ValueError(f"its XML entities nest deeper than {MAX_ENTITY_DEPTH}; save it as plain SVG")
        if name not in lengths:
            value = entities[name]
            inner = [found for found in re.findall(r"&([^\s&;#]+);", value) if found in entities]
            lengths[name] = len(value) + sum(length(found, depth + 1) for found in inner)
        return lengths[name]

    return sum(number * length(name, 0) for name, number in _references(data).items() if name in entities)
