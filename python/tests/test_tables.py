"""Models from tables of transitions and from archives."""

from __future__ import annotations

import gzip
import json
import math
import pickle
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import meliora
from conftest import packed
from meliora._json import loads

#: The first action of state 0 leads to 1 or 2, the second to 3; the third state ends the episode.
P: dict[int, dict[int, list[tuple[float, int, float, bool]]]] = {
    0: {0: [(0.5, 1, 0.0, False), (0.5, 2, 0.0, True)], 1: [(1.0, 3, 0.0, False)]},
    1: {0: [(1.0, 1, 0.0, False)]},
    2: {0: [(1.0, 0, 0.0, False)]},
    3: {0: [(1.0, 3, 0.0, False)], 1: [(1.0, 3, 0.0, False)]},
}
LABELS: dict[str, Any] = {"one": [1], "two": np.array([False, False, True, False]), "three": [3]}
WISHES = meliora.Preferences(
    {"One": 'F "one"', "Two": 'F "two"', "Three": 'F "three"'}, ["One > Three", "Two > Three"]
)


def array() -> Any:
    table = np.zeros((4, 2, 4))
    table[0, 0, [1, 2]], table[0, 1, 3] = 0.5, 1.0
    table[1, 0, 1] = table[2, 0, 2] = table[3, 0, 3] = table[3, 1, 3] = 1.0
    return table


def permitted(model: meliora.Model) -> tuple[list[int], list[bool]]:
    found = model.check(WISHES)
    return [int(n) for n in found.sasi.counts], [bool(b) for b in found.strategy("sasi").mask({"state": 0})]


def test_all_kinds_of_tables_are_one_model() -> None:
    tables = [P, array(), [array()[:, a, :] for a in range(2)], {"left": array()[:, 0, :], "right": array()[:, 1, :]}]
    models = [meliora.Model.from_transitions(table, labels=LABELS, start=0) for table in tables]
    assert [permitted(model) for model in models] == [([1], [True, False])] * 4
    assert [model.actions for model in models] == [["a0", "a1"]] * 3 + [["left", "right"]]
    assert models[0].variables["state"].high == 3
    # A terminated transition enters state 2, so it is absorbing and has the label.
    assert set(models[0].labels) == {"one", "two", "three", "done"}
    assert set(models[1].labels) == {"one", "two", "three"}
    assert models[0].reach('"one"').pmax_positive.count() == 2


def test_scipy_matrices_are_read() -> None:
    sparse = pytest.importorskip("scipy.sparse", reason="needs scipy")
    for kind in (sparse.csr_matrix, sparse.coo_array):
        matrices = [kind(array()[:, a, :]) for a in range(2)]
        assert permitted(meliora.Model.from_transitions(matrices, labels=LABELS, start=0)) == ([1], [True, False])


def test_starts_are_numbers_booleans_or_a_distribution() -> None:
    starts: list[Any] = [None, 0, [0, 3], np.array([True, False, False, True]), [0.25, 0.0, 0.5, 0.25]]
    assert [meliora.Model.from_transitions(P, start=start).explore().initial.count() for start in starts] == [4, 1, 2, 2, 3]


def test_rewards_are_costs_of_states_or_actions() -> None:
    costs = {"time": [1, 1, 1, 1], "energy": [[3, 5], [0, 0], [0, 0], [0, 0]]}
    model = meliora.Model.from_transitions(P, costs, LABELS, 0, actions=["try", "give_up"])
    assert model.actions == ["try", "give_up"]
    cost = model.check(WISHES).values(reward="energy")[0]["levels"][0]["cost"]
    assert cost is not None and cost["lower"] == pytest.approx(3) and cost["upper"] == pytest.approx(3)


@pytest.mark.parametrize(
    ("table", "options", "message"),
    [
        ({0: {0: [(0.5, 0, 0, False)]}}, {}, "state 0, action a0: the probabilities sum to 0.5, not to 1"),
        ({0: {0: [(1.5, 0, 0, False), (-0.5, 0, 0, False)]}}, {}, "state 0, action a0: 1.5 is not a probability"),
        ({0: {0: [(1.0, 7, 0, False)]}}, {}, "state 0, action 0: 7 is not a state; states are the numbers from 0 to 0"),
        ({0: {0: [(1.0,)]}}, {}, "is not (probability, next state, reward, terminated)"),
        ({1: {0: [(1.0, 0, 0, False)]}}, {}, "state 1, action 0: 0 is not a state; states are 1"),
        ({"a": {"go": "b"}}, {}, "state a, action go: 'b' is not a state; states are 'a'"),
        ({"a\tb": {"go": "a\tb"}}, {}, "'a\\tb' cannot be the name of a state"),
        ({1: {"go": 1}, "1": {"go": 1}}, {}, "two states are called '1'"),
        (P, {"states": ["a", "b"]}, "there are 2 names for 4 states"),
        ([[[1.0, 0.0], [0.0, 1.0]], [[0.0, 1.0], [0.0, 1.0]]], {}, "may be (states, actions, states) or (actions"),
        ([[[1.0, 0.0]], [[1.0]]], {}, "the parts of nested lists have different lengths"),
        ({}, {}, "there is no state"),
        (np.zeros((2, 3)), {}, "has the shape (S, A, S) or (A, S, S), not (2, 3)"),
        ([np.eye(2), np.eye(3)], {}, "action a1: expected a matrix of the shape (2, 2), not (3, 3)"),
        ("text", {}, "not str"),
        (P, {"labels": {"goal": [4]}}, "label 'goal': 4 is not a state"),
        (P, {"labels": {"goal": [True]}}, "label 'goal': 1 values for 4 states"),
        (P, {"labels": {"a goal": [1]}}, "'a goal' cannot be the name of a label"),
        (P, {"start": []}, "start: there is no state in it"),
        (P, {"start": 9}, "start: 9 is not a state"),
        (P, {"actions": ["go"]}, "expected 2 action names, found go"),
        (P, {"rewards": {"time": [1]}}, "reward 'time': 1 values for 4 states"),
        (P, {"rewards": {"time": [[1], [1], [1], [1]]}}, "reward 'time': 1 values in state 0, for 2 actions"),
    ],
)
def test_a_wrong_table_is_refused_by_name(table: Any, options: dict[str, Any], message: str) -> None:
    with pytest.raises(meliora.UsageError) as raised:
        meliora.Model.from_transitions(table, **options)
    assert message in str(raised.value)


def test_nested_lists_are_read_where_arrays_are() -> None:
    matrices = [array()[:, a, :] for a in range(2)]
    tables: list[Any] = [array().tolist(), [m.tolist() for m in matrices], [matrices[0], matrices[1].tolist()]]
    tables.append({"left": matrices[0].tolist(), "right": matrices[1].tolist()})
    models = [meliora.Model.from_transitions(table, labels=LABELS, start=0) for table in tables]
    assert [permitted(model) for model in models] == [([1], [True, False])] * 4
    # Three equal lengths are told apart by the dictionary of actions.
    swap = {"stay": [[1, 0], [0, 1]], "swap": [[0, 1], [1, 0]]}
    model = meliora.Model.from_transitions(swap, start=0)
    assert model.actions == ["stay", "swap"] and model.reach("state = 1").pmax_one.count() == 2


#: A walk to the shop.
DAY: dict[str, dict[str, Any]] = {
    "home": {"walk": {"the shop": 0.75, "home": 0.25}, "rest": "home"},
    "the shop": {"buy": [(1.0, "done")]},
    "done": {"rest": "done"},
}


def test_states_have_the_names_of_a_dictionary() -> None:
    options: dict[str, Any] = {"labels": {"goal": ["done"]}, "start": "home", "rewards": {"time": {"home": 2}}}
    model = meliora.Model.from_transitions(DAY, **options)
    assert model.state() == {"state": "home"} and model.actions == ["walk", "rest", "buy"]
    for engine in ("symbolic", "explicit"):
        explored = model.explore(engine=engine)
        assert [s["state"] for s in explored.states.states(5)] == list(DAY)
        assert {"state": "the shop"} in explored.reach('"goal"').pmin_one
        assert explored.where(state="done").count() == 1
        assert explored.successors(model.state())["walk"] == [(0.25, {"state": "home"}), (0.75, {"state": "the shop"})]
    found = model.check(meliora.Preferences({"Goal": 'F "goal"'}))
    assert str(found.strategy(kind="plan").explain(model.state())).startswith("{'state': 'home'}")
    assert found.model.explore().reach('R{"time"}min=? [ F "goal" ]').value == pytest.approx((8 / 3, 8 / 3))
    again = pickle.loads(pickle.dumps(model))
    assert again.state() == model.state()
    with pytest.raises(meliora.Error):
        model.state(state="school")


def test_arrays_and_tuples_have_names_too() -> None:
    names = ["start", "one", "two", "three"]
    model = meliora.Model.from_transitions(array(), labels={**LABELS, "first": "one"}, start="start", states=names)
    assert model.state() == {"state": "start"}
    assert [s["state"] for s in model.reach('"first" | "three"').target.states(5)] == ["one", "three"]
    grid = {(x, y): {"right": (min(x + 1, 1), y), "up": {(x, 1): 1.0}} for x in range(2) for y in range(2)}
    walk = meliora.Model.from_transitions(grid, labels={"end": [(1, 1)]}, start=(0, 0))
    assert walk.state() == {"state": "(0, 0)"} and walk.reach('"end"').pmax_one.count() == 4


def test_a_model_of_a_table_can_be_pickled() -> None:
    model = meliora.Model.from_transitions(P, labels=LABELS, start=0)
    assert permitted(pickle.loads(pickle.dumps(model))) == ([1], [True, False])


def archive() -> bytes:
    """Returns a UMB archive of two states in a row."""
    system: dict[str, Any] = {"time": "discrete", "#players": 1, "#states": 2, "#initial-states": 1, "#choices": 2}
    system.update({"#choice-actions": 0, "#branches": 2, "#branch-actions": 0, "#observations": 0})
    index = {"format-version": 1, "format-revision": 0, "transition-system": system}
    files = {
        "index.json": json.dumps(index).encode(),
        "state-is-initial.bin": struct.pack("<Q", 1),
        "branch-to-target.bin": struct.pack("<2Q", 1, 1),
    }
    return packed(files)


def test_an_archive_is_read_from_a_path_or_bytes(tmp_path: Path) -> None:
    path = tmp_path / "two.umb"
    path.write_bytes(gzip.compress(archive()))
    read = [meliora.Model.from_umb(path), meliora.Model.from_umb(archive())]
    read += [pickle.loads(pickle.dumps(model)) for model in read]
    explored = [model.explore() for model in read]
    assert [found.states.count() for found in explored] == [2] * 4
    assert [found.reach("state = 1").pmax_one.count() for found in explored] == [2] * 4
    assert [model.name for model in read] == [str(path), "model"] * 2


def test_what_is_no_archive_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        meliora.Model.from_umb(tmp_path / "missing.umb")
    with pytest.raises(OSError, match="not a valid archive"):
        meliora.Model.from_umb(gzip.compress(b"not an archive"))
    with pytest.raises(OSError, match="not UTF-8"):
        meliora.Model.from_umb(b"\xff")
    with pytest.raises(TypeError):
        meliora.Model.from_umb(3)  # type: ignore[arg-type]


def test_infinite_bounds_are_floats() -> None:
    text = '{"value": {"lower": 1.5, "upper": "inf", "exact": "3/2"}, "state": {"lower": "inf", "x": 1}}'
    found = loads(text)
    assert found == {"value": {"lower": 1.5, "upper": math.inf, "exact": "3/2"}, "state": {"lower": "inf", "x": 1}}
