# SPDX-License-Identifier: Apache-2.0
"""Which pictures inputs stand for, and that no two SVGs of a batch go to one file."""

from __future__ import annotations

from pathlib import Path

import pytest

from livecl.batch.inputs import find_pictures, is_pattern


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    for name in ("one/b.png", "one/a.JPG", "one/deep/c.webp", "one/text.txt", "one/.hidden.png", "one/.git/d.png"):
        make(name)
    return tmp_path


def make(name: str) -> None:
    Path(name).parent.mkdir(parents=True, exist_ok=True)
    Path(name).write_bytes(b"")


def found(*inputs: str) -> dict[str, str]:
    """Return output by file."""
    pictures = find_pictures(inputs)
    return {picture.file.as_posix(): picture.output for picture in pictures}


def test_a_folder_stands_for_its_pictures(folder: Path) -> None:
    assert found("one") == {"one/a.JPG": "a.svg", "one/b.png": "b.svg", "one/deep/c.webp": "deep/c.svg"}


def test_a_file_may_have_any_ending(folder: Path) -> None:
    assert found("one/text.txt", "one/b.png") == {"one/text.txt": "text.svg", "one/b.png": "b.svg"}


def test_an_empty_path_is_not_the_current_folder(folder: Path) -> None:
    with pytest.raises(ValueError, match="got an empty path"):
        found("one/b.png", "")


def test_patterns(folder: Path) -> None:
    assert found("one/*") == {"one/a.JPG": "a.svg", "one/b.png": "b.svg"}
    assert found("one/**/*.webp") == {"one/deep/c.webp": "c.svg"}
    assert is_pattern("one/*") and is_pattern("one/[ab].png") and not is_pattern("one")
    make("one/[x].png")
    assert not is_pattern("one/[x].png")
    assert found("one/[x].png") == {"one/[x].png": "[x].svg"}


def test_each_picture_once(folder: Path) -> None:
    Path("link.png").symlink_to("one/b.png")
    assert found("one/b.png", "one", "link.png", "one/../one/b.png") == {
        "one/b.png": "b.svg",
        "one/a.JPG": "a.svg",
        "one/deep/c.webp": "deep/c.svg",
    }


def test_same_names_in_different_folders(folder: Path) -> None:
    make("two/b.png")
    make("two/e.png")
    assert found("one/b.png", "two") == {"one/b.png": "one/b.svg", "two/b.png": "two/b.svg", "two/e.png": "e.svg"}
    assert found("one/b.png", str(folder / "two" / "b.png")) == {
        "one/b.png": "one/b.svg",
        (folder / "two" / "b.png").as_posix(): "two/b.svg",
    }


def test_same_names_in_one_folder(folder: Path) -> None:
    for name in ("one/b.gif", "one/b.png.gif"):
        make(name)
    names = found("one")
    assert names["one/b.gif"] == "b.gif.svg"
    assert {names["one/b.png"], names["one/b.png.gif"]} == {"b.png.svg", "b.png-2.svg"}
    assert len(set(names.values())) == len(names)


def test_names_that_differ_in_case_only(folder: Path) -> None:
    make("one/B.png")
    if not Path("one/B.png").samefile("one/b.png"):
        names = found("one/b.png", "one/B.png")
        assert len({name.casefold() for name in names.values()}) == 2


@pytest.mark.parametrize(
    ("inputs", "message"),
    [
        ([], "inputs: got none"),
        (["one", "none.png"], "none.png: there is no such file"),
        (["one/*.gif"], r"one/\*.gif: the pattern matches no picture"),
        (["empty"], "empty: the folder holds no pictures"),
    ],
)
def test_refusals(folder: Path, inputs: list[str], message: str) -> None:
    Path("empty").mkdir()
    with pytest.raises(ValueError, match=f"^{message}"):
        find_pictures(inputs)
