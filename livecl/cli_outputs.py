# SPDX-License-Identifier: Apache-2.0
"""The files that a run writes: checked before the work, written after it."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from livecl.cli_arguments import BadInputError


def check_outputs(source: Path, output: Path, report: Path | None, stages: Path | None, num_stages: int) -> None:
    """Refuse what could not be written at the end, and what would overwrite the picture or another output."""
    files = [output] if report is None else [output, report]
    for file in files:
        _check_file(file)
    if stages is not None:
        if not stages.exists():
            _check_folder(stages.parent, stages)
        elif not stages.is_dir():
            raise BadInputError(f"{stages}: is a file, wanted a folder for the stages")
        for index in range(num_stages if stages.exists() else 0):
            _check_file(stage_path(stages, index))
        files += [stage_path(stages, index) for index in range(num_stages)]
    places = [os.path.realpath(file) for file in files]
    for file, place in zip(files, places, strict=True):
        if file.exists() and file.samefile(source):
            raise BadInputError(f"{file}: is the picture itself and would be overwritten")
        if places.count(place) > 1 and not file.is_char_device():
            raise BadInputError(f"{file}: two outputs would go to this file")


def _check_file(file: Path) -> None:
    if file.is_dir():
        raise BadInputError(f"{file}: is a folder, wanted a file to write")
    if not file.exists() or file.is_file():
        _check_folder(Path(os.path.realpath(file)).parent, file)


def _check_folder(folder: Path, wanted: Path) -> None:
    """Refuse a folder in which no file can be made; access rights alone do not tell (root, read-only disks)."""
    if not folder.exists():
        raise BadInputError(f"{wanted}: the folder {folder} does not exist")
    if not folder.is_dir():
        raise BadInputError(f"{wanted}: {folder} is not a folder")
    try:
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise BadInputError(f"{wanted}: cannot write into {folder}: {error.strerror or error}") from error


def stage_path(folder: Path, index: int) -> Path:
    """Return the file of a stage, counted from 0."""
    return folder / f"stage-{index + 1}.svg"
