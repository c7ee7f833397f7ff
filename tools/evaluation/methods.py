# SPDX-License-Identifier: Apache-2.0
"""Methods: named sets of options."""

from __future__ import annotations

import dataclasses
import json
import re
from typing import Any

from livecl.options import PRESETS, Options

#: The preset for VTracer; all others are livecl's.
VTRACER = "vtracer"
#: VTracer's own parameters that a method may change.
VTRACER_PARAMETERS = {
    "colormode", "hierarchical", "mode", "filter_speckle", "color_precision", "layer_difference", "corner_threshold",
    "length_threshold", "max_iterations", "splice_threshold", "path_precision",
}  # fmt: skip


@dataclasses.dataclass(frozen=True, kw_only=True)
class Method:
    """A way to vectorize.

    Attributes
    ----------
    name : str
        Name in tables and folders.
    preset : str
        A preset of livecl's options, or "vtracer".
    changes : dict
        Options that differ from the preset's.
    one_stage : bool
        Place all paths at once, instead of in growing stages.
    disturbance : str
        Disturbance of the picture (`quality.DISTURBANCES`), or ""; errors are measured against the clean one.
    """

    name: str
    preset: str = "default"
    changes: dict[str, Any] = dataclasses.field(default_factory=dict)
    one_stage: bool = False
    disturbance: str = ""

    def under(self, disturbance: str) -> Method:
        """Return the method on disturbed pictures, with a combined name."""
        return dataclasses.replace(self, name=f"{self.name}+{disturbance}", disturbance=disturbance)

    def options(self) -> Options:
        """Return livecl's options; ValueError if they are invalid."""
        known = [field.name for field in dataclasses.fields(Options)]
        if unknown := set(self.changes) - set(known):
            raise ValueError(
                f"method {self.name}: no option {', '.join(sorted(unknown))}; there are {', '.join(known)}"
            )
        try:
            return PRESETS[self.preset](**self.changes)
        except (TypeError, ValueError) as error:
            raise ValueError(f"method {self.name}: {error}") from None

    def check(self) -> None:
        """Raise ValueError if the options are not usable."""
        if self.preset != VTRACER:
            self.options()
        elif unknown := set(self.changes) - VTRACER_PARAMETERS:
            raise ValueError(f"method {self.name}: VTracer has no parameter {', '.join(sorted(unknown))}")

    def describe(self) -> dict[str, Any]:
        """Return everything that determines the method."""
        if self.preset == VTRACER:
            return {"preset": VTRACER, "disturbance": self.disturbance, **self.changes}
        own = {"one_stage": self.one_stage, "disturbance": self.disturbance}
        return {**dataclasses.asdict(self.options()), **own}


#: The methods known by name: ours, the paper's, its baseline, and a tracer.
METHODS = {
    method.name: method
    for method in (
        Method(name="live"),
        Method(name="paper", preset="paper"),
        Method(name="released", preset="released"),
        Method(name="diffvg", preset="diffvg", one_stage=True),
        Method(name=VTRACER, preset=VTRACER),
    )
}


def parse_method(text: str) -> Method:
    """Parse a method, "name:key=value,key=value".

    Keys are the options' names, `preset` (the set that they change) and `stages`, "growing" or "one". Raises ValueError
    if it is invalid.

    >>> parse_method("few:preset=paper,iterations=50").options().iterations
    50
    """
    name, _, rest = text.partition(":")
    if not re.fullmatch(r"[\w.+-]+", name) or not name.strip("."):
        raise ValueError(f"method {text!r}: wanted name:key=value,key=value with a name of letters, digits, . + - _")
    changes: dict[str, Any] = {}
    for item in filter(None, rest.split(",")):
        key, equals, value = item.partition("=")
        if not equals:
            raise ValueError(f"method {name}: got {item!r}, wanted key=value")
        changes[key.strip()] = _value(value.strip())
    preset, stages = changes.pop("preset", "default"), changes.pop("stages", None)
    if preset not in PRESETS and preset != VTRACER:
        raise ValueError(f"method {name}: no preset {preset!r}; there are {', '.join([*PRESETS, VTRACER])}")
    if stages not in (None, "growing", "one"):
        raise ValueError(f"method {name}: stages is {stages!r}, wanted growing or one")
    one_stage = preset == "diffvg" if stages is None else stages == "one"
    method = Method(name=name, preset=preset, changes=changes, one_stage=one_stage)
    method.check()
    return method


def _value(text: str) -> Any:
    """Return a number, true, false or null as JSON spells them, and anything else as text."""
    try:
        value = json.loads(text)
    except ValueError:
        return text
    return value if isinstance(value, (int, float, bool)) or value is None else text
