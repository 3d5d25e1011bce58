"""Shields by value: the probability of a formula after each action, and what a threshold permits."""

from __future__ import annotations

import pickle
from pathlib import Path

import pytest

import meliora

WORLD = """mdp
module world
  s : [0..3] init 0;
  [safe] s=0 -> 0.9:(s'=1) + 0.1:(s'=3);
  [mid] s=0 -> 0.8:(s'=1) + 0.2:(s'=3);
  [bad] s=0 -> 0.5:(s'=1) + 0.5:(s'=3);
  [go] s=1 -> (s'=2);
  [go] s=2 -> (s'=0);
  [end] s=3 -> true;
endmodule
label "crash" = s=3;
"""


def test_a_shield_by_value_masks_the_actions_that_are_not_safe_enough(tmp_path: Path) -> None:
    model = meliora.Model.from_string(WORLD)
    shield = model.shield('Pmin=? [ F<=3 "crash" ]', 0.85)
    assert (shield.kind, shield.actions) == ("safety", ["safe", "mid", "bad", "go", "end"])
    assert shield.rule is not None and shield.rule["threshold"] == 0.85 and not shield.rule["maximises"]
    start = model.state()
    shield.reset(start)
    assert shield.allowed(start) == ("safe",) and shield.secure(start)
    assert list(shield.mask(start)) == [True, False, False, False, False]
    lower, upper = shield.values(start)["mid"]
    assert lower <= 0.2 <= upper
    assert shield.correct(start, "bad") == "safe"
    shield.step({"s": 3})
    assert shield.allowed({"s": 3}) == ("end",) and not shield.secure({"s": 3})
    shield.save(tmp_path / "shield")
    again = meliora.Shield.load(tmp_path / "shield")
    assert again.rule == shield.rule and pickle.loads(pickle.dumps(again)).values({"s": 1}) == {"go": shield_value(again)}


def shield_value(shield: meliora.Shield) -> tuple[float, float]:
    return shield.copy().values({"s": 1})["go"]


def test_a_shield_expression_has_a_threshold_and_others_need_one() -> None:
    model = meliora.Model.from_string(WORLD)
    shield = model.shield('<name, PreSafety, lambda=0.95> Pmax=? [ G<=3 !"crash" ]')
    assert shield.allowed({"s": 0}) == ("safe",)
    with pytest.raises(meliora.UsageError, match="a threshold is missing"):
        model.shield('Pmax=? [ G !"crash" ]')
    with pytest.raises(meliora.UsageError, match="expected a number between 0 and 1"):
        model.shield('Pmax=? [ G !"crash" ]', 2)
    with pytest.raises(meliora.UsageError, match="has no values"):
        wishes = meliora.Preferences.from_string("objective Low = F s=2;")
        model.check(wishes).strategy("sasi").shield().values({"s": 0})
