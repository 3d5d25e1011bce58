"""Explorations and regions as values."""

from __future__ import annotations

import pickle
from typing import Any

import pytest

import meliora
from conftest import MODELS, Engine

np = pytest.importorskip("numpy")


@pytest.fixture(scope="module")
def explored(robot: meliora.Model, engine: Engine) -> meliora.Exploration:
    return robot.explore(scope="all", engine=engine)


def test_an_exploration_knows_its_states(robot: meliora.Model, explored: meliora.Exploration, engine: Engine) -> None:
    assert explored.counts == {"states": 3600, "choices": 13888, "transitions": 18496, "deadlocks": 0, "initial": 1}
    assert (explored.engine, explored.scope, explored.model.name) == (engine, "all", robot.name)
    assert explored.states.count() == 3600 and not explored.deadlocks
    assert explored.initial.states() == [robot.state()]
    assert (explored.order is None) == (engine == "explicit")
    assert "3600 states" in repr(explored)


def test_regions_are_values(explored: meliora.Exploration) -> None:
    low, left = explored.where("r < 2"), explored.where({"c": 0})
    everything, nothing = explored.states, low - low
    assert low.count() == 3600 * 2 // 5 and left == explored.where("c = 0") == explored.where(c=0)
    assert (low & left).count() == 3600 * 2 // 25
    assert low | left == left | low and low ^ left == (low | left) - (low & left)
    assert ~low == everything - low and ~~low == low and ~everything == nothing
    assert low & left <= low < everything and everything > low >= low and not low <= left
    assert low != left and not low == left and low != 3
    assert bool(low) and not nothing and nothing.count() == 0 and nothing.states() == []
    assert low.where(c=0) == low & left and low.where(r=4) == nothing == low.where(r=17)
    with pytest.raises(TypeError):
        low < 3  # type: ignore[operator]
    with pytest.raises(TypeError):
        hash(low)


def test_a_region_is_chosen_by_a_condition_or_by_values(explored: meliora.Exploration) -> None:
    for arguments, values in [((), {}), (("r < 2",), {"c": 0})]:
        with pytest.raises(meliora.UsageError, match="either a condition or values"):
            explored.where(*arguments, **values)
    with pytest.raises(meliora.UsageError):
        explored.where(nowhere=0)


def test_states_are_members(robot: meliora.Model, explored: meliora.Exploration) -> None:
    low = explored.where("r < 2")
    assert robot.state(r=1) in low and robot.state() not in low
    assert {**robot.state(), "r": 99} not in low
    assert dict(robot.state(r=1), r=np.int64(1), d=np.bool_(False)) in low
    with pytest.raises(meliora.UsageError, match="no value for `c`"):
        {"r": 1} in low
    with pytest.raises(meliora.UsageError, match="no variable `z`"):
        {**robot.state(), "z": 1} in low
    with pytest.raises(meliora.UsageError, match="dictionary"):
        3 in low  # type: ignore[operator]


def test_regions_are_gone_through_in_the_order_of_values(explored: meliora.Exploration) -> None:
    region = explored.where("r < 2 & b > 6")
    all_states = list(region)
    assert len(all_states) == region.count() and all(state in region for state in all_states)
    values = [tuple(state.values()) for state in all_states]
    assert values == sorted(set(values))
    assert region.states(7) == all_states[:7] and region.states(0) == []
    assert next(iter(region)) == all_states[0]
    several = [iter(region), iter(region)]
    assert [next(one) for one in several] == [all_states[0]] * 2


def test_states_are_drawn_at_random(explored: meliora.Exploration) -> None:
    region = explored.where("r < 2")
    drawn = region.sample(50, seed=3)
    assert len({tuple(state.values()) for state in drawn}) == 50 and all(state in region for state in drawn)
    assert drawn == region.sample(50, seed=3) != region.sample(50, seed=4)
    assert len(region.sample()) == 1 and region.sample(0) == []
    count = region.count()
    assert sorted(tuple(s.values()) for s in region.sample(count, seed=1)) == [tuple(s.values()) for s in region]
    with pytest.raises(meliora.UsageError, match="cannot be drawn"):
        region.sample(count + 1)
    # Two of five columns: 400 of 1000 draws are expected; a deviation above 100 has a probability below 10^-9.
    left = sum(state["c"] < 2 for state in explored.states.sample(1000, seed=5))
    assert abs(left - 400) < 100


def test_counts_have_any_size() -> None:
    lines = [f"module m{i} x{i} : [0..9]; [] true -> (x{i}'=mod(x{i}+1, 10)); endmodule" for i in range(40)]
    explored = meliora.Model.from_string("\n".join(["mdp", *lines])).explore()
    assert explored.states.count() == 10**40 == explored.counts["states"]
    half = explored.where("x7 < 5")
    assert half.count() == 5 * 10**39 and len(half.states(3)) == 3 and len(half.sample(20)) == 20
    one = next(iter(half))
    assert one in half and all(value == 0 for value in one.values())


def test_arrays_show_where_a_region_is(explored: meliora.Exploration) -> None:
    region = explored.where("r + c = b & d | r = 4 & c = 1")
    expected = np.zeros((5, 5), dtype=bool)
    for state in region:
        expected[state["r"], state["c"]] = True
    picture = region.to_numpy("r", "c")
    assert picture.dtype == bool and picture.shape == (5, 5) and (picture == expected).all()
    assert (region.to_numpy("c", "r") == expected.T).all()
    fixed = region.to_numpy("r", "c", {"d": True, "b": 3})
    assert fixed.sum() == 5 and fixed[4, 1] and fixed[0, 3] and not fixed[3, 1]
    assert region.to_numpy("r", "c", where={"b": 99}).sum() == 0
    assert region.to_numpy(None, "r").tolist() == expected.any(axis=1).tolist()
    picture[0, 0] = not picture[0, 0]
    for wrong, arguments in [("no variable", ("r", "z")), ("both row", ("r", "r")), ("cannot fix", ("r", "c", {"r": 1}))]:
        with pytest.raises(meliora.UsageError, match=wrong):
            region.to_numpy(*arguments)  # type: ignore[arg-type]


def test_other_packages_read_diagrams(explored: meliora.Exploration, engine: Engine) -> None:
    region = explored.where("r < 2 & (d | b = 3)")
    if engine == "explicit":
        for export in (region.to_dddmp, region.to_dot, region.to_dd):
            with pytest.raises(meliora.UsageError, match="decision diagrams"):
                export()
        return
    assert region.to_dddmp().startswith(".ver DDDMP-2.0") and region.to_dot().startswith("digraph")
    pytest.importorskip("dd")
    function = region.to_dd()
    manager = function.bdd
    # Bit patterns that are not values belong to no region.
    assert manager.count(function, nvars=len(explored.order or [])) == region.count()
    other = (~region).to_dd(manager)
    everything = explored.states.to_dd(manager)
    assert function | other == everything and function & other == manager.false


def test_regions_of_different_explorations_do_not_go_together(robot: meliora.Model, explored: meliora.Exploration) -> None:
    other = robot.explore(scope="all")
    assert explored.states != other.states
    for operation in ("__and__", "__or__", "__sub__", "__xor__", "__le__"):
        with pytest.raises(meliora.UsageError, match="different explorations"):
            getattr(explored.states, operation)(other.states)
    with pytest.raises(meliora.UsageError, match="another exploration"):
        explored.reach(other.states)


def test_targets_are_reached(robot: meliora.Model, explored: meliora.Exploration, engine: Engine) -> None:
    found = explored.reach("r=2 & c=4 & d")
    regions = found.target, found.pmax_one, found.pmax_positive, found.pmin_one, found.pmin_positive
    assert [region.count() for region in regions] == [72, 760, 1552, 72, 72]
    assert explored.reach(found.target).pmax_one == found.pmax_one
    assert explored.reach({"r": 2, "c": 4, "d": True}).pmax_one == found.pmax_one
    assert robot.reach("r=2 & c=4 & d", scope="all", engine=engine).pmax_positive.count() == 1552
    assert "72 states" in repr(found)
    with pytest.raises(meliora.InputError, match="unknown name") as caught:
        explored.reach("q = 1")
    assert caught.value.file == "condition"


def test_temporal_properties_are_answered(toy: meliora.Model, engine: Engine) -> None:
    explored = toy.explore(engine=engine)
    plain = explored.reach("s=3")
    for text, holds in [("F s=3", None), ("P>=1 [ F s=3 ]", False), ("Pmax>0 [ F s=3 ]", True)]:
        found = explored.reach(text)
        assert (found.target, found.pmax_one, found.pmin_positive) == (plain.target, plain.pmax_one, plain.pmin_positive)
        assert found.holds is holds
    assert plain.holds is None
    # The first step goes to 1 or 5, and from 5 to 1: no state is visited twice before.
    for text, holds in [("G F s=1", None), ("Pmax>=1 [ G F s=1 ]", True), ("P>=1 [ G F s=1 ]", False)]:
        found = explored.reach(text)
        assert [state["s"] for state in found.pmax_one.states()] == [0, 1, 5]
        assert [state["s"] for state in found.pmin_one.states()] == [1, 5] and found.holds is holds
    assert toy.reach("Pmax>=1 [ F (s=5 & F s=1) ]", engine=engine).holds is False
    for wrong, line in [("F q=1", "unknown name"), ("F s=", "expected an expression"), ("P>=1 [ F s=3", "expected `]`")]:
        with pytest.raises(meliora.InputError, match=line):
            explored.reach(wrong)


def test_properties_about_numbers_have_values(toy: meliora.Model, engine: Engine) -> None:
    explored = toy.explore(engine=engine)
    # `b` and `c` lead to 3 half of the time.
    best = explored.reach("Pmax=? [ F s=3 ]")
    assert best.holds is None and best.value == (0.5, 0.5)
    assert explored.reach("Pmin=? [ F s=3 ]").value == (0.0, 0.0)
    assert explored.reach("P<=0.5 [ F s=3 ]").holds is True
    assert explored.reach("P>=0.25 [ F s=3 ]").holds is False
    assert explored.reach("P>=1 [ F s=3 ]").value is None and explored.reach("s=3").value is None


def test_regions_and_explorations_are_not_pickled(explored: meliora.Exploration) -> None:
    for thing in (explored, explored.states):
        with pytest.raises(TypeError, match="cannot be pickled"):
            pickle.dumps(thing)


def test_values_may_have_names() -> None:
    model = meliora.Model.from_file(MODELS / "workshop.jani", constants={"N": 2})
    states = model.explore().states.states(3)
    named = [name for name, variable in model.variables.items() if variable.values]
    assert named and all(isinstance(states[0][name], str) for name in named)
    assert all(state in model.explore().states for state in states)


def test_the_order_of_bits_can_be_given(robot: meliora.Model) -> None:
    names = ["ch", "f", "e", "d", "b", "c", "r"]
    explored = robot.explore(order=names)
    assert explored.order is not None and explored.order[0] == "ch" and explored.order[-1] == "r.0"
    declared = robot.explore(order="declared").order
    assert declared is not None and declared[0] == "r.2"
    assert explored.states.count() == robot.explore().states.count() == 294
    with pytest.raises(meliora.InputError) as caught:
        robot.explore(order=["ch", "nowhere"])
    assert caught.value.file == "order"
    mistakes: list[dict[str, Any]] = [
        {"order": "upwards"}, {"order": "declared", "engine": "explicit"}, {"engine": "quantum"}, {"scope": "some"}
    ]
    for wrong in mistakes:
        with pytest.raises(meliora.UsageError):
            robot.explore(**wrong)
