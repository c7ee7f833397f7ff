# SPDX-License-Identifier: Apache-2.0
"""What the pages tell the reader to do works: their commands run, their links lead somewhere, their options exist.

Every `sh` and `python` block of the README, CONTRIBUTING and docs/ is run, in the order of the page, in a folder that
looks like a clone. A block that is not run says why in a comment above it, `<!-- not run: reason -->`; its options are
compared with what the commands know all the same.
"""

from __future__ import annotations

import dataclasses
import functools
import importlib
import re
import subprocess
import sys
from pathlib import Path

import pytest
from support.documents import COMMANDS, DOCUMENTS, ROOT, RUN, Block, Clone, blocks, commands, prose

import livecl
from livecl import read_image
from livecl.cli.arguments import build_parser
from livecl.options import PRESET_PATHS, PRESETS, Options

#: Pages of results, each block of which is an evaluation of minutes or hours, mostly of pictures that are not here.
RESULTS = {
    "docs/performance.md": "benchmarks of minutes",
    "docs/quality.md": "evaluations of minutes to hours, of pictures that are not part of the repository",
}
#: Largest figure, bytes: pages load quickly, and the repository stays small.
MAX_BYTES = 150_000
NAMES = {str(document.relative_to(ROOT)): document for document in DOCUMENTS}


def runnable(name: str) -> list[Block]:
    return [block for block in blocks(NAMES[name]) if block.language in RUN]


def is_run(block: Block) -> bool:
    return block.reason is None and str(block.document.relative_to(ROOT)) not in RESULTS


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in NAMES if any(is_run(block) for block in runnable(name))])
def test_the_commands_of_a_page_work(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    clone = Clone(tmp_path)
    monkeypatch.chdir(clone.folder)
    monkeypatch.delenv("LIVECL_DEVICE", raising=False)
    for block in runnable(name):
        if is_run(block):
            clone.run(block)


def test_blocks_have_a_known_language() -> None:
    known = {*RUN, "text", "xml", "toml", "c", "console"}
    assert [str(block) for name in NAMES for block in blocks(NAMES[name]) if block.language not in known] == []


@functools.cache
def help_of(tool: str) -> str:
    """Return what a command says of its options."""
    if tool in COMMANDS:
        return importlib.import_module(COMMANDS[tool]).build_parser().format_help()
    done = subprocess.run(
        [sys.executable, ROOT / tool, "--help"], capture_output=True, text=True, timeout=60, check=True
    )
    return done.stdout


@pytest.mark.parametrize("name", NAMES)
def test_options_in_commands_exist(name: str) -> None:
    unknown = []
    for block in runnable(name):
        for words in commands(block.code) if block.language == "sh" else ():
            for place, word in enumerate(words):
                if (command := word.rpartition("/")[2]) in COMMANDS:
                    tool = command
                elif re.fullmatch(r"tools/\w+\.py", word):
                    tool = word if word != "tools/vectorize.py" else "livecl"
                else:
                    continue
                for option in words[place + 1 :]:
                    option = option.partition("=")[0]
                    if option.startswith("--") and not re.search(rf"{option}(?![\w-])", help_of(tool)):
                        unknown.append(f"{block}: {tool} has no {option}")
                break
    assert unknown == []


def slugs(document: Path) -> set[str]:
    """Return the anchors of a page's headings, as GitHub makes them."""
    headings = re.findall(r"^#+ +(.+?) *$", prose(document), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("name", NAMES)
def test_links_lead_somewhere(name: str) -> None:
    document = NAMES[name]
    missing = []
    for target in re.findall(r"\]\(([^)\s]+)\)", prose(document)):
        if re.match(r"[a-z]+:", target):
            continue
        path, _, anchor = target.partition("#")
        file = document.parent / path if path else document
        if not file.exists() or (anchor and anchor not in slugs(file)):
            missing.append(target)
    assert missing == []


def test_named_files_exist() -> None:
    pages = [*DOCUMENTS, *sorted((ROOT / "docs" / "notes").glob("*.md"))]
    named = re.compile(r"\b(?:livecl|kernels|tests|tools|examples)/[\w/]*\w\.(?:py|cl|h)\b")
    found = {(page.name, path) for page in pages for path in named.findall(page.read_text(encoding="utf-8"))}
    assert len(found) > 30
    assert {(page, path) for page, path in found if not (ROOT / path).exists()} == set()


def test_the_readme_leads_to_every_page() -> None:
    linked = set(re.findall(r"\]\((docs/[\w-]+\.md)\)", NAMES["README.md"].read_text(encoding="utf-8")))
    assert {name for name in NAMES if name.startswith("docs/")} <= linked


def test_every_option_is_described() -> None:
    described = set()
    for name in ("README.md", "docs/options.md"):
        described |= set(re.findall(r"`(-[\w-]+)", prose(NAMES[name])))
    options = {option for action in build_parser()._actions for option in action.option_strings}
    assert options - described == set()


def test_figures_are_small() -> None:
    figures = sorted((ROOT / "docs").rglob("*.png"))
    assert [figure.name for figure in figures if figure.stat().st_size > MAX_BYTES] == []


def table_of_presets() -> str:
    """Return the table of docs/options.md: the values of each field, and those that presets change."""
    presets = {name: make() for name, make in PRESETS.items() if name == "default" or make() != Options()}
    lines = ["| field | " + " | ".join(presets) + " |", "|---|" + "---|" * len(presets)]
    for field in dataclasses.fields(Options):
        default = getattr(Options(), field.name)
        values = [getattr(options, field.name) for options in presets.values()]
        cells = [str(default), *("" if value == default else str(value) for value in values[1:])]
        lines.append(f"| `{field.name}` | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def test_the_table_of_presets_is_that_of_the_program() -> None:
    page = NAMES["docs/options.md"].read_text(encoding="utf-8")
    found = re.search(r"<!-- table of presets -->\n(.*?)\n*<!-- end of table -->", page, re.DOTALL)
    assert found is not None
    wanted = table_of_presets()
    if found[1] != wanted:
        pytest.fail(f"the table in docs/options.md has to be\n{wanted}")
    counts = {
        name: int(count) for name, count in re.findall(r"`(\w+)`\s+(\d+)", page.partition("without `--paths`: ")[2])
    }
    assert counts == PRESET_PATHS


#: Variables of the environment, the exit code, and how each line that is printed begins.
NO_HOME = {"HOME": "/dev/null/home", "XDG_CACHE_HOME": ""}
MESSAGES: dict[str, tuple[dict[str, str], int, list[str]]] = {
    "no-device": ({"POCL_DEVICES": "none"}, 2, ["error: no OpenCL device found"]),
    "no-home": (NO_HOME, 0, ["warning: PoCL cannot keep compiled kernels", "warning: pyopencl cannot keep its cache"]),
    "both-caches": ({**NO_HOME, "XDG_CACHE_HOME": "caches"}, 0, []),
    "another-name": ({"LIVECL_DEVICE": "nvidia"}, 2, ["error: LIVECL_DEVICE 'nvidia' names no device"]),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", MESSAGES)
def test_the_page_on_opencl_says_what_is_printed(name: str, tmp_path: Path) -> None:
    if {info.platform for info in livecl.list_devices()} != {"Portable Computing Language"}:
        pytest.skip("there are other devices than PoCL's, which need no caches")
    variables, code, messages = MESSAGES[name]
    clone = Clone(tmp_path)
    folders = {key: str(tmp_path / value) for key, value in variables.items() if value in ("pocl", "caches")}
    command = "livecl examples/face.png -o face.svg --paths 1 --iterations 1 --revisions 0"
    done = clone.shell(command, **{**variables, **folders})
    assert done.returncode == code, done.stderr
    printed = [line for line in done.stderr.splitlines() if line.startswith(("livecl: error", "livecl: warning"))]
    page = NAMES["docs/opencl.md"].read_text(encoding="utf-8")
    assert len(printed) == len(messages), printed
    for line, message in zip(printed, messages, strict=True):
        assert line.startswith(f"livecl: {message}")
        assert line.partition(": [0]")[0] in page, line


def test_figures_can_be_made_again(tmp_path: Path) -> None:
    tool = [sys.executable, str(ROOT / "tools" / "make_figures.py")]
    # The figure of coverage compares what it shows with the kernels.
    subprocess.run([*tool, "coverage", "-o", str(tmp_path)], capture_output=True, timeout=120, check=True)
    assert read_image(tmp_path / "coverage.png").shape == read_image(ROOT / "docs/figures/coverage.png").shape
    known = re.sub(r"\s+", "", help_of("tools/make_figures.py"))
    for figure in (ROOT / "docs" / "figures").glob("*-*.png"):
        if figure.stem.startswith(("options-", "tutorial-")):
            assert figure.stem in known
