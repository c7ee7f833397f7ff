# SPDX-License-Identifier: Apache-2.0
"""SVG path data to closed cubic subpaths.

A subpath is (n, 4, 2): its cubics' control points, each starting where the one before it ends, the last ending at the
start of the first. Lines and quadratics are raised to cubics, which is exact. Arcs are cut into pieces of at most 90
degrees, each a cubic at most 2.8e-4 of the radius away. Points are complex numbers x + iy for speed: a path may have
some hundred thousand segments.
"""

from __future__ import annotations

import cmath
import itertools
import math
import re

import numpy as np

from livecl.arrays import FloatArray

#: Control points as complex numbers x + iy.
Cubic = tuple[complex, complex, complex, complex]

#: Patterns of a number of SVG, and of a number or an arc's flag after another one.
NUMBER = r"[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?"
_NUMBER = re.compile(NUMBER)
_NEXT = re.compile(rf"[ \t\r\n\f]*,?[ \t\r\n\f]*({NUMBER})")
_NEXT_FLAG = re.compile(r"[ \t\r\n\f]*,?[ \t\r\n\f]*([01])")
_TWO_COMMAS = re.compile(r",[ \t\r\n\f]*,")
_SPACE = " \t\r\n\f"
_COMMANDS = re.compile(r"([MmLlHhVvCcSsQqTtAaZz])([^MmLlHhVvCcSsQqTtAaZz]*)")
_ARITY = {"M": 2, "L": 2, "H": 1, "V": 1, "C": 6, "S": 4, "Q": 4, "T": 2, "A": 7, "Z": 0}
_CSS_PATH = re.compile(r"""path\(\s*(["'])(.*)\1\s*\)""", re.DOTALL)


def plain_data(text: str) -> str:
    """Return path data, unwrapped from CSS's ``path("...")``."""
    match = _CSS_PATH.fullmatch(text.strip()) if text.lstrip().startswith("path") else None
    return match[2] if match else text


def path_outline(data: str) -> tuple[list[FloatArray], bool]:
    """Return the closed subpaths of path data, up to the first error (SVG 1.1, F.2), and whether there was none.

    Subpaths of a single point or line, which enclose nothing, are dropped. Raises ValueError if `data` holds numbers
    that are not finite.
    """
    pen = _Pen()
    whole = _draw(pen, data)
    return pen.outline, whole


def path_lines(data: str) -> tuple[list[FloatArray], list[bool], bool]:
    """Return the subpaths of path data for stroking: open unless closed by the data.

    Returns
    -------
    lines : list of (n, 4, 2)
        Cubics of each subpath; a closed one ends at its start. A subpath of no length has one cubic.
    is_open : list of bool
        Whether each is open.
    whole : bool
        Whether there was no error, as in :func:`path_outline`.
    """
    pen = _StrokingPen()
    whole = _draw(pen, data)
    return pen.outline, pen.is_open, whole


def _draw(pen: _Pen, data: str) -> bool:
    """Draw path data up to the first error, and return whether there was none."""
    data = data.strip(_SPACE)
    if data in ("", "none"):
        return True
    if data[0] not in "Mm":
        return False
    end = 0
    for match in _COMMANDS.finditer(data):
        if match.start() != end:
            break  # text between two commands
        end = match.end()
        numbers, whole = number_list(match[2]) if match[1] not in "Aa" else _arc_numbers(match[2])
        arity = _ARITY[match[1].upper()]
        count = len(numbers) // arity if arity else 0
        if not all(map(math.isfinite, numbers)):
            raise ValueError("path data holds a number that is not finite")
        if arity:
            pen.draw(match[1], [numbers[i * arity : (i + 1) * arity] for i in range(count)])
        else:
            pen.close()
        if not whole or len(numbers) != count * arity or (arity and not count):
            end = -1
            break
    pen.finish()
    if not all(np.isfinite(subpath).all() for subpath in pen.outline):
        raise ValueError("path data holds a number that is not finite")
    return end == len(data)


def number_list(text: str) -> tuple[list[float], bool]:
    """Return the numbers of a list, separated by spaces or single commas, up to an error, and whether none occurred."""
    text = text.strip(_SPACE)
    rest = _NUMBER.sub("", text)
    if not rest.strip(_SPACE + ",") and text[:1] != "," and text[-1:] != "," and not _TWO_COMMAS.search(text):
        return list(map(float, _NUMBER.findall(text))), True
    numbers: list[float] = []
    position = 0
    while match := (_NEXT if numbers else _NUMBER).match(text, position):
        numbers.append(float(match[1] if numbers else match[0]))
        position = match.end()
    return numbers, False


def _arc_numbers(text: str) -> tuple[list[float], bool]:
    """Return the numbers of arcs, whose flags need no separator, as `number_list` does."""
    text = text.strip(_SPACE)
    if text[:1] == ",":
        return [], False
    numbers: list[float] = []
    position = 0
    while match := (_NEXT_FLAG if len(numbers) % 7 in (3, 4) else _NEXT).match(text, position):
        numbers.append(float(match[1]))
        position = match.end()
    return numbers, position == len(text)


class _Pen:
    """Draws commands into closed subpaths, each ended by a line where it does not end at its start.

    Attributes
    ----------
    outline : list of (n, 4, 2)
        The subpaths finished so far.
    """

    def __init__(self) -> None:
        self.outline: list[FloatArray] = []
        self._cubics: list[Cubic] = []
        self._num_lines = self._num_drawn = 0
        self._start = self._point = self._control = 0j
        self._before = ""

    def draw(self, command: str, groups: list[list[float]]) -> None:
        """Draw a command's groups of numbers; those after the first of a move are lines."""
        kind = command.upper()
        for numbers in groups:
            origin = self._point if command.islower() else 0j
            if kind == "H":
                ends = [complex(numbers[0] + origin.real, self._point.imag)]
            elif kind == "V":
                ends = [complex(self._point.real, numbers[0] + origin.imag)]
            elif kind == "A":
                ends = [origin + complex(numbers[5], numbers[6])]
            else:
                ends = [origin + complex(*numbers[i : i + 2]) for i in range(0, len(numbers), 2)]
            if kind == "M":
                self.finish()
                self._start = self._point = ends[0]
                self._before = kind = "L"
                continue
            self._num_drawn += 1
            if kind in "CSQT":
                self._curve(kind, ends)
            elif kind == "A" and ends[0] != self._point and numbers[0] and numbers[1]:
                self._cubics.extend(_arc(self._point, numbers, ends[0]))
            elif ends[0] != self._point:
                self._cubics.append(line_cubic(self._point, ends[0]))
                self._num_lines += 1
            self._point = ends[-1]
            self._before = kind

    def _curve(self, kind: str, ends: list[complex]) -> None:
        point, end = self._point, ends[-1]
        if kind in "CS":
            reflected = 2 * point - self._control if self._before in ("C", "S") else point
            first = ends[0] if kind == "C" else reflected
            self._control = ends[-2]
            self._cubics.append((point, first, self._control, end))
        else:
            reflected = 2 * point - self._control if self._before in ("Q", "T") else point
            self._control = control = ends[0] if kind == "Q" else reflected
            self._cubics.append((point, point + 2 / 3 * (control - point), end + 2 / 3 * (control - end), end))

    def close(self) -> None:
        """Close the subpath; the next one begins at its start unless a move follows."""
        self.finish(closed=True)
        self._point, self._before = self._start, "Z"

    def finish(self, closed: bool = False) -> None:
        """Close the subpath since the last move, even if the data does not, and keep it unless it encloses nothing."""
        cubics, start, point = self._cubics, self._start, self._point
        if cubics:
            if _meet(start, point):
                cubics[-1] = (*cubics[-1][:3], start)
            else:
                cubics.append(line_cubic(point, start))
                self._num_lines += 1
            if self._num_lines < len(cubics) or self._num_lines > 2:
                self.outline.append(control_points(cubics))
        self._begin()

    def _begin(self) -> None:
        """Begin the next subpath at the start of this one."""
        self._cubics = []
        self._num_lines = self._num_drawn = 0
        self._point = self._start


class _StrokingPen(_Pen):
    """Draws commands into lines, open where the data does not close them, for strokes.

    Attributes
    ----------
    is_open : list of bool
        Whether each of the finished subpaths is open.
    """

    def __init__(self) -> None:
        super().__init__()
        self.is_open: list[bool] = []

    def finish(self, closed: bool = False) -> None:
        """Keep the subpath since the last move, unless nothing was drawn since then."""
        cubics, start, point = self._cubics, self._start, self._point
        if closed and cubics and _meet(start, point):
            cubics[-1] = (*cubics[-1][:3], start)
        elif closed and cubics:
            cubics.append(line_cubic(point, start))
        if cubics or closed or self._num_drawn:
            self.outline.append(control_points(cubics or [line_cubic(start, start)]))
            self.is_open.append(not closed)
        self._begin()


def _meet(start: complex, point: complex) -> bool:
    """Whether a point is the start of its subpath, up to rounding in sums of relative coordinates."""
    scale = max(1.0, abs(start.real), abs(start.imag))
    return max(abs((point - start).real), abs((point - start).imag)) <= 1e-6 * scale


def line_cubic(a: complex, d: complex) -> Cubic:
    """Return a line as a cubic."""
    return a, a + (d - a) / 3, d - (d - a) / 3, d


def control_points(cubics: list[Cubic]) -> FloatArray:
    """Return cubics of complex numbers as control points: (n, 4, 2)."""
    numbers = np.array(cubics)
    return np.stack([numbers.real, numbers.imag], axis=-1)


def _arc(start: complex, numbers: list[float], end: complex) -> list[Cubic]:
    """Return the cubics of an elliptical arc, from its end points to its centre (SVG 1.1, F.6.5 and F.6.6).

    In the frame where the ellipse is the unit circle, with h half the chord, the centre lies sqrt(1 / |h|^2 - 1) h,
    turned by a right angle, from the chord's middle; radii too small for the chord are scaled up until it fits.
    """
    rx, ry, turn, large, sweep = abs(numbers[0]), abs(numbers[1]), math.radians(numbers[2]), numbers[3], numbers[4]
    unturned = [point * cmath.exp(-1j * turn) for point in (start, end)]
    half = complex((unturned[1] - unturned[0]).real / rx, (unturned[1] - unturned[0]).imag / ry) / 2
    if (size := abs(half)) > 1:
        rx, ry, half = rx * size, ry * size, half / size
    p, q = (complex(point.real / rx, point.imag / ry) for point in unturned)
    beside = math.sqrt(max(0.0, 1 / abs(half) ** 2 - 1)) if half else 0.0
    center = (p + q) / 2 + half * beside * (1j if bool(large) != bool(sweep) else -1j)
    first, last = cmath.phase(p - center), cmath.phase(q - center)
    angle = (last - first) % (2 * math.pi)
    if not sweep:
        angle -= 2 * math.pi
    count = max(1, math.ceil(abs(angle) / (math.pi / 2) - 1e-9))
    handle = 4 / 3 * math.tan(angle / count / 4)
    on_circle = [cmath.exp(1j * (first + angle * i / count)) for i in range(count + 1)]
    cubics = []
    for a, d in itertools.pairwise(on_circle):
        circle = [center + point for point in (a, a + handle * 1j * a, d - handle * 1j * d, d)]
        cubics.append([complex(point.real * rx, point.imag * ry) * cmath.exp(1j * turn) for point in circle])
    cubics[0][0], cubics[-1][3] = start, end
    return [(a, b, c, d) for a, b, c, d in cubics]
