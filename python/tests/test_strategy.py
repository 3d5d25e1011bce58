"""Strategies, runs and simulations."""

from __future__ import annotations

import math
from typing import Any

import pytest

import meliora
from conftest import ENGINES, MODELS, Engine

np = pytest.importorskip("numpy")


def test_a_strategy_says_what_to_do_and_why(found: meliora.Analysis, robot: meliora.Model) -> None:
    strategy, start = found.strategy("sasi"), robot.state()
    assert strategy.kind == "sasi" and strategy.actions(start) == ["N"]
    assert strategy.actions(start, "progress") == ["N"] and strategy.actions(start, which="kept") == ["N", "S"]
    assert found.strategy("spi").actions(start) == ["N", "S"]
    assert strategy.successors(start)["N"] == [(1.0, robot.state(r=3, b=7))]
    why = strategy.explain(start)
    assert (why.state, why.most_preferred, why.rank, why.progress_action) == (start, (), 2, "N")
    north, south = why.actions
    assert (north.name, north.kept, north.permitted, north.progress, north.verdict) == ("N", True, True, True, "approaches")
    assert south.verdict == "strays" and "2 improvements are not guaranteed" in south.reason
    there = north.successors[0]
    assert (there.state, there.probability, there.rank) == (robot.state(r=3, b=7), 1.0, 2)
    assert (there.change, there.gained, there.lost, there.dropped, there.goal) == ("lateral", (), (), False, False)
    assert "* N" in str(why) and "permitted N" in repr(why) and "not permitted" in repr(south)
    assert math.isinf(found.spi.strategy().explain(start).rank)


def test_masks_are_in_the_order_of_actions(found: meliora.Analysis, robot: meliora.Model) -> None:
    strategy, start = found.strategy("sasi"), robot.state()
    mask = strategy.mask(start)
    assert mask.dtype == bool and mask.tolist() == [True, False, False, False]
    assert strategy.mask(start, ["S", "N"], which="kept").tolist() == [True, True]
    assert strategy.mask(start, actions=["nowhere"]).tolist() == [False]
    with pytest.raises(meliora.UsageError, match="which"):
        strategy.mask(start, which="best")  # type: ignore[arg-type]


def test_states_outside_of_the_scope_are_refused(toy: meliora.Model, toy_wishes: meliora.Preferences, engine: Engine) -> None:
    strategy = toy.check(toy_wishes, engine=engine).strategy("sasi")
    assert strategy.actions(toy.state()) == ["b", "c"]
    for method in (strategy.actions, strategy.successors, strategy.explain, strategy.mask, strategy.play, strategy.simulate):
        with pytest.raises(meliora.UsageError, match="not a state of the scope"):
            method(toy.state(lost=True))
    with pytest.raises(meliora.UsageError, match="kind"):
        toy.check(toy_wishes).strategy("best")  # type: ignore[arg-type]


def test_a_play_remembers_what_counts(found: meliora.Analysis, robot: meliora.Model) -> None:
    play = found.strategy("sasi").play(robot.state())
    assert (play.state, play.ahead, play.improvements, play.over) == (robot.state(), 2, 0, False)
    assert play.actions() == ["N"] and play.mask().tolist() == [True, False, False, False]
    with pytest.raises(meliora.UsageError, match="no enabled action leads"):
        play.step(robot.state(r=4, c=4))
    steps = 0
    while not play.over:
        action = play.actions("progress")[0]
        successors = next(a.successors for a in play.explain().actions if a.name == action)
        play.step(successors[steps % len(successors)].state)
        steps += 1
        assert steps < 100
    # The strategy guarantees two improvements.
    assert play.improvements >= 2 and play.actions() == [] and not play.mask().any() and play.ahead == 0
    assert "Play at" in repr(play)


def test_plays_are_arrays(found: meliora.Analysis, robot: meliora.Model) -> None:
    strategy = found.strategy("sasi")
    plays = strategy.simulate(robot.state(), runs=40, seed=1, picks="permissive")
    longest = int(plays.lengths.max())
    assert len(plays) == 40 and plays.rank == 2 and plays.variables == list(robot.variables)
    assert plays.states.shape == (40, longest + 1, 7) and plays.states.dtype == np.int64
    assert plays.actions.shape == plays.improves.shape == (40, longest)
    assert (plays.states[:, 0] == list(robot.state().values())).all()
    assert sum(plays.improvements.values()) == 40 and min(plays.improvements) >= 2
    assert (plays.improves.sum(axis=1) >= 2).all() and plays.settled == 40
    for run, length in enumerate(plays.lengths):
        assert (plays.actions[run, :length] >= 0).all() and (plays.actions[run, length:] == -1).all()
        assert (plays.states[run, length:] == plays.states[run, length]).all()
        for step in range(length):
            state = {name: type(robot.state()[name])(value) for name, value in zip(plays.variables, plays.states[run, step])}
            after = dict(zip(plays.variables, plays.states[run, step + 1]))
            reached = strategy.successors(state)[plays.action_names[plays.actions[run, step]]]
            assert after in [successor for _, successor in reached]
    # The paper's definition ignores branches that weaken; the robot may take them.
    assert plays.weakened_step > 0 and plays.weakened_start == 0
    assert "40 plays" in repr(plays)


def test_what_is_safe_never_weakens(robot: meliora.Model, wishes: meliora.Preferences, engine: Engine) -> None:
    def plays(safety: Any) -> Any:
        found = robot.check(wishes, safety=safety, engine=engine)
        return found.strategy("spi").simulate(robot.state(), runs=100, steps=50)

    assert (plays("action").weakened_step, plays("prefix").weakened_start) == (0, 0)


def test_a_seed_means_the_same_plays(robot: meliora.Model, wishes: meliora.Preferences) -> None:
    one, other = (robot.check(wishes, engine=engine).strategy("spi") for engine in ENGINES)
    start = robot.state()
    plays = [s.simulate(start, runs=5, steps=20, seed=7, picks="progress") for s in (one, one, other)]
    assert all((plays[0].states == p.states).all() for p in plays[1:])
    assert plays[0].states.shape != (c := one.simulate(start, runs=5, steps=20, seed=8)).states.shape or (plays[0].states != c.states).any()
    assert one.simulate(start, runs=0).states.shape == (0, 1, 7)
    with pytest.raises(meliora.UsageError, match="picks"):
        one.simulate(start, picks="best")  # type: ignore[arg-type]


def test_simulations_have_the_defaults_of_the_command_line(robot: meliora.Model, wishes: meliora.Preferences) -> None:
    strategy, start = robot.check(wishes).strategy("sasi"), robot.state()
    default = strategy.simulate(start)
    named = strategy.simulate(start, runs=1000, steps=1000, seed=1, picks="progress")
    assert len(default) == 1000 and np.array_equal(default.states, named.states)


def test_explanations_count_one_improvement(toy: meliora.Model, toy_wishes: meliora.Preferences) -> None:
    strategy = toy.check(toy_wishes).strategy("sasi")
    assert ": 1 improvement ahead\n" in str(strategy.explain(toy.state()))
    assert ": 0 improvements ahead\n" in str(strategy.explain(toy.state(s=3)))


def test_monitors_add_no_actions_and_need_no_values(toy: meliora.Model, engine: Engine) -> None:
    wishes = meliora.Preferences({"Both": "F (s=5 & F s=1)", "Third": "F s=3"}, ["Third > Both"])
    found = toy.check(wishes, engine=engine)
    (initial,) = found.exploration.initial.states()
    start = toy.state()
    assert len(initial) > len(start)
    for levels in (found.sasi, found.spi):
        assert levels.rank(start) == levels.rank(initial)
        assert levels.strategy().mask(start).shape == (len(toy.actions),)
        assert levels.strategy().actions(start) == levels.strategy().actions(initial)
    assert start in found.exploration.initial and found.most_preferred(start) == found.most_preferred(initial)
    with pytest.raises(meliora.UsageError, match="no value for `s`"):
        found.sasi.rank({"lost": False})
    with pytest.raises(meliora.UsageError, match="no variable `z`"):
        found.sasi.rank({**start, "z": 1})


@pytest.fixture(scope="module")
def drone() -> meliora.Analysis:
    return meliora.Model.from_file(MODELS / "drone.prism").check(MODELS / "drone.pref")


def test_values_are_those_of_the_command_line(drone: meliora.Analysis) -> None:
    first = drone.values(exact=True, within=2)[0]
    assert first["state"] == {"at": 0} and first["most_preferred"] == ["Shore"]
    assert (first["sasi_rank"], first["spi_rank"]) == (1, 2)
    assert first["number"] is not None and first["number"]["exact"] == "7/6"
    one, two = first["levels"]
    assert one["cost"] is not None and one["cost"]["exact"] == "1" and two["cost"] is None
    likely = two["probability"]
    assert likely is not None and likely["exact"] == "1/6" and likely["lower"] == pytest.approx(1 / 6)
    assert [a["action"] for a in one["actions"]] == ["survey", "shore"]
    assert first["within"] is not None and len(first["within"]) == 3
    assert [v["state"]["at"] for v in drone.values([{"at": 3}, {"at": 0}], levels=1)] == [3, 0]
    with pytest.raises(meliora.UsageError, match="not a state of the scope"):
        drone.values([{"at": 7}])
    with pytest.raises(meliora.UsageError, match="no reward structure `fuel`"):
        drone.values(reward="fuel")


def test_a_strategy_by_value_attains_it(drone: meliora.Analysis) -> None:
    base = {"at": 0}
    likely, cheap = drone.strategy(choose="likely"), drone.strategy("sasi", choose="cheap")
    assert (likely.kind, likely.choose, cheap.choose, drone.strategy().choose) == ("spi", "likely", "cheap", "first")
    assert likely.actions(base, "chosen") == ["survey"] == cheap.actions(base, "chosen")
    attained = likely.attains(base)
    assert attained is not None and attained["improvements"] == 2 and attained["cost"] is None
    assert drone.strategy().attains(base) is None and drone.strategy().simulate(base, runs=5).value is None
    value = likely.simulate(base, runs=2000).value
    assert value is not None and value["agrees"] and value["confidence"] == 0.99
    interval = value["probability_interval"]
    assert interval["lower"] <= 1 / 6 <= interval["upper"]
    assert cheap.simulate(base, runs=50).value["measured_cost"] == 1.0  # type: ignore[index]


def test_choices_that_do_not_fit_are_refused(drone: meliora.Analysis) -> None:
    with pytest.raises(meliora.UsageError, match='choose="likely" is for kind="spi"'):
        drone.strategy("sasi", choose="likely")
    with pytest.raises(meliora.UsageError, match="choose="):
        drone.strategy(choose="best")  # type: ignore[arg-type]
    with pytest.raises(meliora.UsageError, match="takes all permitted actions"):
        drone.strategy(choose="cheap").simulate({"at": 0}, picks="permissive")
    from_wreck = drone.strategy(choose="likely", states=[{"at": 3}])
    assert from_wreck.attains({"at": 3}) is not None
    with pytest.raises(meliora.UsageError, match="were not computed"):
        from_wreck.attains({"at": 0})
    with pytest.raises(meliora.UsageError, match="were not computed"):
        from_wreck.actions({"at": 0})


def test_a_plan_improves_and_then_achieves(found: meliora.Analysis, robot: meliora.Model) -> None:
    plan, start = found.strategy("plan"), robot.state()
    assert plan.kind == "plan" and plan.actions(start) == ["N"] and plan.explain(start).pursues is None
    runs = plan.simulate(start, runs=200)
    assert runs.achieved_runs == 200 == runs.settled
    assert set(runs.achieved) == {"B", "C"}
    first = np.stack(list(runs.achieved.values())).max(axis=0)
    assert (first >= 0).all() and (first <= runs.lengths).all()
    sasi = found.strategy("sasi").simulate(start, runs=5)
    assert sasi.achieved == {} and sasi.achieved_runs is None
    play = plan.play(start)
    rng = np.random.default_rng(1)
    while not play.over:
        successors = plan.successors(play.state)[play.actions("chosen")[0]]
        play.step(successors[rng.choice(len(successors), p=[p for p, _ in successors])][1])
    assert play.pursues in play.explain().achieved


def test_an_objective_is_achieved(drone: meliora.Analysis) -> None:
    shore = drone.strategy("achieve", objective="Shore")
    why = shore.explain({"at": 0})
    assert (why.pursues, why.progress_action, why.achieved) == ("Shore", "shore", ())
    assert shore.mask({"at": 0}, ["shore", "survey"]).tolist() == [True, False]
    with pytest.raises(meliora.UsageError, match="needs an objective; there are"):
        drone.strategy("achieve")
    with pytest.raises(meliora.UsageError, match="no objective is called `Moon`"):
        drone.strategy("plan", objective="Moon")
    with pytest.raises(meliora.UsageError, match="takes no objective"):
        drone.strategy("sasi", objective="Shore")


def test_a_plan_names_what_it_gives_up(engine: Engine) -> None:
    text = """mdp module m s : [0..6] init 0;
        [left] s=0 -> (s'=1); [right] s=0 -> (s'=2); [c] s=1 -> (s'=3); [b] s=1 -> (s'=4);
        [d] s=2 -> (s'=5); [a] s=2 -> (s'=6); endmodule"""
    model = meliora.Model.from_string(text)
    wishes = meliora.Preferences({"A": "F s=6", "B": "F s=4", "C": "F s=3", "D": "F s=5"}, ["C > A", "D > B"])
    plan = model.check(wishes, engine=engine).strategy("plan")
    runs = plan.simulate(model.state(), runs=10)
    assert runs.commits == [{"objective": "C", "gives_up": ["D"], "runs": 10}]
    assert (runs.weakened_step, runs.weakened_start, runs.achieved_runs, runs.kept_runs) == (0, 0, 10, 0)
    at = plan.explain(model.state())
    assert at.commits and at.pursues == "C" and at.actions[0].reason == "comes closer to C; gives up D"
    play = plan.play(model.state())
    play.step({"s": 1})
    assert play.pursues == "C" and play.explain().commits and play.actions() == ["c"]


def test_objectives_that_go_together_and_one_that_is_not_sure() -> None:
    drone = meliora.Model.from_file(MODELS / "drone.prism").check(MODELS / "drone.pref")
    base = drone.model.state()
    likely = drone.strategy("achieve", objective="Cabin", choose="likely")
    value = likely.attains(base)
    assert value is not None and value["objective"] == "Cabin"
    assert value["probability"]["lower"] <= 1 / 6 <= value["probability"]["upper"]
    assert likely.actions(base, "chosen") == ["survey"]
    measured = likely.simulate(base, runs=2000, seed=1).value
    assert measured is not None and measured["agrees"]
    with pytest.raises(meliora.UsageError, match="choose='cheap'|choose=\"cheap\""):
        drone.strategy("achieve", objective="Cabin", choose="cheap")
    with pytest.raises(meliora.UsageError, match="are about improvements"):
        drone.strategy("achieve", objective="Cabin", choose="likely", levels=2)

    toy = meliora.Model.from_string(
        "mdp module m x : [0..4] init 2; [left] x>0 -> (x'=x-1); [right] x<4 -> (x'=x+1); endmodule"
    )
    found = toy.check(meliora.Preferences({"C": "F x=0", "D": "F x=4"}))
    both = found.strategy("achieve", objective="C,D")
    play = both.play({"x": 2})
    assert play.pursues == "C and D"
    for x in (1, 0, 1, 2, 3):
        play.step({"x": x})
    assert play.explain().left == ("D",) and play.actions("chosen") == ["right"] and not play.over
    play.step({"x": 4})
    assert play.over
    runs = both.simulate({"x": 2}, runs=10)
    assert runs.achieved["C"].shape == runs.achieved["D"].shape == (10,)


def test_runs_without_a_step_say_why_their_arrays_are_empty() -> None:
    text = "mdp\nmodule m\n x : [0..2] init 0;\n [try] x=0 -> 0.5: (x'=1) + 0.5: (x'=2);\n [stay] x>0 -> true;\nendmodule\n"
    model = meliora.Model.from_string(text)
    found = model.check(meliora.Preferences({"B": "F x=1"}))
    sasi, spi = found.strategy("sasi").simulate({"x": 0}, runs=3), found.strategy("spi").simulate({"x": 2}, runs=3)
    assert sasi.actions.shape == (3, 0) and "kind=\"spi\"" in str(sasi.reason) and str(sasi.reason) in repr(sasi)
    assert spi.reason == "no improvement is possible from the start"
    assert found.strategy("spi").simulate({"x": 0}, runs=3).reason is None
    plan = found.strategy(kind="plan").simulate({"x": 1}, runs=3)
    assert plan.reason == "the pursued objective is achieved in the start"
