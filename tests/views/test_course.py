# SPDX-License-Identifier: Apache-2.0
"""The learning course: drawings kept during a run, and the films made of them."""

from __future__ import annotations

import dataclasses
import itertools
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from scipy import ndimage

from livecl import LiveclError, Options, Rasterizer, vectorize
from livecl.drawing.drawing import Drawing
from livecl.image.errors import mse
from livecl.run.callbacks import Step
from livecl.run.result import Result
from livecl.views.course import Course
from livecl.views.films import save_mp4


def picture() -> np.ndarray:
    image = np.ones((40, 60, 3))
    image[5:30, 6:40] = (0.9, 0.2, 0.1)
    image[12:24, 30:54] = (0.1, 0.2, 0.8)
    return image


@pytest.fixture(scope="module")
def run() -> tuple[Course, Result]:
    course = Course(4)
    options = Options(placement="region", iterations=10, revisions=0, prune=0.0)
    return course, vectorize(picture(), schedule=(1, 2), options=options, on_step=course)


def gif_frames(path: Path) -> tuple[list[np.ndarray], list[int]]:
    """Return the pictures of a GIF, (H, W, 3) in [0, 1], and their durations, ms."""
    frames, durations = [], []
    with Image.open(path) as film:
        for index in range(film.n_frames):
            film.seek(index)
            frames.append(np.asarray(film.convert("RGB")) / 255)
            durations.append(film.info["duration"])
    return frames, durations


def test_steps_that_are_kept(run: tuple[Course, Result]) -> None:
    kept = [(frame.stage, frame.iteration, frame.drawing.num_layers) for frame in run[0].frames]
    assert kept == [(stage, step, 1 + 2 * stage) for stage in (0, 1) for step in (1, 4, 8, 10)]
    moved = [np.abs(a.drawing.points - b.drawing.points).max() for a, b in itertools.pairwise(run[0].frames[:4])]
    assert min(moved) > 0


def test_result_is_the_same_with_a_course(run: tuple[Course, Result]) -> None:
    options = Options(placement="region", iterations=10, revisions=0, prune=0.0)
    assert vectorize(picture(), schedule=(1, 2), options=options).svg == run[1].svg


def test_another_callback_is_called_and_can_stop() -> None:
    seen: list[int] = []

    def other(step: Step) -> bool:
        seen.append(step.iteration)
        return step.iteration == 3

    course = Course(2, on_step=other)
    vectorize(picture(), paths=1, options=Options(placement="region", iterations=9, revisions=0), on_step=course)
    assert seen == [1, 2, 3]
    assert [frame.iteration for frame in course.frames] == [1, 2]


def test_revisions_that_were_taken_back_are_left_out() -> None:
    image = picture()
    steps: list[tuple[int, int]] = []
    course = Course(1, on_step=lambda step: steps.append((step.stage, step.paths)))

    options = Options(placement="region", iterations=15, revisions=4)
    result = vectorize(image, schedule=(1, 2), options=options, on_step=course)
    stages = [frame.stage for frame in course.frames]
    assert {stage for stage, _ in steps} > set(stages) >= {0, 1}  # some were tried, and not all paid
    rasterizer = Rasterizer((40, 60))
    ends = [
        frame.drawing for frame, after in zip(course.frames, [*stages[1:], -1], strict=True) if frame.stage != after
    ]
    errors = [mse(rasterizer.forward(drawing), image) for drawing in ends]
    assert errors == sorted(errors, reverse=True)
    # The last one is what the result was rounded and pruned from: together they cost less than 1e-5.
    assert errors[-1] == pytest.approx(result.mse, abs=1e-5)


def test_drawings(run: tuple[Course, Result]) -> None:
    course, result = run
    assert len(course.drawings()) == 8
    chosen = course.drawings(step=3, result=result)
    kept = [frame.drawing for frame in course.frames]
    assert chosen[:-1] == [kept[0], kept[3], kept[6]]
    assert chosen[-1] is result.drawing
    assert course.drawings(step=100) == [kept[0], kept[-1]]
    large = dataclasses.replace(result, drawing=enlarged_to(result.drawing, 3))
    assert course.drawings(result=large)[-1].size == (40, 60)


def test_gif(run: tuple[Course, Result], tmp_path: Path) -> None:
    course, result = run
    done: list[tuple[int, int]] = []
    course.save_gif(tmp_path / "a.gif", result=result, fps=10, hold=1.5, scale=1, progress=lambda *n: done.append(n))
    assert done == [(n, 9) for n in range(1, 10)]
    frames, durations = gif_frames(tmp_path / "a.gif")
    assert len(frames) == 9
    assert durations == [100] * 8 + [1600]
    rasterizer = Rasterizer((40, 60))
    for frame, drawing in zip(frames, course.drawings(result=result), strict=True):
        own = rasterizer.forward(drawing)
        assert frame.shape == own.shape
        # Fewer than 256 colours for all frames: the frequent ones are exact to 8 bits, those of edges are near.
        assert np.mean(np.abs(frame - own)) < 2 / 255
        np.testing.assert_allclose(frame[0, 0], own[0, 0], atol=0.6 / 255)
    course.save_gif(tmp_path / "b.gif", result=result, fps=10, hold=1.5, scale=1)
    assert (tmp_path / "a.gif").read_bytes() == (tmp_path / "b.gif").read_bytes()


def test_small_drawings_are_enlarged(run: tuple[Course, Result], tmp_path: Path) -> None:
    run[0].save_gif(tmp_path / "a.gif", step=7)
    with Image.open(tmp_path / "a.gif") as film:
        assert film.size == (240, 160)
        assert film.info["loop"] == 0


def test_mp4(run: tuple[Course, Result], tmp_path: Path) -> None:
    iio = pytest.importorskip("imageio.v3")
    pytest.importorskip("imageio_ffmpeg")
    course, result = run
    done: list[tuple[int, int]] = []
    course.save_mp4(tmp_path / "a.mp4", result=result, fps=10, hold=0.5, progress=lambda *n: done.append(n))
    course.save_mp4(tmp_path / "b.mp4", result=result, fps=10, hold=0.5)
    assert (tmp_path / "a.mp4").read_bytes() == (tmp_path / "b.mp4").read_bytes()
    assert done[-1] == (9, 9)
    film = iio.imread(tmp_path / "a.mp4", plugin="FFMPEG") / 255
    assert film.shape == (9 + 5, 160, 240, 3)
    own = Rasterizer((160, 240)).forward(enlarged_to(result.drawing, 4))
    spread = ndimage.maximum_filter(own, (33, 33, 1)) - ndimage.minimum_filter(own, (33, 33, 1))
    flat = np.all(spread < 1e-6, axis=2)
    assert flat.mean() > 0.25
    for frame in (film[8], film[-1]):
        # More than a block of 16 px from edges nothing rings: there only luma and chroma are rounded to
        # 8 bits of a limited range, and the colour made of the three.
        assert np.abs(frame - own)[flat].max() < 4 / 255


def enlarged_to(drawing: Drawing, factor: int) -> Drawing:
    return drawing.replace(points=drawing.points * factor, size=(factor * drawing.size[0], factor * drawing.size[1]))


def test_mp4_of_odd_sides(tmp_path: Path) -> None:
    iio = pytest.importorskip("imageio.v3")
    pytest.importorskip("imageio_ffmpeg")
    save_mp4(tmp_path / "a.mp4", [np.full((5, 7, 3), level) for level in (0.2, 0.8)])
    film = iio.imread(tmp_path / "a.mp4", plugin="FFMPEG")
    assert film.shape == (2, 6, 8, 3)
    np.testing.assert_allclose(film.mean(axis=(1, 2, 3)) / 255, [0.2, 0.8], atol=2 / 255)  # YUV of limited range


def test_without_ffmpeg(run: tuple[Course, Result], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(LiveclError, match=r"pip install 'livecl\[video\]'"):
        run[0].save_mp4(tmp_path / "a.mp4")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"fps": 0}, "fps: got 0"),
        ({"fps": 51}, "fps: got 51, wanted more than 0 and at most 50"),
        ({"hold": -1}, "hold: got -1"),
        ({"hold": 601}, "hold: got 601"),
        ({"scale": 0}, "scale: got 0"),
        ({"hold": float("nan")}, "hold: got nan"),
        ({"step": 0}, "step: got 0"),
        ({"scale": -1.0}, "scale: got -1"),
    ],
)
def test_bad_arguments(run: tuple[Course, Result], tmp_path: Path, arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        run[0].save_gif(tmp_path / "a.gif", **arguments)
    assert list(tmp_path.iterdir()) == []


def test_bad_films(tmp_path: Path) -> None:
    pytest.importorskip("imageio_ffmpeg")
    film = tmp_path / "a.mp4"
    black = np.zeros((4, 4, 3))
    for pictures, message in (
        ([], "pictures: got none"),
        ([black, np.zeros((6, 4, 3))], r"pictures: shape \(6, 4, 3\), wanted that of the first"),
        ([np.zeros((4, 4))], r"pictures: shape \(4, 4\)"),
    ):
        with pytest.raises(ValueError, match=message):
            save_mp4(film, pictures)
    for arguments, message in (({"fps": 0}, "fps: got 0"), ({"hold": -1}, "hold: got -1")):
        with pytest.raises(ValueError, match=message):
            save_mp4(film, [black], **arguments)
    assert not film.exists()


def test_empty_course_and_bad_interval(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="course: it is empty; pass it to livecl"):
        Course().save_gif(tmp_path / "a.gif")
    for every in (0, 1.5, True):
        with pytest.raises(ValueError, match="every: got"):
            Course(every)  # type: ignore[arg-type]


def test_a_revision_that_is_not_decided_is_left_out() -> None:
    course = Course(1, on_step=lambda step: step.kind == "revise" and step.iteration == 3)
    options = Options(placement="region", iterations=6, revisions=2)
    result = vectorize(picture(), schedule=(1, 1), options=options, on_step=course)
    assert result.stopped == "callback"
    assert {frame.stage for frame in course.frames} == {0, 1}
