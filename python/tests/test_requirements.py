"""Requirements: states from which they cannot be kept, and actions that they forbid."""

import math

import meliora

MODEL = """mdp
module m
  x : [0..4];
  [a] x=0 -> 1/2: (x'=1) + 1/2: (x'=2);
  [b] x=0 -> (x'=3);
  [c] x=2 -> (x'=4);
  [stay] x=1 | x=3 | x=4 -> true;
endmodule
"""


def analysis() -> meliora.Analysis:
    preferences = meliora.Preferences(
        {"One": "F x=1", "Three": "F x=3"}, ["Three > One"], require=["G x!=4"]
    )
    assert preferences.requirements == ("G x!=4",)
    return meliora.Model.from_string(MODEL).check(preferences)


def test_unsafe_states_are_counted_and_belong_to_no_class() -> None:
    found = analysis()
    assert found.counts is not None and found.counts["unsafe"] == 2
    assert sorted(state["x"] for state in found.region("unsafe")) == [2, 4]
    assert found.most_preferred({"x": 2}) == ()
    assert found.most_preferred({"x": 0}) == ("Three",)


def test_an_action_that_may_lead_to_an_unsafe_state_says_so() -> None:
    at = analysis().strategy("sasi").explain({"x": 0})
    assert not at.unsafe
    verdicts = {action.name: action.verdict for action in at.actions}
    assert verdicts["a"] == "violates"
    unsafe = [successor.unsafe for successor in at.actions[0].successors]
    assert sorted(unsafe) == [False, True]


def test_unsafe_states_have_no_rank_in_arrays_and_numbers() -> None:
    found = analysis()
    states = found.exploration.states.states()
    unsafe = found.region("unsafe")
    ranks = found.sasi.to_numpy(None, "x")
    for state in states:
        rank = found.sasi.rank(state)
        assert math.isnan(rank) == math.isnan(ranks[state["x"]]) == (state in unsafe)
        assert (state in found.sasi.at_least(0)) == (state not in unsafe)
    # The states of the exploration are those that have values; unsafe ones say so.
    values = found.values(states)
    assert [value["state"] for value in values] == states
    assert [value.get("unsafe", False) for value in values] == [state in unsafe for state in states]
    at = found.strategy("sasi").explain({"x": 2})
    assert at.unsafe and math.isnan(at.rank) and str(at).startswith("{'x': 2}: unsafe\n")
    ranks_after = {s.state["x"]: s.rank for s in found.strategy("sasi").explain({"x": 0}).actions[0].successors}
    assert ranks_after[1] == 0 and math.isnan(ranks_after[2])
