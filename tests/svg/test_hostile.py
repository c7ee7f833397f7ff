# SPDX-License-Identifier: Apache-2.0
"""Hostile and broken SVG: refused with a clear error, or read, within seconds."""

from __future__ import annotations

import re
import time
import warnings
from pathlib import Path

import pytest

from livecl.errors import SvgError
from livecl.svg import document as svg_document
from livecl.svg import read_svg
from livecl.svg import walker as svg_walker


def document(body: str) -> bytes:
    return f'<svg xmlns="http://www.w3.org/2000/svg" width="100" height="100">{body}</svg>'.encode()


@pytest.mark.parametrize(
    ("body", "words"),
    [
        ('<path id="p" fill="red"/>', "<path id='p'>: has no path data"),
        ('<path d="M0 0L1e400 3 5 5z"/>', "not finite"),
        ('<path d="M0 0L3 3L-1e309 5z"/>', "not finite"),
        ('<path d="M0 0LNaN 3z"/>', "cannot be read"),
        ('<path d="M0 0L5"/>', "cannot be read"),
        ('<path d="M0 0C1 2 3 4 5 Z"/>', "cannot be read"),
        ('<path d="M0 0L5 5 . Z"/>', "cannot be read"),
        ('<path d="M0 0H"/>', "path data"),
        ('<path d="M0 0h"/>', "path data"),
        ('<path d="L5 5 6 7z"/>', "cannot be read"),
        ('<path d="garbage"/>', "cannot be read"),
        ('<path d="v-8"/>', "begin with M"),
        ('<polygon points="0 0 5 5 a 9"/>', "cannot be read"),
        ('<rect width="abc" height="5"/>', "length 'abc'"),
        ('<rect width="1e999" height="5"/>', "not finite"),
        ('<rect width="5" height="5" transform="matrix(1 2)"/>', "transform 'matrix(1 2)'"),
        ('<rect width="5" height="5" transform="spin(3)"/>', "transform 'spin(3)'"),
        ('<g transform="scale(1e300)"><rect width="1e300" height="5"/></g>', "not finite"),
        ('<rect width="1e7" height="5"/>', "within"),
        ('<use href="other.svg#a"/>', "outside the file"),
        ('<g id="a"><use href="#a"/></g>', "nested deeper"),
    ],
)
def test_refused_bodies(body: str, words: str) -> None:
    with pytest.raises(SvgError) as caught:
        read_svg(document(body))
    assert words in str(caught.value)
    assert str(caught.value).startswith("SVG data: ")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"", "not a whole XML document"),
        (b"hello", "not a whole XML document"),
        (document("<g>")[:-3], "not a whole XML document"),
        (b'<?xml version="1.0" encoding="foo"?><svg/>', "not a whole XML document"),
        (b"<html/>", "wanted <svg>"),
        (b'<a:svg xmlns:a="http://www.w3.org/\x7f2000/svg"/>', r"<{http://www.w3.org/ 2000/svg}svg>, wanted <svg>"),
        (b"<svg/>", "states no size"),
        (b'<svg width="5"/>', "states no size"),
        (b'<svg width="-5" height="5"/>', "negative"),
        (b'<svg width="1e6" height="2"/>', "32768"),
        (b'<svg viewBox="0 0 0 5"/>', "viewBox"),
        (b'<svg viewBox="0 0 nan 5"/>', "viewBox"),
        (b'<svg viewBox="1 2 3"/>', "viewBox"),
        (b'<!DOCTYPE svg [<!ENTITY a "b">]><svg width="9" height="9"/>', "entities"),
        (b'<!DOCTYPE svg [<!ENTITY a SYSTEM "file:///etc/passwd">]><svg width="9" height="9">&a;</svg>', "entities"),
        (b'<!DOCTYPE svg [<!ENTITY % a SYSTEM "http://localhost/x">%a;]><svg/>', "entities"),
        ('<!DOCTYPE svg [<!ENTITY a "b">]><svg width="9" height="9"/>'.encode("utf-16"), "entities"),
        (b'<!DOCTYPE svg SYSTEM "file:///etc/passwd"><svg width="9" height="9"/>', "another file"),
        (b'<?xml-stylesheet href="a.css"?><svg width="9" height="9"/>', "another file"),
    ],
)
def test_refused_documents(data: bytes, words: str) -> None:
    with pytest.raises(SvgError, match=words) as caught:
        read_svg(data)
    assert "\n" not in str(caught.value)


def test_bombs_of_use_elements_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(svg_walker, "MAX_ELEMENTS", 500)
    levels = "".join(f'<g id="l{i + 1}">' + f'<use href="#l{i}"/>' * 10 + "</g>" for i in range(12))
    with pytest.raises(SvgError, match="elements"):
        read_svg(document(f'<rect id="l0" width="5" height="5"/>{levels}'))


@pytest.mark.parametrize(
    "body",
    [
        '<path d="{}"/>'.format("M0 0h1v1z" * 20_000),
        '<path fill-rule="evenodd" d="{}"/>'.format("M0 0h5v5z" * 20_000),
        '<path fill-rule="evenodd" d="{}"/>'.format("M0 0C9 9 0 9 9 0" * 20_000),
        '<rect width="5" height="5" stroke="red" stroke-width="{}1"/>'.format("0" * 200_000),
        '<rect width="5" height="5" fill="rgb({}1)"/>'.format(" " * 200_000),
        "<style>{}</style>".format("/*" * 200_000),
        '<g opacity=".5">{}</g>'.format('<rect width="5" height="5"/>' * 3_000),
        '<rect width="5" height="5"><title>{}</title></rect>'.format("a " * 1_000_000),
    ],
)
def test_much_of_the_same_is_read_quickly(body: str) -> None:
    """Each would take minutes, were time to grow with the square of the length; 20 s leave room for a busy machine."""
    start = time.process_time()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        assert read_svg(document(body)).num_layers <= 3_000
    assert time.process_time() - start < 20


@pytest.mark.parametrize(
    ("body", "words"),
    [
        ("<g>" * 100_000 + "</g>" * 100_000, "nested deeper than 100"),
        ("<b/>" * 100_001, "more than 100000 elements"),
        ('<path d="{}"/>'.format("M0 0h1v1z" * 300_000), "characters of path data"),
        ('<rect width="{}!" height="5"/>'.format("1" * 200_000), "length '111"),
        ("<style>{}</style>{}".format("*{fill:red}" * 5_000, "<g/>" * 5_000), "style rules for too many elements"),
        (
            "".join(f'<g id="a{i}"><use href="#a{i + 1}"/><use href="#a{i + 1}"/></g>' for i in range(40)),
            "more than 100000 elements",
        ),
        ('<svg viewBox="0 0 0 9"/>', "viewBox '0 0 0 9' has no area"),
        ('<symbol id="s" viewBox="0 0 9 -1"/><use href="#s"/>', "viewBox '0 0 9 -1' has no area"),
        ('<rect width="1e400" height="5"/>', "not finite"),
        ('<circle r="NaN"/>', "length 'NaN'"),
        ('<polygon points="0 0 1e400 5 6 7"/>', "not finite"),
        ('<rect width="5" height="5" transform="scale(1e400)"/>', "transform 'scale(1e400)' is not finite"),
    ],
)
def test_too_much_is_refused_quickly(body: str, words: str) -> None:
    start = time.process_time()
    with pytest.raises(SvgError, match=re.escape(words)) as caught:
        read_svg(document(body))
    assert len(str(caught.value)) < 300
    assert time.process_time() - start < 20


def test_a_file_over_the_limit_is_not_read_whole(tmp_path: Path) -> None:
    path = tmp_path / "large.svg"
    with path.open("wb") as stream:
        stream.truncate(10**12)  # takes no space
    with pytest.raises(SvgError, match=r"large\.svg: larger than 50 MB"):
        read_svg(path)


def test_size_limits(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    path = tmp_path / "large.svg"
    path.write_bytes(document('<path d="M1 2H4V6H1z"/>'))
    monkeypatch.setattr(svg_walker, "MAX_PATH_DATA", 5)
    with pytest.raises(SvgError, match="simplify"):
        read_svg(path)
    monkeypatch.setattr(svg_document, "MAX_BYTES", 20)
    with pytest.raises(SvgError, match="larger than"):
        read_svg(path)
