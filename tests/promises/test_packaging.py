# SPDX-License-Identifier: Apache-2.0
"""What is installed: the wheel's files, the kernels from each kind of installation, the sample pictures."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import venv
import zipfile
from pathlib import Path

import numpy as np
import pytest
from support.documents import COMMANDS

import livecl

ROOT = Path(__file__).resolve().parents[2]
#: What a build reads.
SOURCES = [
    "livecl",
    "kernels",
    "tools",
    "setup.cfg",
    "pyproject.toml",
    "README.md",
    "LICENSE",
    "CHANGELOG.md",
    "MANIFEST.in",
]
BUILD_WHEEL = "import sys; from setuptools import build_meta; build_meta.build_wheel(sys.argv[1])"
#: Vectorizes with the installed package, and prints where package and kernels were found.
USE = """
import livecl, numpy, pathlib
from livecl.opencl.program import kernel_dir
livecl.vectorize(numpy.zeros((4, 4, 3)), paths=1, options=livecl.Options(iterations=1)).save_svg("out.svg")
print(pathlib.Path(livecl.__file__).parent)
print(kernel_dir())
"""


def kernel_names() -> list[str]:
    return sorted(file.name for file in (ROOT / "kernels").iterdir() if file.suffix in (".cl", ".h"))


def clean_environment() -> dict[str, str]:
    return {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "PYTHONHOME")}


def run(*command: object, cwd: Path) -> str:
    """Run a command that must succeed; return what it prints."""
    done = subprocess.run(
        list(map(str, command)),
        cwd=cwd,
        env=clean_environment(),
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """A copy of the sources, whose path has a space in it."""
    folder = tmp_path / "check out"
    for name in SOURCES:
        source = ROOT / name
        if source.is_dir():
            shutil.copytree(source, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            folder.mkdir(exist_ok=True)
            shutil.copy(source, folder / name)
    return folder


def test_wheel_holds_the_sources_and_nothing_else(checkout: Path, tmp_path: Path) -> None:
    for stale in ("livecl/kernels/deleted.cl", "livecl/deleted.py"):
        file = checkout / "build" / "lib" / stale
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text("")
    run(sys.executable, "-c", BUILD_WHEEL, tmp_path, cwd=checkout)
    (wheel,) = tmp_path.glob("*.whl")
    assert wheel.name == f"livecl-{livecl.__version__}-py3-none-any.whl"
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
        metadata = archive.read(f"livecl-{livecl.__version__}.dist-info/METADATA").decode()
    package = sorted(name for name in names if ".dist-info/" not in name)
    sources = [file for file in (ROOT / "livecl").rglob("*") if file.is_file() and file.suffix != ".pyc"]
    assert {file.suffix for file in sources} == {".py", ".pyi", ".typed", ".html", ".css", ".js", ".txt"}
    kernels = [f"livecl/kernels/{name}" for name in kernel_names()]
    assert package == sorted([*(file.relative_to(ROOT).as_posix() for file in sources), *kernels])
    assert any(name.endswith("/LICENSE") for name in names)
    assert "Requires-Dist: pyopencl[pocl]" in metadata
    assert "Requires-Python: >=3.10" in metadata


def test_checkout_without_installation(checkout: Path, tmp_path: Path) -> None:
    script = f"import sys; sys.path.insert(0, {str(checkout)!r})\n{USE}"
    package, kernels = run(sys.executable, "-c", script, cwd=tmp_path).splitlines()
    assert (Path(package), Path(kernels)) == (checkout / "livecl", checkout / "kernels")


@pytest.mark.parametrize("editable", [False, True], ids=["wheel", "editable"])
def test_installation(checkout: Path, tmp_path: Path, editable: bool) -> None:
    environment = tmp_path / "environment"
    venv.create(environment, symlinks=True)
    (site,) = environment.glob("lib/python*/site-packages")
    # The dependencies, without network: the packages of this environment come after the new one's own.
    (site / "dependencies.pth").write_text("\n".join(path for path in sys.path if path.endswith("site-packages")))
    scripts = environment / "bin"
    options = ["--quiet", "--no-deps", "--no-index", "--no-build-isolation", *(["--editable"] if editable else [])]
    # This environment's pip installs into the other, which need not have its own.
    pip = [sys.executable, "-m", "pip", "--python", scripts / "python", "install"]
    run(*pip, *options, checkout, cwd=tmp_path)
    if not editable:
        shutil.rmtree(checkout)
    package, kernels = map(Path, run(scripts / "python", "-c", USE, cwd=tmp_path).splitlines())
    assert package == (checkout / "livecl" if editable else site / "livecl")
    assert kernels == (checkout / "kernels" if editable else site / "livecl" / "kernels")
    assert sorted(file.name for file in kernels.iterdir()) == kernel_names()
    assert livecl.read_svg(tmp_path / "out.svg").size == (4, 4)
    assert run(scripts / "livecl", "--version", cwd=tmp_path) == f"livecl {livecl.__version__}\n"
    assert sorted(file.name for file in scripts.glob("livecl*")) == sorted(COMMANDS)
    for command in COMMANDS:
        assert f"{command} " in run(scripts / command, "--help", cwd=tmp_path)


def test_import_is_light() -> None:
    heavy = {"pyopencl", "scipy", "skimage", "imageio", "PIL", "tqdm", "tinycss2", "matplotlib"}
    script = f"import sys, livecl, livecl.cli, livecl.svg, livecl.drawing; print(*sorted({heavy} & set(sys.modules)))"
    assert run(sys.executable, "-c", script, cwd=ROOT).split() == []


def test_the_command_loads_what_one_picture_needs() -> None:
    others = {"pyopencl", "scipy", "skimage", "tinycss2", "multiprocessing", "http", "ssl", "email", "PIL"}
    script = f"import sys, livecl.cli.command; print(*sorted({others} & set(sys.modules)))"
    assert run(sys.executable, "-c", script, cwd=ROOT).split() == []


@pytest.mark.parametrize(
    "source", sorted((ROOT / "examples" / "sources").glob("*.svg")), ids=lambda source: source.stem
)
def test_examples_are_their_sources(source: Path) -> None:
    import resvg_py

    picture = livecl.read_image(ROOT / "examples" / f"{source.stem}.png")
    rendered = livecl.read_image(bytes(resvg_py.svg_to_bytes(svg_string=source.read_text(encoding="utf-8"))))
    assert picture.shape == rendered.shape
    assert picture.shape[:2] == (240, 240)
    assert (picture.shape[2] == 4) == (source.stem == "soft")
    assert np.abs(picture - rendered).mean() < 0.5 / 255  # another version of resvg may round another way


def test_examples_are_complete() -> None:
    pictures = {file.stem for file in (ROOT / "examples").glob("*.png")}
    assert pictures == {file.stem for file in (ROOT / "examples" / "sources").glob("*.svg")}
    assert len(pictures) >= 6
