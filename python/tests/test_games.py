"""Games: coalitions, owners of states, and environments in which the opponent moves."""

from __future__ import annotations

import pickle
from collections.abc import Sequence
from typing import Any, Literal

import pytest
from conftest import MODELS, Engine

import meliora

#: We choose in x=0, the opponent in x=1; x=2 is a deadlock.
GAME = """smg
player us [a], [b] endplayer
player them [c], [d] endplayer
module m
  x : [0..3] init 0;
  [a] x=0 -> (x'=1);
  [b] x=0 -> 1/2:(x'=2)+1/2:(x'=3);
  [c] x=1 -> (x'=2);
  [d] x=1 -> (x'=0);
  [a] x=3 -> true;
endmodule
"""
WISHES = "objective Two = F x=2; objective Three = F (x=3); prefer Two > Three;"


@pytest.fixture(scope="module")
def game() -> meliora.Model:
    return meliora.Model.from_string(GAME)


def test_a_game_has_players_and_a_coalition(game: meliora.Model) -> None:
    assert (game.kind, game.players, game.coalition) == ("smg", ("us", "them"), ("us",))
    others = game.with_coalition("them")
    assert (others.coalition, game.coalition) == (("them",), ("us",))
    assert game.with_coalition(2, "us").coalition == ("us", "them")
    restored: meliora.Model = pickle.loads(pickle.dumps(others))
    assert restored.coalition == ("them",) and restored.explore().theirs.states() == [{"x": 0}, {"x": 3}]
    with pytest.raises(meliora.InputError, match="unknown player `you`"):
        game.with_coalition("you")
    with pytest.raises(meliora.UsageError, match="by its name or its number"):
        game.with_coalition(None)  # type: ignore[arg-type]
    toy = meliora.Model.from_file(MODELS / "toy.prism")
    assert (toy.players, toy.coalition, toy.explore().players) == ((), (), {})
    assert not toy.explore().theirs and toy.explore().owner(toy.state()) is None
    with pytest.raises(meliora.InputError, match="only a game has players"):
        toy.with_coalition("us")


def test_states_belong_to_players(game: meliora.Model, engine: Engine) -> None:
    explored = game.explore(engine=engine)
    listed = {name: [state["x"] for state in states] for name, states in explored.players.items()}
    assert listed == {"us": [0, 3], "them": [1]}
    assert explored.theirs == explored.players["them"]
    assert [explored.owner({"x": x}) for x in range(4)] == ["us", "them", None, "us"]
    assert explored.successors({"x": 1}) == {"c": [(1.0, {"x": 2})], "d": [(1.0, {"x": 0})]}
    assert explored.successors({"x": 2}) == {"deadlock": [(1.0, {"x": 2})]}
    with pytest.raises(meliora.UsageError, match="not a state of the scope"):
        explored.owner({"x": 9})


def test_regions_are_those_that_a_coalition_enforces(game: meliora.Model, engine: Engine) -> None:
    def sizes(model: meliora.Model) -> list[int]:
        found = model.reach("x=2", engine=engine)
        return [r.count() for r in (found.pmax_one, found.pmax_positive, found.pmin_one, found.pmin_positive)]

    assert sizes(game) == [1, 3, 2, 3]
    assert sizes(game.with_coalition("them")) == [2, 3, 1, 3]
    assert sizes(game.with_coalition("us", "them")) == [3, 3, 1, 1]
    explored = game.explore(engine=engine)
    assert explored.reach("<<us>> P>=1 [ F x=2 ]").holds is False
    assert explored.reach("<<us,them>> P>=1 [ F x=2 ]").holds is True
    assert explored.reach("<<us>> Pmin=? [ F x=1 ]").value == (0.0, 0.0)
    # A property does not change the coalition of the exploration, and regions of both can be combined.
    both = explored.reach("<<them>> P>=1 [ F x=2 ]").pmax_one & explored.reach("x=2").pmax_one
    assert both.states() == [{"x": 2}]
    assert explored.reach("<<us>> P>=1 [ G F x=2 ]").holds is False
    # Without players, the formula is to hold for each strategy of all players together.
    assert explored.reach("P>=1 [ F x=2 ]").holds is False
    with pytest.raises(meliora.InputError, match="recurrence and persistence"):
        explored.reach("<<us>> P>=1 [ (G F x=2) => (G F x=1) ]")
    value = explored.reach("<<us>> Pmax=? [ F x=2 ]").value
    assert value is not None and value[0] <= 0.5 <= value[1] and value[1] - value[0] < 1e-6


def test_levels_are_those_against_the_opponent(engine: Engine) -> None:
    model = meliora.Model.from_file(MODELS / "pursuit.prism", constants={"N": 4})
    explored = model.explore(engine=engine)
    found = explored.check(MODELS / "pursuit.pref")
    assert {names: region.count() for names, region in found.classes.items()} == {("Outside",): 100, ("First",): 240, ("Second",): 240}
    assert (found.sasi.counts, found.spi.counts) == ([100], [100])
    report = found.to_dict()
    assert report["players"] == [{"name": "robot", "ours": True, "states": "290"}, {"name": "guard", "ours": False, "states": "290"}]
    assert found.sasi.rank(model.state()) == 1
    together = model.with_coalition("robot", "guard").check(MODELS / "pursuit.pref", engine=engine)
    assert together.sasi.counts == [] and together.most_preferred(model.state()) == ("First", "Second")
    with pytest.raises(meliora.UsageError, match='safety="transition" of a game'):
        explored.check(MODELS / "pursuit.pref", safety="transition")


def test_a_preference_file_names_a_coalition_unless_the_model_does(game: meliora.Model, engine: Engine) -> None:
    def sure(model: meliora.Model, wishes: str) -> list[int]:
        found = model.explore(engine=engine).check(meliora.Preferences.from_string(wishes))
        return [state["x"] for state in found.almost_sure["Two"]]

    assert sure(game, WISHES) == [2]
    assert sure(game, WISHES + "coalition them;") == [1, 2]
    assert sure(game.with_coalition("us"), WISHES + "coalition them;") == [2]
    assert sure(game.with_coalition("them"), WISHES) == [1, 2]
    # The exploration of an analysis keeps its coalition.
    found = game.explore(engine=engine).check(meliora.Preferences.from_string(WISHES + "coalition them;"))
    again = found.exploration.check(meliora.Preferences.from_string(WISHES))
    assert [state["x"] for state in again.almost_sure["Two"]] == [1, 2]


def test_what_games_do_not_have_is_refused_by_name(game: meliora.Model) -> None:
    found = game.check(meliora.Preferences.from_string(WISHES))
    with pytest.raises((meliora.InputError, meliora.UsageError), match="of a game is not supported"):
        found.jointly()


def test_pages_show_whose_move_it_is() -> None:
    model = meliora.Model.from_file(MODELS / "pursuit.prism", constants={"N": 3})
    page = model.check(MODELS / "pursuit.pref").to_html()
    assert "This holds against every strategy of guard." in page and "moves in round cells" in page


def test_sweeps_know_the_coalition() -> None:
    pursuit = (MODELS / "pursuit.prism", MODELS / "pursuit.pref")
    for coalition, ranks in [(None, ["1"]), (["robot", "guard"], ["0"])]:
        rows = meliora.sweep(*pursuit, N=[4], coalition=coalition)
        rows = rows.to_dict("records") if hasattr(rows, "to_dict") else rows
        assert [str(row["sasi_rank"]) for row in rows] == ranks
    with pytest.raises(meliora.InputError, match="unknown player"):
        meliora.sweep(*pursuit, N=[4], coalition=["you"])


def pursuit() -> meliora.Exploration:
    return meliora.Model.from_file(MODELS / "pursuit.prism", constants={"N": 3}).explore()


def test_the_opponent_moves_inside_the_environment() -> None:
    pytest.importorskip("gymnasium", reason="needs gymnasium")
    from meliora.gym import ModelEnv

    explored = pursuit()
    rooms = explored.where('"first" | "second"')
    env = ModelEnv(explored, goal=rooms)
    assert env.actions[:4] == ("north", "south", "east", "west")
    ends = 0
    for seed in range(20):
        observation, info = env.reset(seed=seed)
        for _ in range(400):
            state = info["state"]
            assert env.observation_space.contains(observation) and explored.owner(state) == "robot"
            assert list(observation) == [int(value) for value in state.values()]
            enabled = explored.successors(state)
            assert [name in enabled for name in env.actions] == info["action_mask"].tolist() == env.action_masks().tolist()
            action = int(env.np_random.choice(info["action_mask"].nonzero()[0]))
            observation, reward, over, cut, info = env.step(action)
            assert [player for player, _, _ in info["moves"]] in (["robot"], ["robot", "guard"])
            assert reward == float(over) and not cut and over == (info["state"] in rooms)
            if over:
                ends += 1
                assert not info["action_mask"].any()
                break
    assert ends > 0


def test_a_function_can_be_the_opponent() -> None:
    gymnasium = pytest.importorskip("gymnasium", reason="needs gymnasium")

    from meliora.gym import ModelEnv

    explored, asked = pursuit(), []

    def stays(state: dict[str, Any], actions: Sequence[str]) -> str:
        asked.append((state, list(actions)))
        return "stay"

    env = ModelEnv(explored, opponent=stays)
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.step(0)
    env.reset(seed=1)
    _, _, _, _, info = env.step(env.actions.index("north"))
    (_, taken, between), (_, answer, after) = info["moves"]
    assert (taken, answer, after) == ("north", "stay", info["state"]) and asked == [(between, list(explored.successors(between)))]
    # The same seed gives the same episode.
    runs = [[(env.reset(seed=7), env.step(0), env.step(1))[-1][-1]["moves"]] for _ in range(2)]
    assert runs[0] == runs[1]
    with pytest.raises(meliora.UsageError, match="is not enabled"):
        env.step(env.actions.index("lock"))
    wrong = ModelEnv(explored, opponent=lambda state, actions: "fly")
    wrong.reset(seed=1)
    with pytest.raises(meliora.UsageError, match="the opponent took 'fly'"):
        wrong.step(0)
    with pytest.raises(meliora.UsageError, match="opponent='worst'"):
        ModelEnv(explored, opponent="worst")  # type: ignore[arg-type]


def test_an_opponent_that_never_stops_moving_cuts_the_episode() -> None:
    pytest.importorskip("gymnasium", reason="needs gymnasium")

    from meliora.gym import ModelEnv

    text = "smg player us [a] endplayer player them [c] endplayer module m x : [0..1]; [a] x=0 -> (x'=1); [c] x=1 -> true; endmodule"
    env = ModelEnv(meliora.Model.from_string(text).explore(), patience=5)
    env.reset(seed=1)
    _, _, over, cut, info = env.step(0)
    assert (over, cut, len(info["moves"])) == (False, True, 6)


def test_an_mdp_is_an_environment_too(toy: meliora.Model) -> None:
    pytest.importorskip("gymnasium", reason="needs gymnasium")

    from meliora.gym import ModelEnv

    env = ModelEnv(toy.explore())
    _, info = env.reset(seed=3, options={"state": toy.state(s=5)})
    assert info["action_mask"].tolist() == [True, False, False] and info["moves"] == []
    observation, _, over, cut, info = env.step(0)
    assert (list(observation), over, cut) == ([1, 0], True, False)
    assert info["moves"] == [(None, "a", toy.state(s=1))]
    with pytest.raises(meliora.UsageError, match="not a state of the scope"):
        env.reset(options={"state": {"s": 4, "lost": True}})


def test_strategies_permit_nothing_at_states_of_the_opponent(engine: Engine) -> None:
    model = meliora.Model.from_file(MODELS / "pursuit.prism", constants={"N": 3})
    found = model.check(MODELS / "pursuit.pref", engine=engine)
    strategy = found.strategy("sasi")
    start = model.state()
    ours = strategy.explain(start)
    assert (ours.owner, ours.theirs) == ("robot", False) and strategy.actions(start)
    theirs = {**start, "robots_turn": False}
    at = strategy.explain(theirs)
    assert (at.owner, at.theirs, strategy.actions(theirs)) == ("guard", True, [])
    assert {action.name for action in at.actions} == set(found.exploration.successors(theirs))
    assert "guard moves (the opponent)" in str(at) and not strategy.mask(theirs).any()
    assert all(not action.permitted and action.reason for action in at.actions)
    # What the opponent does is neither kept nor dropped, as in the report of `strategy`.
    assert not any(action.kept for action in at.actions) and strategy.actions(theirs, "kept") == []
    assert not strategy.mask(theirs, which="kept").any() and strategy.play(theirs).actions("kept") == []
    assert strategy.actions(start, "kept")
    # Whatever the guard does, the run improves once; its moves are counted.
    opponents: list[Literal["random", "worst"]] = ["random", "worst"]
    for opponent in opponents:
        runs = strategy.simulate(start, runs=50, seed=3, opponent=opponent)
        assert runs.improvements == {1: 50} and (runs.weakened_step, runs.settled) == (0, 50)
        assert runs.moves["robot"] > 0 and sum(runs.moves.values()) == int(runs.lengths.sum())
    with pytest.raises(meliora.UsageError, match='opponent="best": it is one of "random", "worst"'):
        strategy.simulate(start, opponent="best")  # type: ignore[arg-type]
    # The strategy that needs the fewest steps against the worst guard, and its value.
    cheap = found.strategy("sasi", choose="cheap").simulate(start, runs=2000, seed=3, opponent="worst")
    expected = found.values([start])[0]["levels"][0]["cost"]
    assert expected is not None and abs(float(cheap.lengths.mean()) - expected["lower"]) < 0.2


def test_a_run_follows_both_players() -> None:
    model = meliora.Model.from_file(MODELS / "pursuit.prism", constants={"N": 3})
    play = model.check(MODELS / "pursuit.pref").strategy("sasi").play(model.state())
    explored = model.explore()
    for _ in range(200):
        if play.over:
            break
        state = play.state
        actions = play.actions("progress") or list(explored.successors(state))
        (_, after) = max(explored.successors(state)[actions[0]], key=lambda pair: pair[0])
        play.step(after)
    assert play.over and play.improvements == 1


def test_a_shield_holds_against_every_opponent() -> None:
    pytest.importorskip("gymnasium", reason="needs gymnasium")

    from meliora.gym import ModelEnv, ShieldedEnv

    found = meliora.Model.from_file(MODELS / "pursuit.prism", constants={"N": 3}).check(MODELS / "pursuit.pref")
    explored, table = found.exploration, found.strategy("plan").shield()
    shield = table.copy()
    rooms = explored.where('"first" | "second"')

    def closes(state: dict[str, Any], actions: Sequence[str]) -> str:
        """Locks a door as soon as it can; the guard walks to the door that is nearer to the robot."""
        return next(action for action in ("lock", "down" if state["y"] < 2 else "up", "stay") if action in actions)

    policies: list[Any] = ["random", closes]
    for opponent in policies:
        model_env = ModelEnv(explored, opponent=opponent, goal=rooms, actions=shield.actions)
        env = ShieldedEnv(model_env, shield)
        for seed in range(20):
            _, info = env.reset(seed=seed)
            for _ in range(500):
                assert shield.secure(info["state"])
                before = found.most_preferred(info["state"])
                asked = int(model_env.np_random.integers(len(shield.actions)))
                _, _, over, _, info = env.step(asked)
                # A room that is sure stays sure, whoever moves.
                assert before == ("Outside",) or found.most_preferred(info["state"]) == before
                if over:
                    break
            assert over, "an agent that takes permitted actions at random reaches a room"


def test_a_shield_sees_the_first_moves_of_the_opponent() -> None:
    pytest.importorskip("gymnasium", reason="needs gymnasium")

    from meliora.gym import ModelEnv, ShieldedEnv

    text = "smg player us m endplayer player them [c] endplayer module m x : [0..2]; [c] x=0 -> (x'=1); [] x=1 -> (x'=2); [] x=1 -> true; endmodule"
    model = meliora.Model.from_string(text)
    found = model.check(meliora.Preferences.from_string("objective Late = X X X x=2; objective Soon = X X x=2; prefer Soon > Late; history = play;"))
    explored, shield = found.exploration, found.strategy("sasi").shield()
    env = ShieldedEnv(ModelEnv(explored, actions=shield.actions), shield)
    # It began the episode after the first move, in a state where none may start.
    observation, info = env.reset(seed=1)
    assert (info["start"]["x"], info["state"]["x"], len(info["moves"])) == (0, 1, 1)
    play = found.strategy("sasi").play(info["start"])
    play.step(info["state"])
    assert shield.most_preferred(observation) == found.most_preferred(play.state) == ("Soon",)
    assert info["action_mask"].any()
