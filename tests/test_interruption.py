# SPDX-License-Identifier: Apache-2.0
"""Interruption: whoever asks within a block is answered by it, in its thread alone; runs ask all the time."""

from __future__ import annotations

import threading
import time

import numpy as np
import pytest
from numpy.typing import NDArray

import livecl
from livecl import interruption
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


@pytest.mark.parametrize("picture", [photograph, discs])
def test_a_run_stops_wherever_it_is(picture: object, device: int) -> None:
    """Ended after a hundredth, a third, most of what it asks in all, it returns at once with what it has."""
    assert callable(picture)
    image, count, latest = picture(), 0, time.thread_time()
    gaps: list[float] = []

    def counted() -> None:
        nonlocal count, latest
        count += 1
        gaps.append(time.thread_time() - latest)
        latest = time.thread_time()

    options = livecl.Options(iterations=2, revisions=1)
    whole = livecl.vectorize(image, 6, options=options, device=device, control=Control(stop=counted))
    assert whole.stopped is None and max(gaps[1:]) < LONGEST
    for share in (0.01, 0.3, 0.9):
        left = int(share * count)
        for known in vars(finding).values():  # what has been found out about the picture
            getattr(known, "cache_clear", lambda: None)()

        def stop() -> str | None:
            nonlocal left
            left -= 1
            return "enough" if left <= 0 else None

        result = livecl.vectorize(image, 6, options=options, device=device, control=Control(stop=stop))
        assert result.stopped == "enough" and np.isfinite(result.mse)
        assert left == 0, "nothing asks again once it is to stop"


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
