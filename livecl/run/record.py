# SPDX-License-Identifier: Apache-2.0
"""`Record`: outcomes of a run's stages, with the iterations and the time that each took."""

from __future__ import annotations

import dataclasses

from livecl.run.result import Stage


@dataclasses.dataclass
class Record:
    """How far a run has come."""

    #: Outcomes of finished stages; a revision counts for the stage before it.
    stages: list[Stage] = dataclasses.field(default_factory=list)
    #: Iterations and seconds of the stage under way.
    iterations: int = 0
    seconds: float = 0.0

    def with_stage(self, stage: Stage, *, extends: bool) -> list[Stage]:
        """Return the stages with one more, or with one that replaces the last and adds to its effort."""
        if not (extends and self.stages):
            return [*self.stages, stage]
        last = self.stages[-1]
        iterations, seconds = last.iterations + stage.iterations, last.seconds + stage.seconds
        return [*self.stages[:-1], Stage(stage.drawing, stage.mse, iterations, seconds)]

    def lengthened(self) -> list[Stage]:
        """Return the stages, with the effort spent in vain since added to the last one."""
        last = self.stages[-1]
        iterations, seconds = last.iterations + self.iterations, last.seconds + self.seconds
        return [*self.stages[:-1], Stage(last.drawing, last.mse, iterations, seconds)]
