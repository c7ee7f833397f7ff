# SPDX-License-Identifier: Apache-2.0
"""`Record`: outcomes of a run's stages, with iterations and time."""

from __future__ import annotations

import dataclasses

from livecl.run.result import Stage


@dataclasses.dataclass
class Record:
    """Outcomes of a run's stages so far."""

    #: Outcomes of finished stages; a revision counts for the stage before it.
    stages: list[Stage] = dataclasses.field(default_factory=list)
    #: Iterations and seconds of the current stage.
    iterations: int = 0
    seconds: float = 0.0

    def with_stage(self, stage: Stage, *, extends: bool) -> list[Stage]:
        """Return the stages with one more; if it `extends` the last, replace that and add up iterations and time."""
        if not (extends and self.stages):
            return [*self.stages, stage]
        last = self.stages[-1]
        iterations, seconds = last.iterations + stage.iterations, last.seconds + stage.seconds
        return [*self.stages[:-1], Stage(stage.drawing, stage.mse, iterations, seconds)]

    def lengthened(self) -> list[Stage]:
        """Return the stages, with the iterations and time since the last one added to it."""
        last = self.stages[-1]
        iterations, seconds = last.iterations + self.iterations, last.seconds + self.seconds
        return [*self.stages[:-1], Stage(last.drawing, last.mse, iterations, seconds)]
