"""Models and preferences: reading, properties, errors, pickling."""

from __future__ import annotations

import gzip
import json
import pickle
import struct
from fractions import Fraction
from pathlib import Path

import pytest

import meliora
from conftest import MODELS, TOY, WISHES, packed


def test_a_model_says_what_it_has(robot: meliora.Model) -> None:
    assert robot.kind == "mdp"
    assert robot.name.endswith("robot5x5.prism") and "module robot" in robot.text
    assert list(robot.variables) == ["r", "c", "b", "d", "e", "f", "ch"]
    row, flag = robot.variables["r"], robot.variables["d"]
    assert (row.name, row.type, row.low, row.high, row.initial, row.values) == ("r", "int", 0, 4, 2, [])
    assert (flag.type, flag.initial) == ("bool", False)
    assert repr(row) == 'Variable("r", 0..4)' and repr(flag) == 'Variable("d", bool)'
    assert robot.constants == {"full": 8}
    assert robot.actions == ["N", "S", "E", "W"]
    assert robot.labels == [] and robot.warnings == []
    assert "7 variables" in repr(robot)


def test_constants_are_given_by_name(toy: meliora.Model) -> None:
    assert toy.constants == {"last": 5} and toy.labels == ["middle"]
    text = "mdp const double p; const bool on; const int n; module m x : [0..n]; [] on -> p: (x'=0) + 1-p: (x'=n); endmodule"
    model = meliora.Model.from_string(text, constants={"p": 0.25, "on": True, "n": 3})
    assert model.constants == {"p": 0.25, "on": True, "n": 3}
    with pytest.raises(meliora.UsageError, match="constants are bools, ints, floats and fractions"):
        meliora.Model.from_string(text, constants={"p": "x"})  # type: ignore[dict-item]


def test_fractions_are_exact_constants() -> None:
    """A third as a float is below 1/3: three of them do not sum to 1 exactly."""
    text = "mdp\nconst double p;\nconst int n;\nmodule m\n x : [0..n];\n [] x=0 -> 3*p: (x'=n);\nendmodule\n"
    text += 'label "exact" = 3*p=1;\n'
    held = {}
    for third in (Fraction(1, 3), 1 / 3):
        model = meliora.Model.from_string(text, constants={"p": third, "n": Fraction(4, 2)})
        held[third] = model.explore().reach('P>=1 [ F "exact" ]').holds
        assert model.constants["n"] == 2
    assert held == {Fraction(1, 3): True, 1 / 3: False}


def test_jani_models_take_bounds() -> None:
    model = meliora.Model.from_file(MODELS / "workshop.jani", constants={"N": 2})
    assert model.kind == "mdp" and model.variables
    with pytest.raises(meliora.InputError, match="JANI"):
        meliora.Model.from_string(TOY, constants={"last": 5}, bounds={"s": (0, 3)})
    with pytest.raises(meliora.UsageError, match="pairs"):
        meliora.Model.from_string(TOY, bounds={"s": 3})  # type: ignore[dict-item]


def test_a_state_is_a_dictionary(robot: meliora.Model) -> None:
    state = robot.state(r=4, d=True)
    assert state == {"r": 4, "c": 2, "b": 8, "d": True, "e": False, "f": False, "ch": False}
    mistakes: list[tuple[str, dict[str, int]]] = [("no variable `z`", {"z": 1}), ("outside", {"r": 5}), ("int", {"r": True}), ("bool", {"d": 2})]
    for wrong, values in mistakes:
        with pytest.raises(meliora.UsageError, match=wrong):
            robot.state(**values)


def test_mistakes_are_shown_where_they_are() -> None:
    with pytest.raises(meliora.InputError) as caught:
        meliora.Model.from_string("mdp\nmodule m\n  x : [0..3];\n  [] y=0 -> (x'=1);\n  [] x=z -> true;\nendmodule", name="bad.prism")
    error = caught.value
    assert (error.file, error.line, error.column) == ("bad.prism", 4, 6)
    assert [problem.line for problem in error.problems] == [4, 5]
    first = error.problems[0]
    assert "`y`" in first.message and "[] y=0" in first.shown and "--> bad.prism:4:6" in str(error)
    assert isinstance(error, ValueError) and isinstance(error, meliora.Error)
    again = pickle.loads(pickle.dumps(error))
    assert (again.problems, str(again)) == (error.problems, str(error))


def test_advice_is_in_terms_of_python() -> None:
    with pytest.raises(meliora.InputError) as caught:
        meliora.Model.from_string(TOY)
    assert caught.value.problems[0].help == 'give values with `constants={"last": …}`'
    with pytest.raises(meliora.InputError) as caught:
        meliora.Model.from_string(TOY, constants={"last": 5, "first": 1})
    assert caught.value.file == "constants" and "--" not in str(caught.value).replace("-->", "")
    for text in (WISHES, "Pmax=? [ F x=1 ]"):
        with pytest.raises(meliora.InputError, match="not a model") as caught:
            meliora.Model.from_string(text)
        assert "`meliora " not in str(caught.value) and "MODEL" not in str(caught.value)


def test_lists_of_states_are_read_with_the_files_next_to_them(tmp_path: Path) -> None:
    for name, text in [
        ("m.tra", "3 4 4\n0 0 0 1 stay\n1 0 0 1 back\n1 1 2 1 on\n2 0 2 1 stay\n"),
        ("m.sta", "(x)\n0:(5)\n1:(6)\n2:(7)\n"),
        ("m.lab", '0="init" 1="deadlock" 2="goal"\n1: 0\n2: 2\n'),
    ]:
        (tmp_path / name).write_text(text)
    model = meliora.Model.from_file(tmp_path / "m.tra")
    for read in [model, pickle.loads(pickle.dumps(model))]:
        assert list(read.variables) == ["x"] and read.labels == ["goal"]
        explored = read.explore()
        assert explored.initial.states() == [{"x": 6}]
        assert explored.reach('"goal"').pmax_one.states() == [{"x": 6}, {"x": 7}]


def archive() -> bytes:
    """An archive in the format UMB: from state 0, a step leads to state 1 with probability 3/4."""
    sizes = {"#players": 1, "#states": 2, "#initial-states": 1, "#choices": 2, "#choice-actions": 0, "#branches": 3}
    others = {"time": "discrete", "#branch-actions": 0, "#observations": 0}
    double = {"branch-probability-type": {"type": "double", "size": 64}}
    index = {"format-version": 1, "format-revision": 0, "transition-system": {**sizes, **others, **double}}
    arrays = {"state-to-choices": [0, 1, 2], "state-is-initial": [1], "choice-to-branches": [0, 2, 3], "branch-to-target": [0, 1, 1]}
    files = {f"{name}.bin": struct.pack(f"<{len(numbers)}Q", *numbers) for name, numbers in arrays.items()}
    files = {"index.json": json.dumps(index).encode(), **files, "branch-to-probability.bin": struct.pack("<3d", 0.25, 0.75, 1)}
    return gzip.compress(packed(files))


def test_archives_are_told_by_their_content(tmp_path: Path) -> None:
    (tmp_path / "m.umb").write_bytes(archive())
    by_file, by_bytes = meliora.Model.from_file(tmp_path / "m.umb"), meliora.Model.from_umb(archive())
    for model in [by_file, by_bytes, pickle.loads(pickle.dumps(by_file))]:
        explored = model.explore()
        assert explored.counts["states"] == 2
        assert list(explored.successors({"state": 0}).values()) == [[(0.25, {"state": 0}), (0.75, {"state": 1})]]


def test_files_that_are_not_there_are_errors_of_the_system(tmp_path: Path) -> None:
    missing = tmp_path / "no.prism"
    with pytest.raises(FileNotFoundError) as caught:
        meliora.Model.from_file(missing)
    assert caught.value.filename == str(missing)
    with pytest.raises(FileNotFoundError):
        meliora.Preferences.from_file(missing)
    binary = tmp_path / "binary"
    binary.write_bytes(b"\xff\xfe")
    with pytest.raises(OSError, match="UTF-8"):
        meliora.Model.from_file(binary)


def test_models_and_preferences_are_pickled_by_their_texts(toy: meliora.Model, toy_wishes: meliora.Preferences) -> None:
    model, wishes = pickle.loads(pickle.dumps((toy, toy_wishes)))
    assert (model.text, model.constants, model.name) == (toy.text, toy.constants, toy.name)
    assert wishes == toy_wishes and hash(wishes) == hash(toy_wishes)
    assert model.check(wishes).sasi.counts == toy.check(toy_wishes).sasi.counts


def test_preferences_say_what_they_have(wishes: meliora.Preferences) -> None:
    assert list(wishes.objectives) == list("ABCDEF")
    assert wishes.objectives["A"] == "F (r=0 & c=0)"
    assert (wishes.empty, wishes.history) == ("gain", "state")
    assert wishes.name.endswith("robot5x5.pref") and "prefer" in wishes.text
    assert [wishes.compare(*pair) for pair in ("DA", "AD", "DE", "AA")] == [">", "<", None, "~"]
    with pytest.raises(meliora.UsageError, match="no objective `Z`"):
        wishes.compare("A", "Z")
    assert "A, B, C" in repr(wishes)


def test_usual_mistakes_in_preferences_are_told(toy: meliora.Model) -> None:
    with pytest.raises(meliora.UsageError, match=r'prefer is a list: write \["A > B"\]'):
        meliora.Preferences({"A": "F s=1", "B": "F s=2"}, "A > B")
    with pytest.raises(meliora.UsageError, match="require is a list"):
        meliora.Preferences({"A": "F s=1"}, require="G s<5")
    with pytest.raises(meliora.UsageError, match="Preferences.from_string"):
        toy.check(WISHES)


def test_preferences_can_be_put_together(toy: meliora.Model) -> None:
    formulas = {"First": "F (s=1 | s=5)", "Second": "F (s=2 | s=4)", "Third": "F (s=3)"}
    made = meliora.Preferences(formulas, [("Second", "First"), "Third > First"], empty="gain")
    assert made.objectives == formulas and made.empty == "gain"
    assert made.compare("Third", "First") == ">"
    assert made != meliora.Preferences(formulas) and made == meliora.Preferences.from_string(made.text)
    assert made != "text"
    assert toy.check(made).sasi.rank(toy.state()) == 1
    played = meliora.Preferences({"Twice": "F (s=1 & F s=3)"}, history="play")
    assert played.history == "play" == meliora.Preferences({"Twice": "F (s=1 & F s=3)"}).history


@pytest.mark.parametrize(
    ("text", "wrong"),
    [
        ("prefer A > B;", "no objective"),
        ("objective A = F x=1; objective A = F x=2;", "declared twice"),
        ("objective A = F x=1; prefer A > B;", "unknown objective `B`"),
        ("objective A = F x=1; objective B = F x=2; prefer A > B > A;", "contradict"),
        ("objective A = ;", "expected"),
    ],
)
def test_wrong_preferences_need_no_model(text: str, wrong: str) -> None:
    with pytest.raises(meliora.InputError, match=wrong) as caught:
        meliora.Preferences.from_string(text, name="w.pref")
    assert caught.value.file == "w.pref"


def test_what_preferences_say_of_a_model_is_seen_when_they_meet(toy: meliora.Model, tmp_path: Path) -> None:
    file = tmp_path / "toy.pref"
    file.write_text(WISHES.replace("s=3", "t=3"))
    with pytest.raises(meliora.InputError, match="unknown name `t`") as caught:
        toy.check(file)
    assert (caught.value.file, caught.value.line) == (str(file), 3)
    with pytest.raises(meliora.UsageError, match="Preferences or the path"):
        toy.check(3)  # type: ignore[arg-type]


def test_a_pickled_list_of_transitions_keeps_the_rewards_next_to_it(tmp_path: Path) -> None:
    for name, text in [("m.tra", "2 2\n0 1 1\n1 1 1\n"), ("m.srew", '# Reward structure "cost"\n2 1\n0 3\n')]:
        (tmp_path / name).write_text(text)
    model = meliora.Model.from_file(tmp_path / "m.tra")
    for own in (model, pickle.loads(pickle.dumps(model))):
        assert own.ask('R{"cost"}=? [ F state=1 ]')["value"] == {"lower": 3.0, "upper": 3.0}
