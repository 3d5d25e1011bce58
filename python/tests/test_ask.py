"""Questions in any form: `Model.ask`."""

from __future__ import annotations

import math
from fractions import Fraction
from pathlib import Path
from typing import Literal

import meliora
import pytest
from meliora import errors

WALK = """mdp
module walk
  x : [0..4] init 0;
  [left] x=0 -> 1/4: (x'=1) + 3/4: (x'=3);
  [right] x=0 -> (x'=2);
  [again] x=3 -> 1/2: (x'=0) + 1/2: (x'=4);
  [stay] x=1 | x=2 | x=4 -> true;
endmodule
rewards "steps"
  true : 1;
endrewards
"""

DOMAIN = """(define (domain doors)
  (:requirements :strips :non-deterministic)
  (:predicates (at-door) (open) (inside))
  (:action push :parameters () :precondition (and (at-door) (not (open)))
    :effect (oneof (open) (at-door)))
  (:action enter :parameters () :precondition (open) :effect (inside)))
"""
PROBLEM = "(define (problem one) (:domain doors) (:init (at-door)) (:goal (inside)))"


@pytest.fixture(scope="module")
def walk() -> meliora.Model:
    return meliora.Model.from_string(WALK)


@pytest.mark.parametrize(
    ("text", "holds"),
    [
        ("Pmax>=1 [ F x=2 ]", True),
        ("!!(Pmax>=1 [ F x=2 ])", True),
        ("true & Pmax>=1 [ F x=2 ]", True),
        ("Pmax>=1 [ F x=1 ]", False),
        ("!(Pmax>=1 [ F x=1 ]) & Pmax>0 [ F x=1 ]", True),
        ("P>=1 [ F Pmax>=1 [ G x=4 ] ]", False),
        ("filter(forall, Pmax>=1 [ F x=2 ], x=0)", True),
        ("E [ F x=4 ]", True),
        ("multi(Pmax>=0.5 [ F x=2 ], Pmax>=0.1 [ F x=1 ])", True),
    ],
)
@pytest.mark.parametrize("engine", ["auto", "symbolic", "explicit"])
def test_conditions_hold_or_not_in_every_form(
    walk: meliora.Model, text: str, holds: bool, engine: Literal["auto", "symbolic", "explicit"]
) -> None:
    found = walk.ask(text, engine=engine)
    assert found["property"] == text
    assert found["holds"] is holds, found


def test_numbers_have_bounds(walk: meliora.Model) -> None:
    # With 1/4 to x=1, else half of the time back: p = 1/4 + 3/4 · 1/2 · p.
    value = walk.ask("Pmax=? [ F x=1 ]")["value"]
    assert value and value["lower"] <= 0.4 <= value["upper"] <= value["lower"] + 1e-6
    value = walk.ask('R{"steps"}max=? [ F x=1 ]')["value"]
    assert value and value["lower"] == math.inf
    value = walk.ask("1 - Pmax=? [ F x=1 ]", precision=0.1)["value"]
    assert value and value["lower"] <= 0.6 <= value["upper"]


def test_a_list_answers_all_and_gives_reasons(walk: meliora.Model) -> None:
    found = walk.ask(["Pmax>=1 [ F x=2 ]", "Pmax=? [ F x=1 ]", "filter(printall, x=2, true)"])
    assert found[0]["holds"] is True
    assert found[1]["value"]
    listed = found[2]["values"]
    assert [one["state"]["x"] for one in listed if one["holds"]] == [2]


def test_requirements_bind_every_form(walk: meliora.Model) -> None:
    for text in ("Pmax>0 [ F x=1 ]", "!!(Pmax>0 [ F x=1 ])"):
        assert walk.ask(text)["holds"] is True
        assert walk.ask(text, require=["G x<3"])["holds"] is False


def test_a_front_has_points(walk: meliora.Model) -> None:
    front = walk.ask("multi(Pmax=? [ F x=1 ], Pmax=? [ F x=2 ])")["front"]
    assert [[round(x, 6) for x in point] for point in front] == [[0.0, 1.0], [0.4, 0.0]]


def test_the_goal_of_a_planning_problem_needs_no_text(tmp_path: Path) -> None:
    domain, problem = tmp_path / "domain.pddl", tmp_path / "problem.pddl"
    domain.write_text(DOMAIN)
    problem.write_text(PROBLEM)
    for model in (meliora.Model.from_pddl(domain, problem), meliora.Model.from_pddl(problem, domain)):
        found = model.ask()
        assert found["holds"] is True
    with pytest.raises(errors.UsageError, match="not in PDDL"):
        other = tmp_path / "m.prism"
        other.write_text(WALK)
        meliora.Model.from_pddl(domain, other)


def test_wrong_texts_are_refused_with_their_places(walk: meliora.Model) -> None:
    with pytest.raises(errors.InputError) as wrong:
        walk.ask("Pmax=? [ F y=1 ]")
    assert (wrong.value.line, wrong.value.column) == (1, 12)
    with pytest.raises(errors.InputError, match="a requirement is a formula over paths"):
        walk.ask("Pmax=? [ F x=1 ]", require=["x<3"])
    with pytest.raises(errors.UsageError, match="a property is missing"):
        walk.ask()
    with pytest.raises(errors.UsageError, match="precision"):
        walk.ask("Pmax=? [ F x=1 ]", precision=0)


def test_a_limit_leaves_the_answers_so_far() -> None:
    step = "  [go] x<50000 -> 0.9999: (x'=x+1) + 0.0001: (x'=0);\n  [stay] x=50000 -> true;\n"
    model = meliora.Model.from_string("mdp\nmodule climb\n  x : [0..50000] init 0;\n" + step + "endmodule\n")
    with pytest.raises(errors.OutOfTime) as ended:
        hard = ["Pmax=? [ F<=900000000 x=50000 ]", "Pmin=? [ F<=900000000 x=50000 ]"]
        model.ask([*hard, "Pmax>=1 [ F x=1 ]"], timeout=1)
    assert ended.value.known is not None
    first, _, easy = ended.value.known["properties"]
    assert "share of the time limit" in first["reason"]
    assert easy["holds"] is True


def test_a_file_and_the_model_name_properties(tmp_path: Path, walk: meliora.Model) -> None:
    file = tmp_path / "walk.props"
    file.write_text('const int N;\n"near": Pmax>=1 [ F x=N ];\n"unknown": Pmax>=1 [ F y=1 ];\n')
    near, unknown = walk.ask(file=file, constants={"N": 2})
    assert (near["name"], near["holds"]) == ("near", True)
    assert unknown["reason"] and unknown["line"] == 3
    assert walk.properties == []
    with pytest.raises(errors.UsageError, match="exclude each other"):
        walk.ask("P>0 [ F x=1 ]", file=file)  # type: ignore[call-overload]
    with pytest.raises(errors.UsageError, match="constants"):
        walk.ask("P>0 [ F x=1 ]", constants={"N": 2})  # type: ignore[call-overload]


def test_policies_and_strong_plans_come_with_the_answer(walk: meliora.Model) -> None:
    found = walk.ask("Pmax>=1 [ F x=2 ]", policy=True, strong=True)
    assert found["policy"][0]["action"] == "right"
    assert found["plan"]["strong"] is True
    found = walk.ask("Pmax>=1 [ F x=1 ]", policy=True)
    assert found["policy"] is None
    found = walk.ask("multi(Pmax>=0.5 [ F x=2 ], Pmax>=0.1 [ F x=1 ])", policy=True)
    shares = [Fraction(str(one["share"])) for one in found["policy"]["strategies"]]
    assert sum(shares) == 1
    found = walk.ask("Pmax>=1 [ G F x=2 ]", policy=True)
    assert meliora.Policy(found["policy"])({"x": 0}) == "right"
    with pytest.raises(errors.UsageError, match="reaching a target"):
        walk.ask("Pmax>=1 [ G F x=2 ]", strong=True)
    with pytest.raises(errors.UsageError, match="requirements"):
        walk.ask("Pmax>=1 [ F x=2 ]", policy=True, require=["G x<3"])


def test_a_part_of_the_states_or_of_a_file_can_be_asked(tmp_path: Path, walk: meliora.Model) -> None:
    for text in ("Pmax>=1 [ F x=2 ]", "Pmax=? [ F x=3 ]", "P>=1 [ F x=3 ]"):
        whole, part = walk.ask(text), walk.ask(text, stop_at_target=True)
        assert (part["holds"], part.get("value")) == (whole["holds"], whole.get("value"))
    with pytest.raises(errors.UsageError, match="`stop_at_target` needs one"):
        walk.ask(["P>0 [ F x=1 ]", "P>0 [ F x=2 ]"], stop_at_target=True)
    with pytest.raises(errors.UsageError, match="`stop_at_target` cannot be used with `require`"):
        walk.ask("P>0 [ F x=1 ]", stop_at_target=True, require=["G x<3"])
    with pytest.raises(errors.UsageError, match="without `stop_at_target`"):
        walk.ask("Pmax>=1 [ F x=2 ]", stop_at_target=True, policy=True)
    file = tmp_path / "walk.props"
    file.write_text('"near": P>0 [ F x=1 ];\n"far": Pmax>0 [ F x=4 ];\n')
    (far,) = walk.ask(file=file, only="far")
    assert (far["name"], far["holds"]) == ("far", True)
    with pytest.raises(errors.UsageError, match="no property with the name `other`"):
        walk.ask(file=file, only="other")
    with pytest.raises(errors.UsageError, match="names a property of a file"):
        walk.ask("P>0 [ F x=1 ]", only="far")  # type: ignore[call-overload]
