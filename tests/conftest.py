# SPDX-License-Identifier: Apache-2.0
"""Fixtures: the OpenCL devices, rasterizers that are built once, and the pictures beside the repository."""

from __future__ import annotations

import os
import pathlib
import signal
import tempfile
from collections.abc import Callable
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from livecl.rendering.rasterizer import Rasterizer

RasterizerFor = Callable[[tuple[int, int], type], "Rasterizer"]


def pytest_configure(config: pytest.Config) -> None:
    """Undo what the surroundings would change: ignored signals, a home where no compiled kernels can be kept."""
    # Started in the background, a process may ignore signals.
    for number, usual in ((signal.SIGINT, signal.default_int_handler), (signal.SIGTERM, signal.SIG_DFL)):
        if signal.getsignal(number) is signal.SIG_IGN:
            signal.signal(number, usual)
    # Else each process warns that it cannot keep them, and compiles them anew.
    cache = pathlib.Path(os.environ.get("XDG_CACHE_HOME") or pathlib.Path("~/.cache").expanduser())
    there = next(folder for folder in (cache, *cache.parents) if folder.exists())
    if not os.access(there, os.W_OK | os.X_OK):
        folder = tempfile.TemporaryDirectory(prefix="livecl-tests-")
        os.environ["XDG_CACHE_HOME"] = folder.name
        config.add_cleanup(folder.cleanup)


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Run every test that asks for `device`, itself or through a fixture, on all OpenCL devices found."""
    if "device" in metafunc.fixturenames:
        import livecl

        devices = livecl.list_devices()
        # Without a device the tests run with None, and fail with the message that says how to get one.
        metafunc.parametrize(
            "device",
            [device.index for device in devices] or [None],
            ids=[f"device{device.index}" for device in devices] or ["no-device"],
            scope="session",
        )


@pytest.fixture(scope="session")
def rasterizer_for(device: int | None) -> RasterizerFor:
    """Return a function (size, dtype) -> Rasterizer on the device, which builds each only once."""
    from livecl.opencl.device import open_device
    from livecl.rendering.rasterizer import Rasterizer

    made: dict[tuple[tuple[int, int], type], Rasterizer] = {}

    def rasterizer(size: tuple[int, int], dtype: type) -> Rasterizer:
        key = size, dtype
        if key not in made:
            if dtype(0).itemsize == 8 and not open_device(device).device.double_fp_config:
                pytest.skip("the device has no double precision")
            made[key] = Rasterizer(size, device=device, dtype=dtype)
        return made[key]

    return rasterizer


@pytest.fixture(scope="session")
def data_dir() -> pathlib.Path:
    """Return the folder of sample pictures beside the repository; skip where it is absent."""
    folder = pathlib.Path(__file__).resolve().parents[2] / "shared" / "data"
    if not folder.is_dir():
        pytest.skip("the sample pictures (../shared/data) are not here")
    return folder
