# SPDX-License-Identifier: Apache-2.0
"""The parameters of the method, and presets of them."""

from __future__ import annotations

import dataclasses
import functools
import reprlib
import sys
import textwrap
from collections.abc import Callable
from typing import Any, Literal, get_args, get_type_hints

from livecl.drawing.checks import python_number
from livecl.drawing.colors import parse_color
from livecl.errors import name_hint
from livecl.image.background import check_background

#: Decrease of the mean squared error that each path must bring where the number of paths is "auto". A black dot of one
#: pixel on white, at 240 x 240, brings 1.7e-5.
AUTO_PATH_GAIN = 1e-5
#: Opacity above which a fill counts as opaque: new paint starts opaque, and `opacity` "snap" makes it so, at no cost in
#: error on faces (docs/notes/quality.md).
OPAQUE_FROM = 0.9
#: Expectations in messages on wrong arguments.
WANTED_OPTIONS = "livecl.Options, as Options() or Options.preset('icon')"


def _option(default: Any, description: str) -> Any:
    """Return a field of `Options`, with its description for docstring and command line."""
    return dataclasses.field(default=default, metadata={"help": description})


@dataclasses.dataclass(frozen=True, kw_only=True)
class Options:
    """Parameters of the method; those of one run (paths, schedule, seed, device) are passed to `vectorize`.

    Parameters
    ----------
    {fields}

    Raises
    ------
    ValueError
        If a value is not one of those named or out of range; the message names the field.
    """

    iterations: int = _option(200, "Adam steps of each stage, at most")
    pixels_per_path: int = _option(
        1200,
        "Pixels for each path, at least those of 240 x 240, on which a picture placed by region is drawn before the "
        "last steps, which use all; 0 for all from the beginning",
    )
    segments: int = _option(4, "Cubic segments of each path")
    max_segments: int = _option(
        12,
        "Maximum number of segments of an outline fitted to a region, where `segments` are too few",
    )
    loss: Literal["udf", "mse"] = _option(
        "mse", "Loss: squared error weighted by distance (udf, eq. 1-2) or mean squared error (mse)"
    )
    xing_weight: float = _option(0.0, "Weight of the Xing loss (eq. 4), lambda")
    placement: Literal["structure", "region", "component", "random"] = _option(
        "structure",
        'Where new paths start. "structure": on the whole shapes of flat or smoothly shaded pictures, by depth '
        '(other pictures, and runs from a drawing, use "region"); "region": on the regions that remove most error; '
        '"component": on the largest connected components of the error (the paper\'s rule); "random": anywhere',
    )
    shape: Literal["outline", "circle", "random"] = _option(
        "outline",
        "Shape of new paths; an outline is fitted to the region or component",
    )
    holes: bool = _option(
        True,
        "Cut the holes of a region out of its path, as further subpaths, where that lowers the error; otherwise only "
        "holes that show the background",
    )
    settle: float = _option(
        0.1,
        "Factor that the learning rates reach at the end of a stage; they fall during its second half. 1: they stay",
    )
    end_early: bool = _option(
        True,
        "End a stage as soon as further steps gain too little, and a revision once it can no longer lower the error",
    )
    revisions: int = _option(
        8,
        "Rounds at the end that remove the least useful paths and place them anew; a round is kept if the error falls",
    )
    merge: bool = _option(True, "Merge neighbouring layers of one colour, in revisions and at the end")
    prune: float = _option(5e-6, "Drop layers at the end that lower the mean squared error by less than this")
    target_mse: float = _option(0.0, "End the run at this visible mean squared error; 0 for none")
    path_gain: float = _option(
        0.0,
        "Minimum decrease of the visible mean squared error per added path: the run ends after a stage that gains "
        "less, and layers worth less are dropped at the end. 0 for none",
    )
    simplify: bool = _option(
        True,
        "Simplify outlines at the end: few nodes, straight sides (horizontal or vertical if nearly so), smooth joins, "
        "where that saves more numbers than it costs error",
    )
    primitives: bool = _option(
        True,
        "Replace outlines by circles, ellipses or rectangles at the end, where that saves more numbers than it costs "
        "error",
    )
    colors: int = _option(0, "Maximum number of colours, the background's included; 0 for no limit")
    palette: str = _option(
        "",
        "Colours that layers may have, separated by commas, as #rrggbb,navy; on the command line also a file of "
        "#rrggbb or of lines of red, green and blue (GIMP's palettes). Empty for any",
    )
    untangle: bool = _option(True, "Remove the loops of outlines that cross themselves, during each stage")
    trim: bool = _option(
        True,
        "Cut outlines at the end to a bleed of a sixtieth of the page's longer side",
    )
    background: str = _option(
        "picture",
        'Background: a colour, as "white" or "#rrggbb"; "none": transparent, colour and alpha of the picture are the '
        'target; "auto": the colour of the border; "train": white at first, then trained; "picture": "none" for '
        'pictures with alpha, "auto" where the border has one colour, else "white"',
    )
    radius: float = _option(5.0, "Radius of new paths of shape circle, px")
    tau: float = _option(10.0, "Reach of the distance weight, px")
    color_threshold: float = _option(
        0.1, "Colour differences below this are ignored by the paper's placement (c_alpha)"
    )
    bins: int = _option(200, "Number of bins, of about equal population, for the other differences")
    learning_rate: float = _option(
        1.0,
        "Adam's step for control points, px; at most 0.3 for outlines of placement structure, which start closer",
    )
    color_learning_rate: float = _option(0.01, "Adam's step for colours")
    full_rate_side: float = _option(
        240.0,
        "On canvases whose longer side is below this, px, the learning rate of control points falls in proportion; 0 "
        "for the same rate on any canvas",
    )
    decay: float = _option(1.0, "Factor of a path's learning rates after each 500 steps; 1 for none")
    new_color: Literal["target", "random"] = _option(
        "target",
        "Fill of new paths: the target's colour at the centre, or a random colour and opacity",
    )
    opacity: Literal["snap", "train", "opaque"] = _option(
        "snap",
        "Opacity of fills. snap: trained, and 1 where it exceeds 0.9 in the second half of a stage; train: trained; "
        "opaque: that of new paths",
    )
    fills: Literal["auto", "solid", "linear", "radial"] = _option(
        "auto",
        "Fill of layers: one colour (solid), or a gradient where it lowers the error by more than its numbers cost: "
        "linear, radial, or either (auto)",
    )
    strokes: Literal["off", "auto", "only"] = _option(
        "off",
        "Draw lines as strokes along centre lines. auto: where strokes are cheaper than shapes, with fills for the "
        "rest, also thin layers of other drawings; only: strokes alone",
    )
    variant: Literal["paper", "released"] = _option(
        "paper",
        "Distance weight, Xing loss and placement rule of the paper's text, or of the authors' released program",
    )

    def __post_init__(self) -> None:
        for name, hint in get_type_hints(Options).items():
            value = python_number(getattr(self, name))
            object.__setattr__(self, name, value)
            got = f"{name}: got {reprlib.repr(value)}, wanted"
            if hint is bool and not isinstance(value, bool):
                raise ValueError(f"{got} True or False")
            least = 0 if name in ("revisions", "colors", "pixels_per_path") else 1
            if hint is int and (isinstance(value, bool) or not isinstance(value, int) or value < least):
                raise ValueError(f"{got} a whole number of at least {least}")
            if hint is float and not _is_amount(value):
                raise ValueError(f"{got} a number of at least 0")
            if get_args(hint) and value not in get_args(hint):
                raise ValueError(f"{got} {' or '.join(map(repr, get_args(hint)))}")
        for name in ("radius", "tau", "learning_rate", "color_learning_rate", "decay"):
            if getattr(self, name) == 0:
                raise ValueError(f"{name}: got 0, wanted a positive number")
        if self.shape == "outline" and self.placement == "random":
            raise ValueError(
                "shape: 'outline' needs a region to fit, so placement 'structure', 'region' or 'component'"
            )
        if self.variant == "released" and (self.placement in ("structure", "region") or self.revisions):
            raise ValueError(
                "variant: 'released' weighs the newest paths, which lie on top: it goes with placement 'component' or "
                "'random', without revisions"
            )
        check_background(self.background)
        if not isinstance(self.palette, str):
            raise ValueError(f"palette: got {reprlib.repr(self.palette)}, wanted text such as '#rrggbb,navy'")
        for part in self.palette.split(",") if self.palette else ():
            try:
                parse_color(part.strip())
            except ValueError as error:
                raise ValueError(f"palette: {str(error).removeprefix('color: ')}") from None

    @classmethod
    def preset(cls, name: str, **changes: Any) -> Options:
        """Return the options of a preset, with changes.

        Parameters
        ----------
        name : str
            A key of :data:`PRESETS`: "default", "paper", "released", "diffvg", "icon", "clipart", "photo", "draft".
        **changes
            Fields that differ from the preset.

        Raises
        ------
        ValueError
            If there is no such preset, or a value is out of range.

        Notes
        -----
        On the command line, some presets also set the number of paths: :data:`PRESET_PATHS`.
        """
        if name not in PRESETS:
            raise ValueError(f"preset: got {reprlib.repr(name)}, wanted {' or '.join(map(repr, PRESETS))}")
        return PRESETS[name](**changes)

    def choosing_paths(self) -> Options:
        """Return the options with a `path_gain`, so that the number of paths is chosen by the gain of further ones."""
        return self if self.path_gain else dataclasses.replace(self, path_gain=AUTO_PATH_GAIN)

    @classmethod
    def paper(cls, **changes: Any) -> Options:
        """Return the options of the paper's text."""
        return cls(**{**_PAPER, **changes})

    @classmethod
    def released(cls, **changes: Any) -> Options:
        """Return the options of the authors' released program, which differs from their text.

        One distance weight for the union of the newest paths, added to those of earlier stages; Xing loss of the newest
        paths only, with a further factor of 1e-3; learning rates that fall to 0.4 every 500 steps; components of the
        summed squared difference, the fullest bin first.
        """
        return cls(**{**_PAPER, "variant": "released", "decay": 0.4, "xing_weight": 1e-5, **changes})

    @classmethod
    def diffvg(cls, **changes: Any) -> Options:
        """Return the paper's baseline: random paths of random colours, trained on the mean squared error.

        Run it with all paths in one stage.
        """
        baseline = {"loss": "mse", "xing_weight": 0.0, "placement": "random", "shape": "random", "new_color": "random"}
        return cls(**{**_PAPER, **baseline, **changes})


def _described() -> str:
    """Format the fields of `Options` as numpydoc parameters."""
    hints, entries = get_type_hints(Options), []
    for field in dataclasses.fields(Options):
        *others, last = [f'"{choice}"' for choice in get_args(hints[field.name])] or [hints[field.name].__name__]
        kind = f"{', '.join(others)} or {last}" if others else last
        text = textwrap.fill(f"{field.metadata['help']}.", 110, initial_indent=" " * 8, subsequent_indent=" " * 8)
        entries.append(f"{field.name} : {kind}\n{text}")
    return "\n    ".join(entries)


def _with_hints(init: Callable[..., None]) -> Callable[..., None]:
    """Decorator of `Options.__init__`: for an unknown field, raise TypeError with the nearest one."""
    known = [field.name for field in dataclasses.fields(Options)]

    @functools.wraps(init)
    def checked(*args: Any, **values: Any) -> None:
        for name in values:
            if name not in known:
                raise TypeError(f"Options: there is no field {name!r}; {name_hint(name, known)}")
        init(*args, **values)

    return checked


Options.__init__ = _with_hints(Options.__init__)  # type: ignore[method-assign]
if Options.__doc__:  # there is none under -OO
    Options.__doc__ = Options.__doc__.format(fields=_described())


def _is_amount(value: Any) -> bool:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return False
    return 0 <= value <= sys.float_info.max  # also a whole number may be larger than any float


_PAPER: dict[str, Any] = {
    "pixels_per_path": 0,
    "iterations": 500,
    "segments": 4,
    "max_segments": 4,
    "loss": "udf",
    "xing_weight": 0.01,
    "placement": "component",
    "shape": "circle",
    "holes": False,
    "settle": 1.0,
    "end_early": False,
    "revisions": 0,
    "merge": False,
    "prune": 0.0,
    "target_mse": 0.0,
    "path_gain": 0.0,
    "simplify": False,
    "primitives": False,
    "colors": 0,
    "palette": "",
    "untangle": False,
    "trim": False,
    "background": "white",
    "radius": 5.0,
    "tau": 10.0,
    "color_threshold": 0.1,
    "bins": 200,
    "learning_rate": 1.0,
    "color_learning_rate": 0.01,
    "full_rate_side": 0.0,
    "decay": 1.0,
    "new_color": "target",
    "opacity": "train",
    "fills": "solid",
    "variant": "paper",
}


def _kind(**values: Any) -> Callable[..., Options]:
    """Return a function that makes options with the given defaults changed."""

    def make(**changes: Any) -> Options:
        return Options(**{**values, **changes})

    return make


#: Presets by name.
PRESETS: dict[str, Callable[..., Options]] = {
    "default": Options,
    "paper": Options.paper,
    "released": Options.released,
    "diffvg": Options.diffvg,
    "icon": _kind(opacity="opaque", prune=2e-4),
    "clipart": _kind(prune=2e-5),
    "photo": _kind(),
    "draft": _kind(iterations=60, revisions=0),
}
#: Maximum number of paths of the presets that set one.
PRESET_PATHS = {"paper": 8, "released": 8, "diffvg": 8, "photo": 128, "draft": 8}
