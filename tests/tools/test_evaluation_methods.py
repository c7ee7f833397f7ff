# SPDX-License-Identifier: Apache-2.0
"""The methods of the evaluation tool: their definitions."""

from __future__ import annotations

import evaluate
import pytest
from evaluation.methods import METHODS, Method, parse_method

from livecl.options import Options


def test_known_methods_have_usable_options() -> None:
    for method in METHODS.values():
        method.check()
    assert METHODS["live"].options() == Options()
    assert METHODS["paper"].options() == Options.paper()
    assert METHODS["diffvg"].options() == Options.diffvg()
    assert METHODS["diffvg"].one_stage


def test_parse_method() -> None:
    method = parse_method("my-own:preset=paper,iterations=7,loss=mse,xing_weight=0.5,stages=one")
    assert method.options() == Options.paper(iterations=7, loss="mse", xing_weight=0.5)
    assert method.one_stage
    assert parse_method("plain") == Method(name="plain")
    assert parse_method("d:preset=diffvg").one_stage
    assert not parse_method("d:preset=diffvg,stages=growing").one_stage
    assert parse_method("v:preset=vtracer,filter_speckle=8").changes == {"filter_speckle": 8}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a/b:iterations=5", "name of letters"),
        ("..", "name of letters"),
        ("x:iterations", "wanted key=value"),
        ("x:iterations=no", "method x: iterations"),
        ("x:speed=5", "no option speed; there are iterations"),
        ("x:preset=best", "no preset 'best'"),
        ("x:stages=two", "wanted growing or one"),
        ("x:preset=vtracer,iterations=5", "VTracer has no parameter iterations"),
    ],
)
def test_parse_method_refuses(text: str, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        parse_method(text)


def test_chosen_methods() -> None:
    assert [method.name for method in evaluate.chosen_methods("", [])] == ["live", "diffvg"]
    assert [method.name for method in evaluate.chosen_methods("", ["few:iterations=5"])] == ["few"]
    chosen = evaluate.chosen_methods("few,paper,few", ["few:iterations=5"])
    assert [method.name for method in chosen] == ["few", "paper"]
