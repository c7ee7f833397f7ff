# SPDX-License-Identifier: Apache-2.0
"""Options from Python, the command line and files: each is accepted, or refused in a line that names it."""

from __future__ import annotations

import contextlib
import dataclasses
import io
import json
import math
import random
import tempfile
from pathlib import Path
from typing import Any, get_args, get_type_hints

from fuzzing.kind import CHOSEN, EVEN, Kind, one_line
from fuzzing.mutation import mutated
from livecl.cli import command as cli
from livecl.cli.arguments import build_parser
from livecl.options import PRESETS, Options
from livecl.run.recipe import Recipe
from livecl.schedule import parse_schedule

FIELDS = get_type_hints(Options)
#: Values of any type, as given by mistake.
ODD_VALUES = (
    *(0, 1, 2, -1, 3, 1.0, 0.5, -0.0, 1e-320, 1e308, math.nan, math.inf, -math.inf, 2**31, 2**64, 10**400, True, False),
    *(None, "", "1", "auto", "exp", "nan", "white", "#12", "#123456", "none", "picture", "日本", "x" * 1000, "\0\n"),
    *(b"1", [], [1], (1, 2), {}, {"a": 1}, {1}, 1j, object, range(3), [[1]], [math.nan], [10**400], ["1", 2.0]),
)
SCHEDULES = ("exp", "1,1,2", "1,,2", "0", "-1,2", "1.5", "1," * 200, "1_0", [1, 2], (3,), [1.5], [10**6], *ODD_VALUES)
WORDS = (
    *("1", "0", "-1", "8", "1,1,2", "exp", "auto", "full", "0.5", "nan", "1e999", "white", "mse", "no", "日本", "１"),
    *("1_0", "\udcff", "%s", "--", "-", "=", "😀", "", " ", "\n", "\x7f", "a" * 2000, "9" * 5000),
)

Case = tuple[str, Any]


def value_for(rng: random.Random, hint: Any) -> Any:
    """Return a value of the wanted type, or, for one in five, any other."""
    if rng.random() < 0.2:
        return rng.choice(ODD_VALUES)
    if choices := get_args(hint):
        return rng.choice(choices)
    if hint is bool:
        return rng.random() < 0.5
    if hint is int:
        return rng.choice((1, 2, 10, rng.randint(-2, 1000)))
    if hint is float:
        return rng.choice((0.0, 0.5, 1, rng.uniform(-1, 100), 10 ** rng.uniform(-300, 300)))
    return rng.choice(("white", "#123456", "none", "auto", "train", "picture", "rgb(1,2,3)", "no colour"))


def fields(rng: random.Random) -> dict[str, Any]:
    """Return values of a few fields."""
    return {name: value_for(rng, FIELDS[name]) for name in rng.sample(list(FIELDS), rng.choice((1, 1, 2, 4)))}


def make_recipe(rng: random.Random) -> dict[str, Any]:
    """Return arguments of a recipe."""
    arguments = {
        "paths": value_for(rng, int),
        "schedule": rng.choice(SCHEDULES),
        "seed": value_for(rng, int),
        "size": value_for(rng, int),
        "precision": value_for(rng, int),
        "layers": rng.choice(("inkscape", "plain", *ODD_VALUES)),
        "lock": rng.choice(((), [0], (1,), *ODD_VALUES)),
    }
    return {name: arguments[name] for name in rng.sample(list(arguments), rng.choice((1, 2, 3)))}


def command_line(rng: random.Random) -> list[str]:
    """Return arguments, most of them known."""
    actions = [
        action
        for action in build_parser()._actions
        if action.option_strings and action.dest not in ("help", "version", "list_devices", "config", "start")
    ]
    words: list[str] = []
    for _ in range(rng.choice((1, 2, 3, 6))):
        action = rng.choice(actions)
        option = rng.choice(action.option_strings)
        if rng.random() < 0.05:
            option = rng.choice(("--nothing", option[:-1], option + "x", "-xyz"))
        value = str(rng.choice(list(action.choices))) if action.choices and rng.random() < 0.7 else rng.choice(WORDS)
        joined = rng.random() < 0.5 and value != "--"  # of "--option=--", argparse makes an empty list
        words += [option] if action.nargs == 0 else [f"{option}={value}"] if joined else [option, value]
    return words


def config(rng: random.Random) -> bytes:
    """Return a file of options, a third of them changed bytewise."""
    lines = []
    for name in rng.sample(list(FIELDS), rng.randint(0, 5)):
        value = value_for(rng, FIELDS[name])
        try:
            written = json.dumps(value)
        except TypeError:
            written = "2020-01-01"
        lines.append(f"{name if rng.random() < 0.95 else name[:-1]} = {written}\n")
    data = "".join(lines).encode("utf-8", "surrogatepass")
    return mutated(rng, data, [data, b"[table]\na = 1\n"]) if rng.random() < 0.3 and data else data


def make(rng: random.Random) -> Case:
    """Return a maker of `_MAKERS`, and its arguments."""
    maker = rng.choice(list(_MAKERS))
    return maker, _MAKERS[maker](rng)


_MAKERS: dict[str, Any] = {
    "Options": fields,
    "preset": lambda rng: (rng.choice(list(PRESETS)), fields(rng)),
    "Recipe": make_recipe,
    "schedule": lambda rng: (make_recipe(rng).get("schedule"), value_for(rng, int)),
    "command line": command_line,
    "file": config,
}


def check(case: Case) -> str:
    """Make it; a refusal has to be a ValueError of one line, or exit code 2."""
    maker, of = case
    if maker == "command line":
        return _checked_command(of)
    if maker == "file":
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "options.toml"
            file.write_bytes(of)
            return _checked_command([f"--config={file}"])
    try:
        if maker == "Options":
            _repeats(Options(**of))
        elif maker == "preset":
            _repeats(PRESETS[of[0]](**of[1]))
        elif maker == "Recipe":
            assert Recipe(**of).fingerprint
        else:
            stages = parse_schedule(*of)
            assert stages and min(stages) >= 1 and all(type(stage) is int for stage in stages), stages
    except ValueError as error:
        one_line(error)
        return f"{maker} refused"
    return f"{maker} taken"


def _repeats(options: Options) -> None:
    """Raise AssertionError unless the values of options make the same options."""
    assert Options(**dataclasses.asdict(options)) == options


def _checked_command(words: list[str]) -> str:
    """Show options; those shown must be accepted, and shown the same way again."""
    code, shown, said = _ran([*words, "--show-options"])
    if code == 2:
        line = said.removesuffix("\n")
        assert line.startswith("livecl: error: ") and line.isprintable(), f"said {said!r:.300}"
        return "command line refused"
    assert code == 0, f"exit code {code}"
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "shown.toml"
        file.write_text(shown, encoding="utf-8")
        again = _ran([f"--config={file}", "--show-options"])
    assert again[:2] == (0, shown), f"{shown!r:.200} gives {again!r:.300}"
    return "command line taken"


def _ran(words: list[str]) -> tuple[int, str, str]:
    """Return the command's exit code and what it writes."""
    out, err = io.TextIOWrapper(io.BytesIO(), encoding="utf-8"), io.StringIO()  # the command writes bytes, too
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = cli.main(words)
        out.flush()
    return code, out.buffer.getvalue().decode(), err.getvalue()


KIND = Kind(cases=CHOSEN.map(make), others=EVEN.map(make), check=check)
