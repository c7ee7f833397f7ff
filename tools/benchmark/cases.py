# SPDX-License-Identifier: Apache-2.0
"""The named cases: measurement, picture, and goals."""

from __future__ import annotations

import dataclasses
from typing import Literal

#: The paper's schedule for an emoji.
EMOJI = (1, 1, 1, 1, 1)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Case:
    """A case to measure.

    Attributes
    ----------
    name : str
        Name on the command line.
    kind : "step", "run", "folder", "startup" or "import"
        One iteration; a whole run; 40 runs in two workers; the command line to its first iteration; ``import livecl``.
    paths, side : int
        Layers of the scene, 0 if a run chooses; height and width of the canvas, px.
    picture : "face", "scene", "soft", "photo", "pixels" or "covers"
        Pictures of the examples; a photograph; the face in 32x32 squares; no picture but layers that each cover the
        canvas.
    schedule : tuple of int or None
        Paths added by each stage of a run; None for the growing schedule.
    preset : str
        Preset of a whole run's options.
    cold : bool
        Start with empty caches.
    goal_ms, goal_mb : float or None
        Goals of time, scaled to the reference machine, and of memory.
    goal_ratio : float or None
        Goal of processor time as a share of that of commit b604af0.
    mse_at_most : float or None
        Largest error of a valid run.
    """

    name: str
    kind: Literal["step", "run", "folder", "startup", "import"]
    paths: int = 0
    side: int = 240
    picture: Literal["face", "scene", "soft", "photo", "pixels", "covers"] = "photo"
    schedule: tuple[int, ...] | None = None
    preset: str = "paper"
    cold: bool = False
    goal_ms: float | None = None
    goal_mb: float | None = None
    goal_ratio: float | None = None
    mse_at_most: float | None = None

    @property
    def title(self) -> str:
        """Name of the case in tables."""
        size = f"{self.side}x{self.side}"
        if self.kind == "step":
            layers = "covering layers" if self.picture == "covers" else "path" if self.paths == 1 else "paths"
            return f"{self.paths} {layers}, {size}"
        if self.kind == "run":
            return f"{self.name}: {self.preset}, {self.paths or 'auto'} paths, {size}"
        if self.kind == "folder":
            return f"{self.name}: 40 of {self.picture}, {self.paths} paths, {size}, two workers"
        return "import livecl" if self.kind == "import" else f"start-up, {'cold' if self.cold else 'warm'}"


_LIST = [
    Case(name="1", kind="step", paths=1, picture="face", goal_ms=0.6, goal_ratio=0.75),
    Case(name="5", kind="step", paths=5, picture="face", schedule=EMOJI, goal_ms=0.9, goal_ratio=0.62),
    Case(name="8", kind="step", paths=8, goal_ms=1.2),
    Case(name="32", kind="step", paths=32, goal_ms=3, goal_ratio=0.75),
    Case(name="128", kind="step", paths=128),
    Case(name="256", kind="step", paths=256, goal_ms=12, goal_ratio=0.73),
    Case(name="512", kind="step", paths=512),
    Case(name="256@512", kind="step", paths=256, side=512, goal_ms=30, goal_mb=400),
    Case(name="256@1024", kind="step", paths=256, side=1024),
    Case(name="covers", kind="step", paths=512, side=1024, picture="covers"),
    Case(name="emoji", kind="run", paths=5, picture="face", schedule=EMOJI, goal_ms=2300, mse_at_most=6e-3),
    Case(name="face", kind="run", paths=8, picture="face", preset="default", mse_at_most=6e-3, goal_ratio=0.21),
    Case(name="clip-art", kind="run", paths=32, picture="scene", preset="default", mse_at_most=1e-3, goal_ratio=0.21),
    Case(name="icon", kind="run", paths=5, picture="soft", preset="default", mse_at_most=1e-3, goal_ratio=0.21),
    Case(name="photo-32", kind="run", paths=32, preset="default", mse_at_most=1e-2, goal_ratio=0.36),
    Case(name="photo-512", kind="run", paths=32, side=512, preset="default", mse_at_most=1e-2, goal_ratio=0.36),
    Case(name="photo-128", kind="run", paths=128, preset="default", mse_at_most=4e-3, goal_ratio=0.33),
    Case(name="photo-2048", kind="run", paths=32, side=2048, preset="default", mse_at_most=1e-2),
    Case(name="pixels", kind="run", side=512, picture="pixels", preset="default", mse_at_most=1e-3, goal_ratio=0.05),
    Case(name="faces", kind="folder", paths=8, picture="face", preset="default", mse_at_most=6e-3, goal_ratio=0.27),
    Case(name="startup-warm", kind="startup", goal_ms=800, goal_ratio=0.75),
    Case(name="startup-cold", kind="startup", cold=True, goal_ms=4000, goal_ratio=0.6),
    Case(name="import", kind="import", goal_ms=400),
]
#: The cases by name, in the order of the table.
CASES = {case.name: case for case in _LIST}
#: Cases measured on request only: seconds per iteration, gigabytes if memory were not bounded; minutes for a run.
EXTREME = ("covers", "photo-512", "photo-128", "photo-2048", "pixels", "faces")


def chosen_cases(names: str | None) -> list[Case]:
    """Return the cases of a comma-separated list; None for all but the extreme ones.

    Raises
    ------
    ValueError
        If there is no such case.
    """
    if names is None:
        return [case for case in _LIST if case.name not in EXTREME]
    wanted = [name.strip() for name in names.split(",")]
    unknown = [name for name in wanted if name not in CASES]
    if unknown:
        raise ValueError(f"no case {', '.join(map(repr, unknown))}; there are {', '.join(CASES)}")
    return [CASES[name] for name in wanted]
