# SPDX-License-Identifier: Apache-2.0
"""Options on the command line: every field of `Options` a flag, presets, files of options, and which of them wins."""

from __future__ import annotations

import dataclasses
import subprocess
import sys
from pathlib import Path
from typing import Any, get_args, get_type_hints

import pytest

from livecl.cli import command as cli
from livecl.cli.arguments import build_parser, parse_arguments
from livecl.cli.request import recipe_of
from livecl.options import PRESET_PATHS, PRESETS, Options
from livecl.run.recipe import Recipe


def recipe(*arguments: str) -> Recipe:
    return recipe_of(parse_arguments(arguments))


def shown(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    """Return what --show-options prints."""
    assert cli.main([*arguments, "--show-options"]) == 0
    captured = capsys.readouterr()
    assert captured.err == ""
    return captured.out


def another_value(field: dataclasses.Field[Any]) -> tuple[list[str], Any]:
    """Return arguments that set a field to another value than its default, and that value."""
    hint, flag = get_type_hints(Options)[field.name], f"--{field.name.replace('_', '-')}"
    if hint is bool:
        return [flag.replace("--", "--no-") if field.default else flag], not field.default
    if hint is str:
        return [flag, "#102030"], "#102030"
    if get_args(hint):
        value = next(value for value in get_args(hint) if value != field.default)
        return [flag, value], value
    value = hint(field.default + 3)
    return [flag, str(value)], value


@pytest.mark.parametrize("field", dataclasses.fields(Options), ids=lambda field: field.name)
def test_every_field_is_a_flag(field: dataclasses.Field[Any]) -> None:
    words, value = another_value(field)
    # A shape of its own, as random placement has no outline to fit; no revisions and no regions, as variant wants it.
    others = {"variant": ["--placement", "component", "--revisions", "0"]}.get(field.name, [])
    assert getattr(recipe(*words, *others).options, field.name) == value


def test_every_flag_says_what_its_field_says(capsys: pytest.CaptureFixture[str]) -> None:
    described = [field.metadata["help"].replace("`", "") for field in dataclasses.fields(Options)]
    assert len(set(described)) == len(described)  # no two say the same
    with pytest.raises(SystemExit):
        cli.main(["--help"])
    text = " ".join(capsys.readouterr().out.split())
    assert all(f"{description} (default: " in text for description in described)


def test_help_needs_no_docstrings() -> None:
    words = [sys.executable, "-OO", "-m", "livecl", "--help"]
    done = subprocess.run(words, capture_output=True, text=True, timeout=60, check=True)
    assert "Reach of the distance weight, px (default: 10.0)" in " ".join(done.stdout.split())


@pytest.mark.parametrize("preset", PRESETS)
def test_presets_are_named_options(preset: str) -> None:
    made = recipe("--preset", preset)
    assert made.options == PRESETS[preset]()
    assert sum(made.stages) == PRESET_PATHS.get(preset, 256)
    assert sum(recipe("--preset", preset, "--paths", "5").stages) == 5
    assert recipe("--preset", preset, "--iterations", "9").options.iterations == 9


@pytest.mark.parametrize(
    "arguments",
    [
        [],
        ["--preset", "paper", "--tau", "7.5", "--paths", "12", "--seed", "4", "--no-untangle"],
        ["--preset", "diffvg", "--size", "full", "--precision", "1", "--layers", "plain", "--background", "#102030"],
        ["--paths", "auto", "--preset", "photo", "--prune", "1e-7"],
        ["--schedule", "1,2,1", "--placement", "random"],
    ],
)
def test_options_shown_read_back(tmp_path: Path, capsys: pytest.CaptureFixture[str], arguments: list[str]) -> None:
    file = tmp_path / "options.toml"
    file.write_text(shown(capsys, *arguments))
    assert shown(capsys, "--config", str(file)) == file.read_text(encoding="utf-8")
    assert recipe("--config", str(file)).fingerprint == recipe(*arguments).fingerprint


def test_options_of_the_run_are_shown_where_given(capsys: pytest.CaptureFixture[str]) -> None:
    assert "device" not in shown(capsys)
    assert 'device = "0"\nthreads = 2\n' in shown(capsys, "--device", "0", "--threads", "2")


def test_the_command_line_comes_before_the_file(tmp_path: Path) -> None:
    file = tmp_path / "some.toml"
    file.write_text(
        'preset = "paper"\nschedule = [1, 2]\ntau = 3.5\nuntangle = true\nseed = 5\nsize = "full"\nredo = true\n'
    )
    config = ["--config", str(file)]
    made = recipe(*config)
    assert (made.options.tau, made.options.untangle, made.options.iterations) == (3.5, True, 500)
    assert (made.stages, made.seed, made.size) == ((1, 2), 5, 0)
    assert parse_arguments(config).redo
    made = recipe(*config, "--tau", "4", "--no-untangle", "--seed", "0", "--paths", "2", "--size", "512")
    assert (made.options.tau, made.options.untangle) == (4.0, False)
    assert (made.stages, made.seed, made.size) == ((1, 1), 0, 512)
    assert not parse_arguments([*config, "--no-redo"]).redo
    assert recipe(*config, "--preset", "default").options.iterations == 200


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("paht = 8", "no option 'paht'; did you mean 'paths'?"),
        ("output = 'out.svg'", "no option 'output'"),
        ("paths = 0", "argument --paths: got '0', wanted a whole number of at least 1"),
        ("tau = 0", "argument --tau: got '0', wanted a positive number"),
        ("tau = true", "tau: got true, wanted a number or text"),
        ("untangle = 1", "untangle: got 1, wanted true or false"),
        ("loss = 'l1'", "argument --loss: invalid choice: 'l1'"),
        ("tau = nan", "argument --tau: got 'nan', wanted a number of at least 0"),
        ("seed = -1", "argument --seed: got '-1'"),
        ("tau = '\\x'", "argument --tau: got '\\\\x', wanted a number of at least 0"),
    ],
)
def test_files_are_refused_by_name(tmp_path: Path, capsys: pytest.CaptureFixture[str], text: str, message: str) -> None:
    file = tmp_path / "some.toml"
    file.write_text(text)
    assert cli.main(["in.png", "-o", "out.svg", "--config", str(file)]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith(f"livecl: error: {file}: {message}")
    assert captured.err.count("\n") == 1


def test_a_file_may_set_what_is_no_file() -> None:
    settings = build_parser().settings
    assert {"preset", "paths", "schedule", "size", "precision", "seed", "device", "workers", "tau"} < set(settings)
    assert not {"inputs", "output", "json", "stages", "start", "config", "help", "version"} & set(settings)
