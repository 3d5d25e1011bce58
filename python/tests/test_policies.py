"""Policies of files and the comparison of the engines."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import meliora
import pytest
from conftest import MODELS
from meliora import errors

WALK = """mdp
module walk
  x : [0..4] init 0;
  [left] x=0 -> 1/4: (x'=1) + 3/4: (x'=3);
  [right] x=0 -> (x'=2);
  [again] x=3 -> 1/2: (x'=0) + 1/2: (x'=4);
  [stay] x=1 | x=2 | x=4 -> true;
endmodule
"""


@pytest.fixture(scope="module")
def walk() -> meliora.Model:
    return meliora.Model.from_string(WALK)


def test_a_list_of_rules_is_checked_and_run(walk: meliora.Model) -> None:
    policy: Any = walk.ask("Pmax>=1 [ F x=2 ]", policy=True)["policy"]
    found = walk.verify_policy(policy, target="x=2", strong=True)
    assert (found["accepted"], found["states"], found["longest"]) == (True, "1", "1")
    runs = walk.simulate_policy(policy, target="x=2", runs=20)["runs"]
    assert (runs["reached"], runs["mean_steps"]) == (20, 1.0)
    policy[0]["action"] = "left"
    refused = walk.verify_policy(policy, target="x=2")
    assert refused["accepted"] is False
    assert refused["violation"] is not None


def test_strategies_of_several_objectives_are_checked_and_run(walk: meliora.Model) -> None:
    policy: Any = walk.ask("multi(P>=1/2 [ F x=2 ], P>=1/10 [ F x=1 ])", policy=True)["policy"]
    assert walk.verify_policy(policy)["accepted"]
    measured = walk.simulate_policy(policy, runs=200)["runs"]["objectives"]
    assert all(0 < (one["measured"] or 0) < 1 for one in measured)
    policy["strategies"][0]["values"] = [1, 1]
    assert not walk.verify_policy(policy)["accepted"]


def test_a_policy_with_memory_is_written_checked_and_run(tmp_path: Path) -> None:
    drone = meliora.Model.from_file(MODELS / "drone.prism")
    wishes = MODELS / "drone.pref"
    policy = drone.check(wishes).strategy("sasi").policy()
    file = tmp_path / "policy.json"
    file.write_text(json.dumps(policy), encoding="utf-8")
    for given in (policy, file):
        found = drone.verify_policy(given, preferences=wishes)
        assert found["accepted"]
        assert found["promise"]["starts"]
    runs = drone.simulate_policy(file, preferences=wishes, runs=30, seed=3)["runs"]
    assert (runs["runs"], runs["reached"]) == (30, 30)
    everywhere = drone.check(wishes).strategy("sasi").policy(everywhere=True)
    assert len(everywhere["nodes"]) > len(policy["nodes"])


def test_the_goal_of_a_planning_problem_is_that_of_its_policy() -> None:
    responders = meliora.Model.from_file(MODELS / "responders.pddl")
    policy: Any = responders.ask(policy=True)["policy"]
    assert responders.verify_policy(policy)["accepted"]


def test_what_does_not_fit_a_policy_is_refused(walk: meliora.Model, tmp_path: Path) -> None:
    policy: Any = walk.ask("Pmax>=1 [ F x=2 ]", policy=True)["policy"]
    with pytest.raises(errors.UsageError, match="no goal of its own"):
        walk.verify_policy(policy)
    with pytest.raises(errors.UsageError, match="no preferences"):
        walk.verify_policy(policy, preferences=meliora.Preferences({"two": "F x=2"}))
    with pytest.raises(errors.InputError):
        walk.verify_policy([{"state": "y=0", "action": "left"}], target="x=2")
    with pytest.raises(errors.UsageError, match="path of a file"):
        walk.verify_policy(3, target="x=2")  # type: ignore[arg-type]
    with pytest.raises(OSError, match="nosuch"):
        walk.verify_policy(tmp_path / "nosuch.json", target="x=2")
    with pytest.raises(errors.UsageError, match="runs=-1"):
        walk.simulate_policy(policy, target="x=2", runs=-1)


def test_a_limit_leaves_what_is_known_of_a_policy(walk: meliora.Model) -> None:
    policy: Any = walk.ask("Pmax>=1 [ F x=2 ]", policy=True)["policy"]
    with pytest.raises(errors.OutOfTime) as ended:
        walk.simulate_policy(policy, target="x=2", runs=10**9, timeout=0.2)
    known: Any = ended.value.known
    assert known["report"]["runs"]["reached"] > 0


def test_the_engines_agree() -> None:
    drone = meliora.Model.from_file(MODELS / "drone.prism")
    found = drone.compare(MODELS / "drone.pref", scope="all", membership=3)
    assert (found["equal"], found["difference"], found["membership"]) == (True, None, None)
    assert [one["engine"] for one in found["engines"]] == ["symbolic", "explicit"]
    small = meliora.Model.from_string(WALK).compare(meliora.Preferences({"two": "F x=2", "one": "F x=1"}))
    assert small["membership"] == "5"
