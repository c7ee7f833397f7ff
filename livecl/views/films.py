# SPDX-License-Identifier: Apache-2.0
"""Films: write pictures as MP4 through ffmpeg, drawings as an animated GIF."""

from __future__ import annotations

import itertools
import os
import tempfile
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from livecl.drawing.checks import check_number
from livecl.drawing.drawing import Drawing
from livecl.errors import LiveclError
from livecl.files import write_atomically
from livecl.views.frames import MAX_GIF_HOLD, MIN_GIF_FRAME, encode_gif, render_frames

#: x264's constant rate factor: 18 and less counts as visually lossless.
RATE_FACTOR = 18
#: Longest time for which the last picture may be held, s.
MAX_HOLD = 3600
#: Conversion of RGB to luma and chroma, also stated in the file: otherwise players guess by the size, and differ.
_COLORS = ["-vf", "scale=out_color_matrix=bt709:out_range=tv", "-colorspace", "bt709", "-color_range", "tv"]
#: Without the encoder's version, so that the same pictures give the same bytes.
_SAME_BYTES = ["-fflags", "+bitexact", "-flags:v", "+bitexact"]


def save_mp4(
    path: str | os.PathLike[str],
    pictures: Iterable[ArrayLike],
    *,
    fps: float = 20.0,
    hold: float = 0.0,
) -> None:
    """Write pictures as an MP4 film (H.264, which every browser plays), replacing an existing file atomically.

    Parameters
    ----------
    path : path
        File to write.
    pictures : iterable of (H, W, 3) array_like
        RGB in [0, 1], one or more of one size; the iterable is read one by one. The format has even sides only:
        pictures with odd ones repeat their last row or column.
    fps : float
        Pictures per second.
    hold : float
        Additional time for which the last picture is shown, s.

    Raises
    ------
    ValueError
        If there are no pictures, their sizes differ, or a number is out of range.
    LiveclError
        If ffmpeg, which the extra ``video`` installs, is missing or fails.
    """
    try:
        import imageio_ffmpeg
    except ImportError as error:
        raise LiveclError("an MP4 film needs ffmpeg: pip install 'livecl[video]'") from error
    if not 0 < fps <= 1000:
        raise ValueError(f"fps: got {fps!r}, wanted more than 0 and at most 1000 pictures a second")
    if not 0 <= hold <= MAX_HOLD:
        raise ValueError(f"hold: got {hold!r}, wanted 0 to {MAX_HOLD} seconds")
    frames = map(_even_bytes, pictures)
    first = next(frames, None)
    if first is None:
        raise ValueError("pictures: got none, wanted at least one")
    with tempfile.TemporaryDirectory() as folder:
        film = Path(folder) / "film.mp4"
        writer = imageio_ffmpeg.write_frames(
            film,
            (first.shape[1], first.shape[0]),
            fps=fps,
            codec="libx264",
            pix_fmt_out="yuv420p",
            quality=None,
            macro_block_size=2,
            ffmpeg_log_level="error",
            output_params=[*_COLORS, "-crf", str(RATE_FACTOR), *_SAME_BYTES],
        )
        try:
            writer.send(None)
            last = first
            for frame in itertools.chain([first], frames):
                if frame.shape != first.shape:
                    raise ValueError(f"pictures: shape {frame.shape}, wanted that of the first, {first.shape}")
                writer.send(frame)
                last = frame
            for _ in range(round(hold * fps)):
                writer.send(last)
        except OSError as error:
            raise LiveclError(f"ffmpeg failed: {error}") from error
        finally:
            writer.close()
        write_atomically(path, film.read_bytes())


def _even_bytes(picture: ArrayLike) -> NDArray[np.uint8]:
    pixels = np.asarray(picture)
    if pixels.ndim != 3 or pixels.shape[2] != 3 or not pixels.size:
        raise ValueError(f"pictures: shape {pixels.shape}, wanted (H, W, 3)")
    padded = np.pad(pixels, [(0, pixels.shape[0] % 2), (0, pixels.shape[1] % 2), (0, 0)], mode="edge")
    return np.ascontiguousarray(np.rint(np.clip(padded, 0, 1) * 255).astype(np.uint8))


def save_gif(
    path: str | os.PathLike[str],
    drawings: Sequence[Drawing],
    *,
    seconds_per_frame: float = 0.1,
    hold: float = 0.0,
    bounce: bool = False,
    scale: float = 1.0,
    device: int | str | None = None,
) -> None:
    """Write drawings as an animated GIF that loops, replacing an existing file atomically.

    All frames share one palette, so that static areas do not flicker. Transparent areas lie on white.

    Parameters
    ----------
    path : path
        File to write.
    drawings : sequence of Drawing
        One or more on canvases of one size; they may differ in their layers.
    seconds_per_frame : float
        Time for which each is shown, at least 0.02, rounded to hundredths.
    hold : float
        Additional time for which the first and the last drawing are shown.
    bounce : bool
        Whether it plays backwards at the end, or restarts from the first drawing.
    scale : float
        Pixels of the GIF for each px of the canvas.
    device : int, str or None
        OpenCL device that renders.

    Raises
    ------
    ValueError
        If there are no drawings, their sizes differ, or a number is out of range.
    """
    check_number("seconds_per_frame", seconds_per_frame, MIN_GIF_FRAME, MAX_GIF_HOLD)
    check_number("hold", hold, 0, MAX_GIF_HOLD - seconds_per_frame)
    frames = list(render_frames(drawings, scale, device))
    durations = [seconds_per_frame] * len(frames)
    for end in {0, len(frames) - 1}:
        durations[end] += hold
    if bounce:
        frames += frames[-2:0:-1]
        durations += durations[-2:0:-1]
    write_atomically(path, encode_gif(frames, durations))
