# SPDX-License-Identifier: Apache-2.0
"""The learning course, and its films."""

from __future__ import annotations

import dataclasses
import itertools
import sys
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image, ImageSequence

from livecl import LiveclError, Options, Result, vectorize
from livecl.course import Course
from livecl.film import save_mp4
from livecl.rasterizer import Rasterizer

SIZE = (48, 48)
OPTIONS = Options(iterations=6, revisions=0, prune=0.0, background="white")


def square() -> NDArray[np.float32]:
    image = np.ones((*SIZE, 3), np.float32)
    image[10:38, 14:40] = 0.8, 0.2, 0.2
    image[18:28, 4:24] = 0.2, 0.4, 0.8
    return image


@pytest.fixture(scope="module")
def run() -> tuple[Course, Result]:
    course = Course(every=2)
    return course, vectorize(square(), paths=2, schedule=[1, 1], options=OPTIONS, on_step=course)


def read_film(path: Path) -> tuple[list[NDArray[np.uint8]], float]:
    """Return the pictures of a film, (H, W, 3) each, and how many there are in a second."""
    imageio_ffmpeg = pytest.importorskip("imageio_ffmpeg")
    pictures = imageio_ffmpeg.read_frames(path)
    about = next(pictures)
    width, height = about["size"]
    return [np.frombuffer(data, np.uint8).reshape(height, width, 3) for data in pictures], about["fps"]


def test_frames_are_kept_at_every_second_step(run: tuple[Course, Result]) -> None:
    course, result = run
    kept = [(frame.stage, frame.iteration) for frame in course.frames]
    assert kept == [(stage, iteration) for stage in (0, 1) for iteration in (1, 2, 4, 6)]
    assert [frame.drawing.num_layers for frame in course.frames] == [1] * 4 + [2] * 4
    # Drawings, not views of what is still being trained.
    assert not np.array_equal(course.frames[0].drawing.points, course.frames[1].drawing.points)
    assert course.drawings(result=result)[-1] is result.drawing


def test_course_changes_nothing(run: tuple[Course, Result]) -> None:
    assert vectorize(square(), paths=2, schedule=[1, 1], options=OPTIONS).svg == run[1].svg


def test_drawings_by_step(run: tuple[Course, Result]) -> None:
    course, _ = run
    all_of_them = course.drawings()
    assert len(all_of_them) == 8
    third = course.drawings(step=3)
    assert [any(drawing is other for other in third) for drawing in all_of_them] == [
        i in (0, 3, 6, 7) for i in range(8)
    ]


def test_other_callback_is_called_and_can_stop() -> None:
    told = []

    def stop_at_third(step: object) -> bool:
        told.append(step)
        return len(told) == 3

    course = Course(every=1, on_step=stop_at_third)
    vectorize(square(), paths=2, schedule=[1, 1], options=OPTIONS, on_step=course)
    assert len(told) == 3
    assert [(frame.stage, frame.iteration) for frame in course.frames] == [(0, 1), (0, 2), (0, 3)]


def test_revisions_taken_back_are_left_out() -> None:
    course = Course(every=3)
    options = dataclasses.replace(OPTIONS, revisions=3, merge=False)
    result = vectorize(square(), paths=2, schedule=[1, 1], options=options, on_step=course)
    target = square()
    rasterizer = Rasterizer(SIZE)
    ends = [frame.drawing for frame in course.frames if frame.iteration == 6]
    errors = [float(np.mean((rasterizer.forward(drawing) - target) ** 2)) for drawing in ends]
    # The two stages that add paths come first; after them only what lowered the error.
    assert all(later < earlier for earlier, later in itertools.pairwise(errors[1:]))
    # What is saved is rounded to 8 bits and thousandths of a px: half a level more in each channel's
    # root mean square error, by the triangle inequality.
    assert np.sqrt(result.mse) <= np.sqrt(errors[-1]) + 0.5 / 255


@pytest.mark.parametrize("every", [0, -1, 2.5, True])
def test_every_refused(every: int) -> None:
    with pytest.raises(ValueError, match=r"every: got .*, wanted a whole number of at least 1"):
        Course(every)


def test_gif(run: tuple[Course, Result], tmp_path: Path) -> None:
    course, result = run
    path = tmp_path / "course.gif"
    course.save_gif(path, result=result, fps=20, hold=1, scale=1)
    with Image.open(path) as film:
        frames = [(np.asarray(frame.convert("RGB")), frame.info["duration"]) for frame in ImageSequence.Iterator(film)]
        assert film.info["loop"] == 0
    drawings = course.drawings(result=result)
    pictures = [np.rint(Rasterizer(SIZE).forward(drawing) * 255) for drawing in drawings]
    # Equal pictures in a row are one frame.
    changes = 1 + sum(not np.array_equal(a, b) for a, b in itertools.pairwise(pictures))
    assert len(frames) == changes
    # 50 ms each, and the last one second more.
    assert sum(duration for _, duration in frames) == 50 * len(drawings) + 1000
    assert frames[-1][1] >= 1050
    # Of a shared palette of 256 colours the frequent ones are exact; others, on edges, are medians of few.
    difference = np.abs(frames[-1][0] - pictures[-1])
    assert np.median(difference) == 0 and difference.max() <= 32


def test_gif_enlarges_small_drawings(run: tuple[Course, Result], tmp_path: Path) -> None:
    run[0].save_gif(tmp_path / "course.gif", step=8, hold=0)
    with Image.open(tmp_path / "course.gif") as film:
        assert film.size == (240, 240)


def test_same_course_gives_the_same_bytes(run: tuple[Course, Result], tmp_path: Path) -> None:
    pytest.importorskip("imageio_ffmpeg")
    for name in ("one", "two"):
        run[0].save_gif(tmp_path / f"{name}.gif", scale=1)
        run[0].save_mp4(tmp_path / f"{name}.mp4", scale=1)
    for suffix in ("gif", "mp4"):
        assert (tmp_path / f"one.{suffix}").read_bytes() == (tmp_path / f"two.{suffix}").read_bytes()


def test_mp4(run: tuple[Course, Result], tmp_path: Path) -> None:
    pytest.importorskip("imageio_ffmpeg")
    course, result = run
    path, told = tmp_path / "course.mp4", []
    course.save_mp4(
        path, result=result, fps=10, hold=0.5, scale=2, progress=lambda done, count: told.append((done, count))
    )
    pictures, fps = read_film(path)
    assert told == [(done, 9) for done in range(1, 10)]
    assert fps == 10 and len(pictures) == 9 + 5
    assert pictures[0].shape == (96, 96, 3)
    scaled = result.drawing.replace(points=2 * result.drawing.points, size=(96, 96))
    expected = 255 * Rasterizer((96, 96)).forward(scaled)
    # Colour has half the resolution in the film, so that edges differ; flat areas do by the rounding of YUV and by what
    # the encoder leaves out.
    assert np.median(np.abs(pictures[-1] - expected)) <= 3


def test_mp4_of_odd_sides(tmp_path: Path) -> None:
    pytest.importorskip("imageio_ffmpeg")
    path = tmp_path / "odd.mp4"
    save_mp4(path, [np.full((47, 33, 3), level) for level in (0.0, 0.5, 1.0)], fps=5)
    pictures, _ = read_film(path)
    assert [picture.shape for picture in pictures] == [(48, 34, 3)] * 3
    assert [int(np.median(picture)) for picture in pictures] == pytest.approx([0, 128, 255], abs=3)


def test_mp4_refuses(tmp_path: Path) -> None:
    pytest.importorskip("imageio_ffmpeg")
    path, picture = tmp_path / "film.mp4", np.zeros((8, 8, 3))
    with pytest.raises(ValueError, match="pictures: got none"):
        save_mp4(path, [])
    with pytest.raises(ValueError, match=r"pictures: shape \(8, 10, 3\), wanted that of the first, \(8, 8, 3\)"):
        save_mp4(path, [picture, np.zeros((8, 10, 3))])
    with pytest.raises(ValueError, match=r"pictures: shape \(8, 8\), wanted \(H, W, 3\)"):
        save_mp4(path, [picture[..., 0]])
    with pytest.raises(ValueError, match="fps: got 0"):
        save_mp4(path, [picture], fps=0)
    with pytest.raises(ValueError, match="hold: got -1"):
        save_mp4(path, [picture], hold=-1)
    assert not path.exists()


def test_mp4_names_its_extra(run: tuple[Course, Result], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(LiveclError, match=r"livecl\[video\]"):
        run[0].save_mp4(tmp_path / "course.mp4")
    assert not (tmp_path / "course.mp4").exists()


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"fps": 0}, "fps: got 0"),
        ({"fps": 51}, "fps: got 51"),
        ({"hold": -1}, "hold: got -1"),
        ({"hold": float("nan")}, "hold: got nan"),
        ({"scale": 0}, "scale: got 0"),
        ({"step": 0}, "step: got 0"),
    ],
)
def test_gif_refuses(run: tuple[Course, Result], tmp_path: Path, wrong: dict[str, float], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        run[0].save_gif(tmp_path / "course.gif", **wrong)
    assert not (tmp_path / "course.gif").exists()


def test_empty_course(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="course: it is empty"):
        Course().save_gif(tmp_path / "course.gif")
