# SPDX-License-Identifier: Apache-2.0
"""Hostile and broken SVG: refused with a clear error, or read, within seconds."""

from __future__ import annotations

import re
import time
import warnings
import zlib
from pathlib import Path

import pytest

from livecl.errors import SvgError
from livecl.svg import document as svg_document
from livecl.svg import read_svg
from livecl.svg import selectors as svg_selectors
from livecl.svg import walker as svg_walker


def document(body: str) -> bytes:
    return f'<svg xmlns="http://www.w3.org/2000/svg" width="100" height="100">{body}</svg>'.encode()


@pytest.mark.parametrize(
    ("body", "words"),
    [
        ('<path d="M0 0L1e400 3 5 5z"/>', "not finite"),
        ('<path d="M0 0L3 3L-1e309 5z"/>', "not finite"),
        ('<rect width="abc" height="5"/>', "length 'abc'"),
        ('<rect width="1e999" height="5"/>', "not finite"),
        ('<rect width="5" height="5" transform="matrix(1 2)"/>', "transform 'matrix(1 2)'"),
        ('<rect width="5" height="5" transform="spin(3)"/>', "transform 'spin(3)'"),
        ('<g transform="scale(1e300)"><rect width="1e300" height="5"/></g>', "not finite"),
        ('<rect width="1e7" height="5"/>', "within"),
        ('<use href="other.svg#a"/>', "outside the file"),
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
        (b'<svg width="0" height="5"/>', "nothing of it is shown"),
        (b'<svg width="-5" height="5"/>', "negative"),
        (b'<svg width="1e6" height="2"/>', "32768"),
        (b'<svg viewBox="0 0 0 5"/>', "viewBox"),
        (b'<svg viewBox="0 0 nan 5"/>', "viewBox"),
        (b'<svg viewBox="1 2 3"/>', "viewBox"),
        (b'<!DOCTYPE svg [<!ENTITY a SYSTEM "file:///etc/passwd">]><svg width="9" height="9">&a;</svg>', "entities"),
        (b'<!DOCTYPE svg [<!ENTITY % a SYSTEM "http://localhost/x">%a;]><svg/>', "entities"),
        (b'<!DOCTYPE svg [<!ENTITY a "&b;"><!ENTITY b "&a;">]><svg width="9" height="9">&a;</svg>', "nest deeper"),
        ('<!DOCTYPE svg [<!ENTITY a "&a;">]><svg width="9" height="9">&a;</svg>'.encode("utf-16"), "nest deeper"),
        (
            b'<!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" "http://www.w3.org/Graphics/SVG/1.1/DTD/svg11.dtd">'
            b'<svg width="9" height="9"><path d="&a;"/></svg>',
            "entity 'a', which it does not declare",
        ),
        (b'<!DOCTYPE svg [<!ATTLIST svg width CDATA "%s">]><svg/>' % (b"1" * 300), "default values"),
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


def test_bombs_of_entities_are_refused() -> None:
    """Ten references to ten references ...: 10^10 characters of nine lines, in text and in an attribute."""
    levels = "".join(f'<!ENTITY a{i + 1} "{f"&a{i};" * 10}">' for i in range(7))
    doctype = f'<!DOCTYPE svg [<!ENTITY a0 "{"x" * 1000}">{levels}]>'
    for body in ("<g>&a7;</g>", '<g id="&a7;"/>', '<g id="{}"/>'.format("&a3;" * 10), "&a3;" * 10):
        start = time.process_time()
        with pytest.raises(SvgError, match="entities expand to more than 5000000 characters"):
            read_svg(f'{doctype}<svg width="9" height="9">{body}</svg>'.encode())
        assert time.process_time() - start < 5
    many = "".join(f'<!ENTITY a{i} "b">' for i in range(501))
    with pytest.raises(SvgError, match="more than 500 XML entities"):
        read_svg(f'<!DOCTYPE svg [{many}]><svg width="9" height="9"/>'.encode())


@pytest.mark.parametrize("part", ["<!--", "<![CDATA[", "&a;", "&", "<!-- -->"])
def test_references_are_counted_quickly(part: str) -> None:
    start = time.process_time()
    doctype = '<!DOCTYPE svg [<!ENTITY a "">]>'
    try:
        read_svg(f'{doctype}<svg width="9" height="9"><g>{part * 500_000}</g></svg>'.encode())
    except SvgError as error:
        assert "not a whole XML document" in str(error)
    assert time.process_time() - start < 10


def test_bombs_of_selectors_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """A chain of descendants looks at depth to the power of its length; :has() at all siblings of each element."""
    monkeypatch.setattr(svg_selectors, "MAX_COMPARISONS", 200_000)
    deep = "<g>" * 90 + '<rect width="5" height="5"/>' + "</g>" * 90
    for sheet, body in (("a " + "g " * 12 + "rect{fill:red}", deep), ("g:has(~a){fill:red}", "<g/>" * 5000)):
        start = time.process_time()
        with pytest.raises(SvgError, match="style rules for too many elements"):
            read_svg(document(f"<style>{sheet}</style>{body}"))
        assert time.process_time() - start < 20
    for sheet in (":not(" * 500 + "g" + ")" * 500 + "{fill:red}", "g{fill:" + "(" * 90_000):
        with pytest.raises(SvgError, match="brackets nested deeper"):
            read_svg(document(f"<style>{sheet}</style>{deep}"))
    with pytest.warns(UserWarning, match=r"style rules \(2\)"):
        read_svg(document(f"<style>{'g>' * 5000}g{{}} {':is(g)' * 999}{{}}</style>{deep}"))


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
        ('<path d="{}"/>'.format("M0 0h1v1z" * 600_000), "characters of path data"),
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


def test_compressed_bombs_are_refused() -> None:
    """10^9 spaces in a million bytes: not a byte more than the limit is unpacked."""
    compressor = zlib.compressobj(9, wbits=zlib.MAX_WBITS | 16)
    blocks = [compressor.compress(b" " * 10**7) for _ in range(100)]
    with pytest.raises(SvgError, match="larger than 50 MB"):
        read_svg(b"".join(blocks) + compressor.flush())


def test_size_limits(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    path = tmp_path / "large.svg"
    path.write_bytes(document('<path d="M1 2H4V6H1z"/>'))
    monkeypatch.setattr(svg_walker, "MAX_PATH_DATA", 5)
    with pytest.raises(SvgError, match="simplify"):
        read_svg(path)
    monkeypatch.setattr(svg_document, "MAX_BYTES", 20)
    with pytest.raises(SvgError, match="larger than"):
        read_svg(path)
