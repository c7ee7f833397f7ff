# SPDX-License-Identifier: Apache-2.0
"""Interruption: whoever asks within a block is answered by it, in its thread alone; runs ask all the time."""

from __future__ import annotations

import threading
import time
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import livecl
from livecl import interruption
from livecl.layering.fills import ramps
from livecl.layering.structure import finding
from livecl.run.control import Control

#: Seconds of work, of this thread, within which a run asks.
LONGEST = 0.2


def test_the_innermost_block_answers() -> None:
    asked: list[str] = []
    interruption.check()
    with interruption.interruptible(lambda: asked.append("outer")):
        with interruption.interruptible(lambda: asked.append("inner")):
            interruption.check()
        with interruption.interruptible(None):
            interruption.check()
        interruption.check()
    interruption.check()
    assert asked == ["inner", "outer"]


def test_an_exception_goes_through_and_ends_the_block() -> None:
    def stop() -> None:
        raise TimeoutError

    with pytest.raises(TimeoutError), interruption.interruptible(stop):
        interruption.check()
    interruption.check()


def test_other_threads_are_not_asked() -> None:
    asked: list[int] = []
    with interruption.interruptible(lambda: asked.append(0)):
        thread = threading.Thread(target=interruption.check)
        thread.start()
        thread.join()
    assert not asked


def photograph() -> NDArray[np.float32]:
    """Smooth noise of three sizes: no region of it has one fill."""
    from scipy import ndimage

    rng = np.random.default_rng(5)
    layers = [ndimage.gaussian_filter(rng.normal(size=(120, 160, 3)), (s, s, 0)) * s for s in (1, 4, 12)]
    image = sum(layers)
    return np.asarray((image - image.min()) / np.ptp(image), dtype=np.float32)


def discs() -> NDArray[np.float32]:
    """Many discs across each other, of eight colours."""
    rng = np.random.default_rng(6)
    image = np.ones((150, 180, 3), np.float32)
    y, x = np.mgrid[:150, :180]
    for k in range(16):
        row, column, radius = rng.uniform(0, 150), rng.uniform(0, 180), rng.uniform(12, 40)
        image[np.hypot(y - row, x - column) < radius] = np.random.default_rng(k % 8).random(3)
    return image


def lines() -> NDArray[np.float32]:
    """Lines of two inks across each other, dots between them."""
    rng = np.random.default_rng(7)
    y, x = np.mgrid[:120, :150] + 0.5
    image = np.ones((120, 150, 3), np.float32)
    for k in range(6):
        (x0, y0), turn = rng.uniform(20, 110, 2), rng.uniform(0, np.pi)
        along = (x - x0) * np.cos(turn) + (y - y0) * np.sin(turn)
        away = np.abs((y - y0) * np.cos(turn) - (x - x0) * np.sin(turn))
        ink = np.clip(2.5 - away, 0, 1) * np.clip(60 - np.abs(along), 0, 1)
        image += ink[..., None] * (np.array([0.1, 0.1, 0.6 * (k % 2)], np.float32) - image)
    return image


def outlined() -> NDArray[np.float32]:
    """Discs with an outline of another colour."""
    y, x = np.mgrid[:125, :170] + 0.5
    image = np.full((125, 170, 3), 0.95, np.float32)
    for k in range(6):
        away = np.hypot(x - 30 - 53 * (k % 3), y - 32 - 57 * (k // 3))
        for radius, color in ((25, (0.1, 0.1, 0.2)), (21, np.random.default_rng(k).uniform(0.3, 1, 3))):
            image += np.clip(radius - away, 0, 1)[..., None] * (np.array(color, np.float32) - image)
    return image


def code() -> NDArray[np.float32]:
    """Black and white modules of six pixels, as of a QR code."""
    modules = np.random.default_rng(8).integers(0, 2, (37, 37)).astype(np.float32)
    return np.repeat(np.kron(modules, np.ones((6, 6), np.float32))[..., None], 3, axis=2)


def sprite() -> NDArray[np.float32]:
    """Pixel art of twelve colours, as large as cells of eight pixels make it."""
    rng = np.random.default_rng(9)
    half = rng.integers(0, 12, (24, 12))
    return np.kron(rng.random((12, 3))[np.hstack([half, half[:, ::-1]])], np.ones((8, 8, 1))).astype(np.float32)


def shaded() -> NDArray[np.float32]:
    """Discs with gradients on a ground with another, one shaded twice."""
    y, x = (np.mgrid[:120, :120] + 0.5) / 120
    image = np.dstack([0.5 + 0.4 * x, 0.6 + 0.3 * y, np.full_like(x, 0.9)])
    for k, (column, row, radius) in enumerate(((0.3, 0.35, 0.22), (0.65, 0.6, 0.26), (0.25, 0.8, 0.12))):
        inside = np.clip((radius - np.hypot(x - column, y - row)) * 120 + 0.5, 0, 1)[..., None]
        light = np.clip(1.1 - np.hypot(x - column + 0.1, y - row + 0.1) / radius / 2, 0, 1)[..., None]
        image += inside * (light * np.random.default_rng(k).uniform(0.4, 1, 3) - image)
    return image.astype(np.float32)


def scan() -> NDArray[np.float32]:
    """The lines on unevenly lit paper, with noise."""
    image = lines()
    light = 0.75 + 0.2 * np.cos(np.linspace(0, 1.2, image.shape[1]))
    noise = np.random.default_rng(10).normal(0, 0.015, image.shape[:2])
    return np.clip(image * light[None, :, None] + noise[..., None], 0, 1).astype(np.float32)


@pytest.mark.parametrize("picture", [photograph, discs, lines, outlined, code, sprite, shaded, scan])
def test_a_run_stops_wherever_it_is(picture: object, device: int) -> None:
    """Ended after a hundredth, a third, most of what it asks in all, it returns at once with what it has."""
    assert callable(picture)
    image, count, latest = picture(), 0, 0.0
    gaps: list[float] = []

    def counted() -> None:
        nonlocal count, latest
        count += 1
        gaps.append(time.thread_time() - latest)
        latest = time.thread_time()

    livecl.vectorize(discs()[:40, :40], 1, device=device)  # compiles what is waited for
    strokes: Any = "auto" if picture in (lines, outlined) else "off"
    options = livecl.Options(iterations=2, revisions=1, strokes=strokes)
    whole = livecl.vectorize(image, 6, options=options, device=device, control=Control(stop=counted))
    assert whole.stopped is None and max(gaps[1:]) < LONGEST  # the first is since the clock's beginning
    for share in (0.01, 0.3, 0.9):
        left = max(1, int(share * count))
        for known in vars(finding).values():  # what has been found out about the picture
            getattr(known, "cache_clear", lambda: None)()
        ramps._KNOWN.clear()

        def stop() -> str | None:
            nonlocal left
            left -= 1
            return "enough" if left <= 0 else None

        result = livecl.vectorize(image, 6, options=options, device=device, control=Control(stop=stop))
        assert result.stopped == "enough" and np.isfinite(result.mse)
        assert left == 0, "nothing asks again once it is to stop"


def test_work_without_pieces_is_waited_for() -> None:
    """In the thread that asked where nothing can interrupt; else beside it, and an interruption ends the waiting."""
    assert interruption.apart(threading.get_ident) == threading.get_ident()
    asked: list[int] = []
    done = threading.Event()

    def stop() -> None:
        asked.append(0)
        if len(asked) > 2:
            raise TimeoutError("enough")

    with interruption.interruptible(stop):
        assert interruption.apart(threading.get_ident) != threading.get_ident()
        with pytest.raises(ZeroDivisionError):
            interruption.apart(lambda: 1 // 0)
        asked.clear()
        with pytest.raises(TimeoutError, match="enough"):
            interruption.apart(done.wait)
    done.set()


def test_a_run_stopped_before_its_first_path_is_the_ground(device: int) -> None:
    image = discs()
    result = livecl.vectorize(image, 6, device=device, control=Control(time_limit=0))
    assert (result.stopped, result.drawing.num_layers, len(result.stages)) == ("time limit", 0, 1)
    ground = np.broadcast_to(result.drawing.background, image.shape)
    assert result.mse == pytest.approx(np.mean(np.square(image - ground)), rel=1e-6)
    clear = np.dstack([image, np.full(image.shape[:2], 0.5, np.float32)])
    result = livecl.vectorize(clear, 6, device=device, control=Control(time_limit=0))
    assert result.drawing.background is None
    assert result.mse == pytest.approx(np.mean(np.square(np.dstack([image / 2, clear[..., 3]]))), rel=1e-6)
