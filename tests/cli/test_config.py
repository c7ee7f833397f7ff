# SPDX-License-Identifier: Apache-2.0
"""Options in TOML: files read back equal, and errors are named."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from livecl.cli.config import format_config, read_config

KNOWN = ["paths", "xing_weight", "loss", "untangle", "schedule"]


@pytest.mark.parametrize(
    "values",
    [
        {},
        {"paths": 8, "xing_weight": 1e-06, "loss": "mse", "untangle": False, "schedule": [1, 2, 4]},
        {"paths": -3, "xing_weight": 2.5e300, "loss": 'quoted "text" \\ ü \n \x01', "untangle": True},
        {"loss": "\U0001f600 \x7f"},  # JSON writes the one as a pair, which TOML has not, and the other as it is
    ],
)
def test_round_trip(tmp_path: Path, values: dict[str, Any]) -> None:
    file = tmp_path / "some.toml"
    file.write_text(format_config(values), encoding="utf-8")
    assert read_config(file, KNOWN) == values


def test_none_is_left_out() -> None:
    assert format_config({"paths": None, "loss": "udf"}) == 'loss = "udf"\n'


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("path = 8", "no option 'path'; did you mean 'paths'?"),
        ("xing-weight = 8", "no option 'xing-weight'; did you mean 'xing_weight'?"),
        ("zzz = 8", "no option 'zzz'; wanted one of loss, paths, schedule"),
        ("[paths]\nn = 8", "paths: got {'n': 8}, wanted a number, text, true or false"),
        ("schedule = [1, [2]]", "schedule: got [2]"),
        ("paths = 2020-01-01", "paths: got datetime.date"),
        ("paths = ", "is not TOML: "),
        ("paths = 1\npaths = 2", "is not TOML: "),
        ("\xff", "is not TOML: "),
    ],
)
def test_refusals(tmp_path: Path, text: str, message: str) -> None:
    file = tmp_path / "some.toml"
    file.write_text(text, encoding="latin-1")
    with pytest.raises(ValueError) as caught:
        read_config(file, KNOWN)
    assert str(caught.value).startswith(f"{file}: {message}")


def test_a_missing_file(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"none\.toml: cannot be read \(No such file"):
        read_config(tmp_path / "none.toml", KNOWN)
