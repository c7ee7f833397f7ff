# SPDX-License-Identifier: Apache-2.0
"""SVGs, made by a grammar or changed bytewise: each is read as a drawing that survives writing, or refused."""

from __future__ import annotations

import dataclasses
import random
from pathlib import Path

import numpy as np

from fuzzing.kind import CHOSEN, EVEN, Kind, one_line
from fuzzing.mutation import mutated
from livecl.drawing.drawing import Drawing
from livecl.errors import SvgError
from livecl.svg import format_svg, read_svg
from livecl.svg.outline_data import MAX_PRECISION
from livecl.svg.writer import quantize

ROOT = Path(__file__).resolve().parents[2]
#: Intact files to be changed.
FILES = [
    path.read_bytes() for folder in ("examples/sources", "tests/svg") for path in sorted((ROOT / folder).glob("*.svg"))
]
#: Deepest nesting written.
DEEPEST = 4
ODD_NUMBERS = (
    *("0", "-0", ".5", "5.", "-.5e1", "1e-9", "1e6", "-1e6", "1e7", "1e300", "1e-300", "1e400", "-1e400", "+3", "007"),
    *("nan", "inf", "1e", "--1", "1.2.3", "0x10", "1_0", "", "١", "999999.999999999", "1" * 30, "9" * 400),
)
NAMES = (
    *("a", "b", "red-circle-left", "background", "stage-2", "x y", "日本", "a&amp;b", "&lt;", "&#9;", "&#x202e;", ""),
    "-" * 200,
)
COLORS = (
    *("red", "#123", "#12345678", "none", "rgb(1,2,3)", "rgb(10% 20% 30% / .5)", "hsl(120,50%,50%)", "currentColor"),
    *(
        "url(#a)",
        "url(#a) blue",
        "transparent",
        "RED",
        "#12",
        "rgb(1e999,0,0)",
        "rgba(0,0,0,-1)",
        "hsl(1e308deg 1% 1%)",
    ),
    *("inherit", ""),
)
UNITS = ("", "", "", "px", "pt", "mm", "%", "Q", "PX")
COMMANDS = {"m": 2, "l": 2, "h": 1, "v": 1, "c": 6, "s": 4, "q": 4, "t": 2, "a": 7, "z": 0}
TRANSFORMS = {"translate": (1, 2), "scale": (1, 2), "rotate": (1, 3), "skewX": (1,), "skewY": (1,), "matrix": (6,)}
SELECTORS = ("*", ".a", "#a", "path.b", "g>a", "@import x;", "g .a ~ path", ":nth-child(2n)", "[id]", "@media print{")
WORDS = {
    "opacity": ("0.5", "50%", "1", "0"),
    "fill-opacity": ("0.5", "50%", "1e-3"),
    "fill-rule": ("evenodd", "nonzero", "other"),
    "id": NAMES,
    "class": ("a", "b", "a b"),
    "display": ("none", "inline"),
    "visibility": ("hidden", "visible"),
    "inkscape:label": (*NAMES, "stage 3", "stage -1", "stage 999999999"),
    "inkscape:groupmode": ("layer",),
    "clip-path": ("url(#a)", "none"),
    "preserveAspectRatio": ("none", "xMinYMax slice", "bogus", ""),
    "viewBox": ("0 0 100 80", "-10,-10,200,100"),
}
ATTRIBUTES = (*WORDS, "transform", "fill", "fill", "style", "stroke", "stroke-width", "width", "height")
LENGTHS = {
    "rect": ("x", "y", "width", "height", "rx", "ry"),
    "circle": ("cx", "cy", "r"),
    "ellipse": ("cx", "cy", "rx", "ry"),
    "use": ("x", "y"),
}
SHAPES = ("path", "path", "path", "rect", "circle", "ellipse", "polygon", "polyline", "line", "use")
GRADIENTS = {
    "linearGradient": ("x1", "y1", "x2", "y2"),
    "radialGradient": ("cx", "cy", "r", "fx", "fy", "fr"),
}
CONTAINERS = ("g", "svg", "symbol", "switch", "a", "defs")
OTHERS = (*CONTAINERS, "g", "style", "text", "image", *GRADIENTS)


class Grammar:
    """Writes documents.

    Parameters
    ----------
    rng : Random
        Source of random numbers.
    odd : float
        Share of the document that breaks the rules, or comes near to it.
    """

    def __init__(self, rng: random.Random, odd: float) -> None:
        self._rng = rng
        self._odd = odd

    def document(self) -> bytes:
        """Return a whole document."""
        space = 'xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" '
        space += 'xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape"'
        size = f'width="{self._length()}" height="{self._length()}"' if self._is_odd() else 'width="100" height="80"'
        if self._is_odd():
            size += f' viewBox="{self._numbers(4)}"'
        body = "".join(self._element() for _ in range(self._rng.randint(0, 5)))
        return f"<svg {space} {size}>{body}</svg>".encode()

    def _is_odd(self) -> bool:
        return self._rng.random() < self._odd

    def _number(self) -> str:
        """Return a number, mostly one that fits the canvas, with few or many digits."""
        if self._is_odd():
            return self._rng.choice(ODD_NUMBERS)
        way = self._rng.random()
        if way < 0.02:
            return repr(self._rng.uniform(-1, 1) * 10 ** self._rng.randint(-12, 4))
        value = self._rng.uniform(-20, 120)
        return str(round(value)) if way < 0.4 else f"{value:.{self._rng.randint(0, 9)}f}"

    def _numbers(self, count: int) -> str:
        return self._rng.choice((" ", ",", " , ")).join(self._number() for _ in range(count))

    def _length(self) -> str:
        return self._number().removeprefix("" if self._is_odd() else "-") + self._rng.choice(UNITS)

    def _path_data(self) -> str:
        """Return commands and their numbers, sometimes too few."""
        rng = self._rng
        parts = [] if self._is_odd() else [f"{rng.choice('Mm')}{self._numbers(2)}"]
        for _ in range(rng.choice((1, 3, 5, 8, 30))):
            command = rng.choice(list(COMMANDS))
            for _ in range(rng.choice((1, 1, 1, 2)) if command != "z" else 1):
                numbers = [self._number() for _ in range(COMMANDS[command] - self._is_odd())]
                if command == "a" and len(numbers) == COMMANDS["a"]:
                    numbers[3:5] = rng.choice("01"), rng.choice("01")
                parts.append(rng.choice((command, command.upper())) + " ".join(numbers))
        return rng.choice(("", " ", "\n")).join(parts)

    def _transform(self) -> str:
        words = []
        for _ in range(self._rng.randint(1, 3)):
            name = "spin" if self._is_odd() else self._rng.choice(list(TRANSFORMS))
            count = self._rng.choice(TRANSFORMS.get(name, (1, 2))) + self._is_odd()
            small = [
                self._rng.choice((self._number(), f"{self._rng.uniform(-3, 3):.2f}", "0", "1")) for _ in range(count)
            ]
            words.append(f"{name}({self._rng.choice((' ', ',')).join(small)})")
        return self._rng.choice(("", " ", ",")).join(words)

    def _attribute(self, name: str) -> str:
        """Return a value of an attribute that any element may have."""
        rng = self._rng
        if name in WORDS and not self._is_odd():
            return rng.choice(WORDS[name])
        if name == "transform":
            return self._transform()
        if name == "style":
            ending = rng.choice(("", "!important", ";;:", ";x"))
            return f"fill:{rng.choice(COLORS)};opacity:{self._number()}{ending}"
        if name == "viewBox":
            return self._numbers(4)
        if name in ("fill", "stroke"):
            return rng.choice(COLORS)
        return self._length()

    def _attributes(self) -> dict[str, str]:
        rng = self._rng
        return {name: self._attribute(name) for name in rng.sample(ATTRIBUTES, rng.choice((0, 1, 2, 3, 6)))}

    def _gradient(self, tag: str) -> str:
        """Return a gradient with its stops, which may take others' by reference."""
        rng = self._rng
        own = {name: self._length() for name in GRADIENTS[tag] if rng.random() < 0.5}
        own |= {"id": rng.choice(NAMES[:3]), "spreadMethod": rng.choice(("pad", "reflect", "repeat", "other"))}
        if rng.random() < 0.5:
            own["gradientUnits"] = rng.choice(("userSpaceOnUse", "objectBoundingBox", ""))
        if rng.random() < 0.3:
            own["gradientTransform"] = self._transform()
        if rng.random() < 0.3:
            own["href"] = f"#{rng.choice(NAMES[:3])}"
        stops = "".join(
            f'<stop offset="{self._length()}" stop-color="{rng.choice(COLORS)}" stop-opacity="{self._number()}"/>'
            for _ in range(rng.choice((0, 1, 2, 2, 3, 9)))
        )
        written = "".join(f' {name}="{value}"' for name, value in own.items())
        return f"<{tag}{written}>{stops}</{tag}>"

    def _element(self, depth: int = 0) -> str:
        """Return an element with its content."""
        rng = self._rng
        tag = rng.choice(SHAPES + (OTHERS if depth < DEEPEST else ()))
        if tag == "style":
            rules = (f"{rng.choice(SELECTORS)}{{fill:{rng.choice(COLORS)}}}" for _ in range(3))
            return f"<style>{''.join(rules)}</style>"
        if tag in GRADIENTS:
            return self._gradient(tag)
        own = {name: self._length() for name in LENGTHS.get(tag, ()) if rng.random() < 0.9} | self._attributes()
        if tag == "path" and not self._is_odd():
            own["d"] = self._path_data()
        elif tag in ("polygon", "polyline"):
            own["points"] = self._numbers(rng.randint(0, 11))
        elif tag == "use":
            file = "other.svg" if self._is_odd() else ""
            own[rng.choice(("href", "xlink:href"))] = f"{file}#{rng.choice(NAMES)}"
        inside = f"<title>{rng.choice(NAMES)}</title>" if rng.random() < 0.1 else ""
        if tag in CONTAINERS:
            inside += "".join(self._element(depth + 1) for _ in range(rng.randint(0, 4)))
        written = "".join(f' {name}="{value}"' for name, value in own.items())
        return f"<{tag}{written}>{inside}</{tag}>"


def make(rng: random.Random) -> bytes:
    """Return a document by the grammar, or, for three in ten, one that was changed bytewise."""
    made = Grammar(rng, rng.choice((0.0, 0.0, 0.003, 0.05))).document()
    if rng.random() < 0.7:
        return made
    return mutated(rng, made if rng.random() < 0.5 else rng.choice(FILES), FILES)


def check(data: bytes) -> str:
    """Read it; a drawing has to survive writing and reading, at any precision."""
    try:
        drawing = read_svg(data)
    except SvgError as error:
        one_line(error)
        return "refused"
    rng = random.Random(data)
    precision = rng.randint(0, MAX_PRECISION)
    style = rng.choice(("inkscape", "plain"))
    text = format_svg(drawing, precision, style)  # type: ignore[arg-type]  # one of the two
    again = read_svg(text.encode())
    # Where a drawing has groups of its own, these are written, and not its stages.
    same(quantize(drawing, precision), again, with_stages=style == "inkscape" and not any(drawing.groups))
    assert format_svg(again, precision, style) == text, "written again, it is other text"  # type: ignore[arg-type]
    return "read" if drawing.num_layers else "read, empty"


def same(wanted: Drawing, got: Drawing, *, with_stages: bool) -> None:
    """Raise AssertionError unless two drawings are equal."""
    assert got.size == wanted.size, (got.size, wanted.size)
    for name in (
        "points",
        "colors",
        "background",
        "subpath_offsets",
        "layer_offsets",
        *(["stages"] if with_stages else []),
    ):
        one, other = getattr(wanted, name), getattr(got, name)
        assert (one is None) == (other is None) and (one is None or np.array_equal(one, other)), f"{name} changed"
    for field in dataclasses.fields(wanted.fills):
        one, other = getattr(wanted.fills, field.name), getattr(got.fills, field.name)
        assert np.array_equal(one, other), f"fills.{field.name} changed"
    assert got.labels == wanted.labels, (got.labels, wanted.labels)


KIND = Kind(cases=CHOSEN.map(make), others=EVEN.map(make), check=check, suffix=".svg")
