"""Analyses: regions, classes, levels, ranks, reports."""

from __future__ import annotations

import math
import pickle

import pytest

import meliora
from conftest import ENGINES, MODELS, Engine

np = pytest.importorskip("numpy")


def test_the_robot_of_the_paper(found: meliora.Analysis, robot: meliora.Model, engine: Engine) -> None:
    assert found.sasi.counts == [768, 98] and found.spi.counts == [1946, 1477, 1165, 1010, 1004]
    assert found.counts == {"states": 3600, "choices": 13888, "transitions": 18496, "deadlocks": 0, "initial": 1}
    assert found.improvement == {"states": 7200, "transitions": 35524, "dropped": 734}
    assert (found.engine, found.scope, found.safety, found.complete) == (engine, "all", "transition", True)
    assert found.model.name == robot.name and list(found.preferences.objectives) == list("ABCDEF")
    start = robot.state()
    assert (found.sasi.rank(start), found.spi.rank(start)) == (2, math.inf)
    assert found.most_preferred(start) == ()
    assert repr(found) == "<Analysis: SASI [768, 98], SPI [1946, 1477, 1165, 1010, 1004]>"
    assert set(found.usage) == {"peak_nodes", "bytes", "peak_rss_bytes"} and found.usage["bytes"] > 0


def test_objectives_have_regions(found: meliora.Analysis) -> None:
    for regions, counts in [
        (found.target, [144, 144, 144, 72, 72, 72]),
        (found.almost_sure, [624, 752, 512, 760, 256, 1204]),
        (found.positive, [2504, 2656, 2552, 1552, 1532, 1744]),
    ]:
        assert list(regions) == list("ABCDEF") and [region.count() for region in regions.values()] == counts
    assert found.target["A"] <= found.almost_sure["A"] <= found.positive["A"]


def test_classes_divide_the_states(found: meliora.Analysis, robot: meliora.Model) -> None:
    classes = found.classes
    assert len(classes) == 17 and classes[()].count() == 1057 and classes["D", "E", "F"].count() == 25
    assert sum(region.count() for region in classes.values()) == 3600
    both = classes["B", "C"].sample(3, seed=1)
    assert all(found.most_preferred(state) == ("B", "C") for state in both)
    # The states of the class achieve both objectives almost surely.
    assert classes["B", "C"] <= found.almost_sure["B"] & found.almost_sure["C"]


def test_objectives_achieved_together(found: meliora.Analysis) -> None:
    joint, classes = found.jointly(), found.classes
    assert list(joint) == list(classes) and joint["A",] == {} and any(joint.values())
    for members, sets in joint.items():
        for together, states in sets.items():
            assert 2 <= len(together) <= len(members) and set(together) <= set(members)
            assert states and states <= classes[members]
    told = {tuple(c["most_preferred"]): c.get("jointly") for c in found.to_dict()["classes"] or []}
    assert set(told) == set(joint) and not any(told.values())


def test_regions_have_names(found: meliora.Analysis) -> None:
    assert found.region("sasi:1") == found.sasi.regions[0] and found.region("class:nothing") == found.classes[()]
    assert found.region("almost-sure:A") == found.almost_sure["A"] and "spi:unbounded" in found.region_names
    with pytest.raises(meliora.UsageError, match="no region"):
        found.region("sasi:9")


def test_levels_and_ranks_fit(found: meliora.Analysis) -> None:
    sasi, spi = found.sasi, found.spi
    assert (sasi.kind, len(sasi), len(spi), sasi.complete) == ("sasi", 2, 5, True)
    everything = found.exploration.states
    assert sasi.at_least(0) == everything and sasi.at_least(1) == sasi.regions[0] and not sasi.at_least(3)
    assert spi.at_least(5) == spi.at_least(99) == spi.unbounded and spi.exactly(math.inf) == spi.unbounded
    assert sasi.unbounded is not None and sasi.unbounded.count() == 0
    ranks = [sasi.exactly(k) for k in range(3)]
    assert [region.count() for region in ranks] == [3600 - 768, 768 - 98, 98]
    assert not spi.exactly(5) and spi.exactly(4).count() == 6
    for k, region in enumerate(ranks):
        assert all(sasi.rank(state) == k for state in region.sample(5, seed=k))
    assert all(spi.rank(state) == math.inf for state in spi.exactly(math.inf).sample(5))
    for wrong in (-1, 0.5):
        with pytest.raises(meliora.UsageError):
            sasi.exactly(wrong)
    with pytest.raises(meliora.UsageError):
        sasi.at_least(-1)
    assert repr(sasi) == "<Levels of sasi: [768, 98]>"


def test_levels_are_a_sequence(found: meliora.Analysis) -> None:
    spi = found.spi
    assert spi[0] == spi.regions[0] and spi[-1] == spi.regions[4] and list(spi) == list(spi.regions)
    assert spi[1:3] == spi.regions[1:3]
    with pytest.raises(IndexError):
        spi[5]
    with pytest.raises(TypeError):
        spi["1"]  # type: ignore[call-overload]


def test_arrays_of_ranks(found: meliora.Analysis) -> None:
    for levels in (found.sasi, found.spi):
        expected = np.full((5, 5), np.nan)
        for state in found.exploration.states:
            cell = state["r"], state["c"]
            expected[cell] = np.fmax(expected[cell], levels.rank(state))
        ranks = levels.to_numpy("r", "c")
        assert ranks.shape == (5, 5) and ranks.dtype == float and np.array_equal(ranks, expected)
    full = found.sasi.to_numpy("r", "c", {"b": 8, "d": False, "e": False, "f": False, "ch": False})
    assert full[2, 2] == 2
    assert found.sasi.to_numpy(None, "b").shape == (9,)
    assert np.isnan(found.sasi.to_numpy("r", "c", {"b": 99})).all()


def test_reachable_states_are_the_scope_by_default(robot: meliora.Model, wishes: meliora.Preferences, engine: Engine) -> None:
    found = robot.check(wishes, safety="transition", engine=engine)
    assert found.scope == "reachable" and found.counts is not None and found.counts["states"] == 294
    assert found.sasi.counts == [63, 3] and found.spi.counts == [114, 75, 53, 51]
    obstacle = robot.state(r=0, c=2)
    assert obstacle not in found.exploration.states and found.sasi.rank(obstacle) == 0
    assert np.isnan(found.sasi.to_numpy("r", "c")[0, 2])


LINE = """mdp
module m
  x : [0..9] init 2;
  y : [0..9] init 0;
  [up] x<9 -> 1/2: (x'=x+1) + 1/2: (x'=0);
  [count] y<9 & x>5 -> (y'=y+1);
  [down] x=0 -> (x'=1);
endmodule
"""


@pytest.mark.parametrize(
    "question",
    ["x=5", "F x=5", "P>=1 [ F x=5 ]", "Pmax=? [ F x=5 ]", "Pmin=? [ F<=4 x=5 ]", "P>=0.2 [ x!=0 U x=5 ]", "Pmax=? [ G x<5 ]"],
)
def test_states_behind_a_target_can_be_left_out(question: str, engine: Engine) -> None:
    model = meliora.Model.from_string(LINE)
    whole = model.reach(question, engine=engine)
    part = model.reach(question, stop_at_target=True, engine=engine)
    assert (part.holds, part.value) == (whole.holds, whole.value)
    assert (part.pmax_one | ~part.pmax_one).count() < (whole.pmax_one | ~whole.pmax_one).count()
    for name in ["pmax_one", "pmax_positive", "pmin_one", "pmin_positive"]:
        few, all_states = getattr(part, name), getattr(whole, name)
        assert 0 < few.count() <= all_states.count() or few.count() == all_states.count() == 0
        initial = {"x": 2, "y": 0}
        assert few.where(**initial).count() == all_states.where(**initial).count()


def test_states_are_left_out_only_where_they_are_behind_a_target() -> None:
    model = meliora.Model.from_string(LINE)
    with pytest.raises(meliora.UsageError, match="every valuation is a state"):
        model.reach("x=5", stop_at_target=True, scope="all")
    with pytest.raises(meliora.InputError):
        model.reach("P>=1 [ G F x=5 ]", stop_at_target=True)
    with pytest.raises(meliora.InputError, match="unknown name"):
        model.reach("z=5", stop_at_target=True)


def test_a_model_without_an_initial_state_is_refused(engine: Engine) -> None:
    model = meliora.Model.from_string("mdp module m x : [0..3]; endmodule init x>3 endinit")
    with pytest.raises(meliora.InputError, match="no initial state"):
        model.explore(engine=engine)


def test_questions_that_are_not_supported_are_refused_by_name() -> None:
    explored = meliora.Model.from_string(LINE).explore()
    several = "multi(Pmax=? [ F x=1 ], Pmax=? [ F x=2 ])"
    for question in ["Smin=? [ x=1 ]", "E [ F x=1 ]", "A [ G x=1 ]", "filter(count, x=1)", several]:
        with pytest.raises(meliora.InputError, match="only one operator over a formula without other operators"):
            explored.reach(question)
    assert explored.reach('filter(forall, P>0 [ F x=1 ], "init")').holds is True


def test_the_engine_auto_is_the_first_to_know_all_states() -> None:
    small = meliora.Model.from_file(MODELS / "chain.prism", constants={"N": 4})
    bits = range(40)
    declared = "".join(f" b{i} : bool init false;" for i in bits)
    large = meliora.Model.from_string(
        f"mdp\nmodule m\n{declared}\n" + "".join(f" [] true -> (b{i}'=!b{i});\n" for i in bits) + "endmodule"
    )
    assert small.explore(engine="auto").engine == "explicit"
    assert large.explore(engine="auto").engine == "symbolic"
    # An order is one of diagrams.
    assert small.explore(engine="auto", order="declared").engine == "symbolic"
    assert small.check(MODELS / "chain.pref", engine="auto").engine == "explicit"
    with pytest.raises(meliora.UsageError, match='"auto", "symbolic", "explicit"'):
        small.explore(engine="quick")  # type: ignore[arg-type]


def test_safety_and_levels_can_be_chosen(robot: meliora.Model, engine: Engine) -> None:
    path = MODELS / "robot5x5.pref"
    explored = robot.explore(scope="all", engine=engine)
    assert explored.check(path, safety="action").sasi.counts == [760, 96]
    prefix = explored.check(path)
    assert prefix.sasi.counts == [285] and prefix.safety == "prefix"
    assert prefix.spi.counts == [955, 246] and prefix.improvement is None
    cut = explored.check(path, safety="transition", max_level=1)
    assert cut.sasi.counts == [768] and not cut.sasi.complete and cut.complete
    assert cut.sasi.unbounded is None and cut.sasi.rank(robot.state()) == 1
    with pytest.raises(meliora.UsageError, match="not searched"):
        cut.sasi.at_least(2)
    # Regions of one exploration can be combined.
    assert cut.sasi.regions[0] >= explored.check(path).sasi.regions[0]
    for wrong in ({"safety": "none"}, {"max_level": 0}):
        with pytest.raises(meliora.UsageError):
            explored.check(path, **wrong)


def test_objectives_over_whole_paths_have_monitors(toy: meliora.Model, engine: Engine) -> None:
    wishes = meliora.Preferences({"Both": "F (s=5 & F s=1)", "Third": "F s=3"}, ["Third > Both"])
    assert wishes.history == "play" and wishes.warnings == []
    found = toy.check(wishes, engine=engine)
    state = found.exploration.initial.states()[0]
    assert len(state) > len(toy.variables) and state["s"] == 0
    assert found.counts is not None and found.counts["model_states"] == 6
    both = found.to_dict()["objectives"][0]
    assert both["observer"] > 1
    assert found.to_dict()["history"] == "play"
    # Some path goes through 5 to 1, but no strategy achieves this almost surely.
    assert found.positive["Both"].count() > found.almost_sure["Both"].count()
    assert found.strategy("spi").explain(state).actions


def test_preferences_that_prefer_nothing_have_a_warning() -> None:
    [warning] = meliora.Preferences({"A": "F s=1", "B": "F s=2"}).warnings
    assert warning.startswith("preferences prefers no objective to another: only gaining a first objective")


def test_reports_in_many_forms(found: meliora.Analysis, engine: Engine) -> None:
    report = found.to_dict()
    assert report["schema"] == "meliora.check/1" and report["sasi"] is not None and report["sasi"]["levels"] == ["768", "98"]
    assert report["initial"][0]["sasi_actions"] == ["N"] and report["engine"] == engine
    assert "SASI" in found.to_text() and found.to_svg().startswith("<svg")
    if engine == "explicit":
        with pytest.raises(meliora.UsageError, match="decision diagrams"):
            found.to_svg("sasi")
        return
    assert found.to_svg("sasi", grid=("r", "c")).startswith("<svg")
    assert found.to_html(grid=["r", "c"]).lower().startswith("<!doctype html")
    for wrong in ({"picture": "photo"}, {"grid": ["z"]}, {"grid": ["r", "c", "b"]}):
        with pytest.raises(meliora.UsageError):
            found.to_svg(**wrong)


def test_analyses_and_levels_are_not_pickled(found: meliora.Analysis) -> None:
    for thing in (found, found.sasi, found.strategy("sasi"), found.strategy("spi").play(found.model.state())):
        with pytest.raises(TypeError, match="cannot be pickled"):
            pickle.dumps(thing)
    assert pickle.loads(pickle.dumps(found.to_dict())) == found.to_dict()


def test_both_engines_agree_on_everything(robot: meliora.Model, wishes: meliora.Preferences) -> None:
    one, other = (robot.check(wishes, scope="all", engine=engine) for engine in ENGINES)
    assert one.region_names == other.region_names
    for name in one.region_names:
        assert list(one.region(name)) == list(other.region(name)), name


def test_the_engine_auto_answers_whole_questions(robot: meliora.Model) -> None:
    wishes = MODELS / "robot5x5.pref"
    one, raced = robot.check(wishes), robot.check(wishes, engine="auto")
    assert raced.complete and raced.engine in ("symbolic", "explicit")
    assert raced.counts == one.counts
    for part in ("objectives", "classes", "sasi", "spi", "initial"):
        assert raced.to_dict()[part] == one.to_dict()[part]
    target = "r=2 & c=2"
    for stops in (False, True):
        found = [robot.reach(target, stop_at_target=stops, engine=name) for name in ("symbolic", "auto")]
        assert found[0].pmax_one.count() == found[1].pmax_one.count()
    with pytest.raises(meliora.InputError):
        robot.check(meliora.Preferences.from_string("objective A = F nothing=1;"), engine="auto")
