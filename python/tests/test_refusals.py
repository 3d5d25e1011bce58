"""Arguments that could be read in two ways, and names of problems."""

from __future__ import annotations

import math
import pickle
from pathlib import Path
from typing import Any, Callable

import gymnasium
import meliora
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from meliora.gym import ShieldedEnv

CHAIN = {0: {0: 1}, 1: {0: 2}, 2: {0: 2}, 3: {0: 3}}


def states_of(model: meliora.Model, condition: str = "") -> list[int]:
    explored = model.explore(scope="all")
    region = explored.where(condition) if condition else explored.initial
    return sorted(state["state"] for state in region.states())


@pytest.mark.parametrize("mask", [[0, 1, 0, 1], np.array([0, 1, 0, 1]), np.array([0, 1, 0, 1], dtype=np.uint8)])
def test_masks_of_integers_are_not_read_as_numbers_of_states(mask: Any) -> None:
    with pytest.raises(meliora.UsageError, match="write Booleans, such as `array == 1`"):
        meliora.Model.from_transitions(CHAIN, labels={"g": mask})
    with pytest.raises(meliora.UsageError, match="write Booleans, such as `array == 1`"):
        meliora.Model.from_transitions(CHAIN, start=mask)


@pytest.mark.parametrize("mask", [np.array([0, 1, 0, 1]) == 1, np.array([0.0, 1, 0, 1]), list(np.array([0, 1, 0, 1]) == 1), [1, 3]])
def test_masks_of_booleans_and_floats_and_numbers_of_states_are_read(mask: Any) -> None:
    assert states_of(meliora.Model.from_transitions(CHAIN, labels={"g": mask}), '"g"') == [1, 3]
    assert states_of(meliora.Model.from_transitions(CHAIN, start=mask)) == [1, 3]


@pytest.mark.parametrize("start", [[0.5, 0.4, 0, 0], np.array([0.5, 0.4, 0, 0]), {0: 0.5, 1: 0.4}, [1.5, -0.5, 0.0, 0.0]])
def test_a_start_distribution_that_does_not_sum_to_one_is_refused(start: Any) -> None:
    with pytest.raises(meliora.UsageError, match="sum"):
        meliora.Model.from_transitions(CHAIN, start=start)
    assert states_of(meliora.Model.from_transitions(CHAIN, start={0: 0.5, 1: 0.5})) == [0, 1]
    with pytest.raises(meliora.UsageError, match="neither 0 nor 1"):
        meliora.Model.from_transitions(CHAIN, labels={"g": [0.5, 0.5, 0.0, 0.0]})


def test_objectives_of_a_planning_problem_are_known() -> None:
    model = meliora.Model.from_file("models/responders.pddl")
    found = model.check("models/responders.pref")
    assert "goal" in found.preferences.objectives
    text = Path("models/household.pddl").read_text() + Path("models/household-flat.pddl").read_text()
    household = meliora.Model.from_string(text)
    wishes = meliora.Preferences.from_file("models/household.pref", model=household)
    assert {"clean", "fed", "played"} <= set(wishes.objectives)
    assert household.check(wishes).sasi.counts == household.check("models/household.pref").sasi.counts
    with pytest.raises(meliora.InputError, match="unknown objective"):
        meliora.Preferences.from_file("models/household.pref")
    assert pickle.loads(pickle.dumps(wishes)).objectives == wishes.objectives


def test_negative_numbers_are_refused_by_name() -> None:
    model = meliora.Model.from_file("models/toy.prism")
    found = model.check("models/toy.pref")
    calls: list[tuple[Callable[[], object], str]] = [
        (lambda: model.check("models/toy.pref", max_level=-1), "max_level"),
        (lambda: found.strategy("sasi").simulate(model.state(), runs=-1), "runs"),
        (lambda: found.strategy("sasi").simulate(model.state(), seed=-1), "seed"),
        (lambda: found.strategy("sasi").simulate(model.state(), steps=2**70), "steps"),
        (lambda: found.values(levels=-2), "levels"),
        (lambda: model.explore().states.sample(-1), "size"),
    ]
    for call, name in calls:
        with pytest.raises(meliora.UsageError, match=f"{name}=-?[0-9]+: expected"):
            call()


def test_an_infinite_timeout_is_none_and_a_memory_of_true_is_refused() -> None:
    model = meliora.Model.from_file("models/toy.prism")
    assert model.explore(timeout=math.inf).states.count() == model.explore().states.count()
    with pytest.raises(meliora.UsageError, match="memory=True"):
        model.explore(memory=True)
    with pytest.raises(meliora.UsageError, match="timeout=True"):
        model.explore(timeout=True)


def test_layouts_and_names_of_tables_are_read_or_named() -> None:
    rows = np.array([[[0.0, 1, 0], [0, 0, 1], [0, 0, 1]], [[1.0, 0, 0], [1, 0, 0], [0, 0, 1]]])
    by_action = meliora.Model.from_transitions(rows)
    assert by_action.text == meliora.Model.from_transitions(rows.transpose(1, 0, 2)).text
    assert by_action.text == meliora.Model.from_transitions([np.matrix(matrix) for matrix in rows]).text
    with pytest.raises(meliora.UsageError, match="rewards are a dictionary by their names"):
        meliora.Model.from_transitions(rows, rewards=np.zeros(3))  # type: ignore[arg-type]
    with pytest.raises(meliora.UsageError, match="two actions are called 'a'"):
        meliora.Model.from_transitions(rows, actions=["a", "a"])


def test_a_shielded_environment_of_gymnasium_passes_its_check() -> None:
    env = gymnasium.make("FrozenLake-v1", map_name="8x8")
    table: Any = env.unwrapped
    model = meliora.Model.from_transitions(table.P, labels={"goal": [63]}, start=0)
    found = model.check(meliora.Preferences({"Goal": 'F "goal"'}))
    shielded = ShieldedEnv(env, found.strategy("achieve", objective="Goal").shield())
    assert shielded.spec is not None
    check_env(shielded, skip_render_check=True)
    assert gymnasium.wrappers.TimeLimit(shielded, 100).spec is not None
