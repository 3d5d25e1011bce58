"""Shields: they follow a strategy, keep their promise, and need no model."""

from __future__ import annotations

import copy
import hashlib
import json
import pickle
import random
import subprocess
import sys
from pathlib import Path
from typing import Any, Literal

import pytest
from conftest import MODELS

import meliora

#: A die decides between `second` and `third`; `risk` weakens, `wait` counts steps of the monitor.
WORLD = """mdp
module world
  s : [0..4] init 0;
  on : bool init false;
  [roll] s=0 -> 0.5: (s'=1) + 0.5: (s'=2);
  [risk] s<3 -> 0.9: (s'=3) + 0.1: (s'=4);
  [wait] s<3 -> (on'=!on);
  [stay] s>=3 -> true;
endmodule
"""
WISHES = "objective One = F s=1; objective Two = F s=2; objective Low = F s=3; prefer One, Two > Low;"


def world(wishes: str = WISHES, **options: Any) -> meliora.Analysis:
    return meliora.Model.from_string(WORLD).check(meliora.Preferences.from_string(wishes), **options)


def test_a_shield_permits_what_the_strategy_permits() -> None:
    cases: list[tuple[str, Literal["action", "prefix"]]] = [("robot5x5", "action"), ("robot5x5", "prefix"), ("drone", "action"), ("drone", "prefix")]
    for name, safety in cases:
        model = meliora.Model.from_file(MODELS / f"{name}.prism")
        found = model.check(MODELS / f"{name}.pref", safety=safety)
        kinds: tuple[Literal["sasi", "spi"], ...] = ("sasi", "spi")
        for kind in kinds:
            strategy = found.strategy(kind)
            shield, draw = strategy.shield(), random.Random(1)
            assert shield.actions == model.actions
            assert (shield.kind, shield.safety) == (kind, safety)
            improvements = 0
            for _ in range(20):
                state = draw.choice(found.exploration.states.states(500))
                play = strategy.play(state)
                shield.reset(state)
                while not play.over and improvements < 200:
                    assert shield.ahead(play.state) == play.ahead
                    assert set(shield.allowed(play.state)) == set(play.actions())
                    assert list(shield.mask(play.state)) == list(play.mask())
                    action = shield.correct(play.state, draw.choice(shield.allowed(play.state)))
                    after = draw.choice([s.state for a in play.explain().actions if a.name == action for s in a.successors])
                    improvements += play.step(after)
            assert kind == "sasi" or improvements


def test_no_step_of_a_secure_state_weakens() -> None:
    found = meliora.Model.from_file(MODELS / "robot5x5.prism").check(MODELS / "robot5x5.pref")
    strategy, draw, secure = found.strategy("sasi"), random.Random(2), 0
    shield = strategy.shield()
    better = {"A": {"D", "E"}, "B": {"D", "E"}, "C": {"E", "F"}}
    for state in found.exploration.states.sample(100, seed=3):
        shield.reset(state)
        promised = False
        for _ in range(50):
            # A promise holds from then on.
            assert shield.secure(state) or not promised
            promised = shield.secure(state)
            action = shield.correct(state, draw.choice(shield.actions))
            before = found.most_preferred(state)
            state = draw.choice(strategy.successors(state)[action])[1]
            after = found.most_preferred(state)
            # The file says `empty = gain`: to lose the last objective does not weaken.
            worse = any(new in lesser(better, old) for old in before for new in after)
            assert not (promised and worse)
            secure += promised
    assert secure > 1000


def lesser(better: dict[str, set[str]], name: str) -> set[str]:
    return {low for low, high in better.items() if name in high}


def test_an_action_that_is_not_permitted_is_corrected() -> None:
    shield = world().strategy("sasi").shield()
    start = {"s": 0, "on": False}
    assert (shield.allowed(start), shield.ahead(start), shield.secure(start)) == (("roll", "wait"), 1, True)
    assert shield.most_preferred(start) == ()
    assert shield.mask(start).tolist() == [True, False, True, False]
    with pytest.raises(ValueError, match="read-only"):
        shield.mask(start)[0] = False
    assert shield.correct(start, "wait") == "wait"
    assert shield.correct((0, True), 1) == 0
    assert shield.ahead({"s": 2, "on": True}) == 0
    assert (shield.allowed((2, True)), shield.most_preferred((2, True))) == (("wait",), ("Two",))
    with pytest.raises(meliora.UsageError, match="cannot follow"):
        shield.mask((1, True))
    with pytest.raises(meliora.UsageError, match="there is no action fly"):
        shield.correct((2, True), "fly")
    with pytest.raises(meliora.UsageError, match="no state in which an episode may start"):
        shield.reset((9, True))
    with pytest.raises(meliora.UsageError, match="expected 2 values"):
        shield.reset((1,))
    with pytest.raises(meliora.UsageError, match="no value for `on`"):
        shield.reset({"s": 1})
    with pytest.raises(meliora.UsageError, match="`on` cannot have the value 7"):
        shield.reset((1, 7))


def test_a_shield_follows_monitors() -> None:
    wishes = "objective Soon = F<=2 s=3; objective Late = F s=3; prefer Soon > Late;"
    found = world(wishes)
    play, shield = found.strategy("spi").play({"s": 0, "on": False}), found.strategy("spi").shield()
    for on in (True, False, True, False):
        assert shield.most_preferred((0, not on)) == found.most_preferred(play.state)
        shield.step((0, on))
        play.step(next(t.state for a in play.explain().actions if a.name == "wait" for t in a.successors))
    assert shield.most_preferred((0, False)) == found.most_preferred(play.state)


def test_what_promises_nothing_has_no_shield() -> None:
    with pytest.raises(meliora.UsageError, match="there is no shield"):
        world(safety="transition").strategy("sasi").shield()
    with pytest.raises(meliora.UsageError, match="does not choose by value"):
        world().strategy(choose="cheap").shield()
    with pytest.raises(meliora.TooLarge, match="more than 3 states"):
        world().strategy("sasi").shield(limit=3)


def test_shields_of_plans_achieve_what_they_pursue(tmp_path: Path) -> None:
    hall = """mdp
module hall
  x : [0..4] init 2;
  [left] x>0 -> 9/10: (x'=x-1) + 1/10: true;
  [right] x<4 -> (x'=x+1);
  [fall] x=1 -> (x'=1);
endmodule
"""
    found = meliora.Model.from_string(hall).check(
        meliora.Preferences.from_string("objective C = F x=0; objective D = F x=4; objective E = F x=3;")
    )
    aims: list[tuple[Literal["plan", "achieve"], str | None]] = [("plan", None), ("plan", "D"), ("achieve", "C,D")]
    for kind, aim in aims:
        shield = found.strategy(kind, objective=aim).shield()
        shield.save(tmp_path / "shield")
        shield = pickle.loads(pickle.dumps(meliora.Shield.load(tmp_path / "shield")))
        assert shield.kind == kind
        draw, visited = random.Random(4), set()
        for _ in range(20):
            state = 2
            shield.reset(state)
            pursued = set(shield.pursues(state))
            for _ in range(10_000):
                visited.add(state)
                if shield.achieved(state):
                    break
                assert shield.pursues(state)
                action = shield.correct(state, draw.choice(shield.actions))
                after = found.strategy("sasi").successors({"x": state})[action]
                state = draw.choice(after)[1]["x"]
            assert shield.achieved(state)
            assert aim is None or pursued == set(aim.split(","))
        assert aim != "C,D" or {0, 4} <= visited


def test_a_shield_is_saved_and_loaded_without_the_model(tmp_path: Path) -> None:
    shield = world().strategy("sasi").shield()
    shield.save(tmp_path / "shield")
    shield.save(tmp_path / "shield")
    loaded = meliora.Shield.load(tmp_path / "shield")
    assert (len(loaded), loaded.actions, loaded.kind) == (len(shield), shield.actions, "sasi")
    assert loaded.allowed((0, False)) == ("roll", "wait")
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "letter.txt").write_text("mine")
    with pytest.raises(OSError, match="neither empty nor a shield"):
        shield.save(tmp_path / "other")


def test_a_shield_that_was_changed_is_refused(tmp_path: Path) -> None:
    world().strategy("sasi").shield().save(tmp_path)
    nodes, manifest = tmp_path / "nodes.json", tmp_path / "shield.json"
    table = json.loads(nodes.read_text())
    # In s=1, `risk` weakens, so a table that permits it does not keep the promise.
    node = next(node for node in table["nodes"] if node["state"][0] == 1)
    assert node["secure"] and [action["permitted"] for action in node["actions"]] == [False, True]
    node["actions"][0]["permitted"] = True
    nodes.write_text(json.dumps(table))
    with pytest.raises(meliora.Error, match="the file has changed"):
        meliora.Shield.load(tmp_path)
    said = json.loads(manifest.read_text())
    said["sha256"] = hashlib.sha256(nodes.read_bytes()).hexdigest()
    manifest.write_text(json.dumps(said))
    with pytest.raises(meliora.Error, match="s=1,on=0: the permitted action `risk` weakens"):
        meliora.Shield.load(tmp_path)


def test_a_shield_with_a_second_entry_for_a_forbidden_action_is_refused(tmp_path: Path) -> None:
    world().strategy("sasi").shield().save(tmp_path)
    nodes, manifest = tmp_path / "nodes.json", tmp_path / "shield.json"
    table, said = json.loads(nodes.read_text()), json.loads(manifest.read_text())
    number, node = next((v, node) for v, node in enumerate(table["nodes"]) if node["state"][0] == 1)
    node["actions"].append({"action": table["actions"].index("risk"), "permitted": True, "next": [number]})
    nodes.write_text(json.dumps(table))
    manifest.write_text(json.dumps({**said, "sha256": hashlib.sha256(nodes.read_bytes()).hexdigest()}))
    with pytest.raises(meliora.Error, match="two entries for the action `risk`"):
        meliora.Shield.load(tmp_path)


NOSY = """
import meliora

class Nosy(dict):
    def __str__(self):
        return f"a state like {shield.allowed(start)}"

shield = meliora.Shield.load({folder!r})
start = {"s": 0, "on": False}
for call in (shield.reset, shield.step, shield.mask, shield.secure, shield.ahead):
    # The last one starts an episode, but cannot follow.
    for state in (Nosy(s=9, on=False), Nosy(s=1), Nosy(s=1, on=True))[: 2 if call == shield.reset else 3]:
        shield.reset(start)
        try:
            call(state)
        except meliora.UsageError as error:
            assert "a state like ('roll', 'wait')" in str(error), error
        else:
            raise AssertionError((call, state))
"""


def test_a_state_whose_text_asks_the_shield_does_not_wait_forever(tmp_path: Path) -> None:
    world().strategy("sasi").shield().save(tmp_path)
    program = NOSY.replace("{folder!r}", repr(str(tmp_path)))
    subprocess.run([sys.executable, "-c", program], check=True, timeout=60)


def test_arrays_of_integers_are_states_with_booleans() -> None:
    np = pytest.importorskip("numpy")
    shield = world().strategy("sasi").shield()
    shield.reset(np.array([0, 1]))
    assert shield.allowed((0, 1)) == shield.allowed([0, np.True_]) == shield.allowed({"s": np.int8(0), "on": 1})
    shield.reset(np.array([0, 0], dtype=np.uint8))
    wrong: list[Any] = [[0, 2], [0, -1], [True, True], [0, 0.0], np.array([[0, 0]]), np.array([0.0, 0.0])]
    for state in wrong:
        with pytest.raises(meliora.UsageError):
            shield.reset(state)
    single = meliora.Model.from_string("mdp module m x: [0..1] init 0; [a] true -> (x'=1-x); endmodule")
    shield = single.check(meliora.Preferences.from_string("objective A = F x=1;")).strategy("sasi").shield()
    assert shield.allowed(np.array(0)) == shield.allowed(np.array([0])) == shield.allowed(np.int64(0)) == ("a",)


def test_masks_of_many_states_are_those_of_episodes() -> None:
    np = pytest.importorskip("numpy")
    cases: list[tuple[str, Literal["action", "prefix"]]] = [("robot5x5", "prefix"), ("drone", "action")]
    for name, safety in cases:
        found = meliora.Model.from_file(MODELS / f"{name}.prism").check(MODELS / f"{name}.pref", safety=safety)
        strategy, draw = found.strategy("spi"), random.Random(5)
        shield = strategy.shield()
        states: list[list[Any]] = []
        memory: list[int] = []
        masks: list[Any] = []
        memories: dict[tuple[Any, ...], set[tuple[bool, ...]]] = {}
        for start in found.exploration.states.sample(7, seed=4):
            shield.reset(start)
            state = start
            for _ in range(30):
                states.append(list(state.values()))
                memory.append(shield.memory(state))
                masks.append(shield.mask(state))
                memories.setdefault(tuple(state.values()), set()).add(tuple(masks[-1]))
                action = shield.correct(state, draw.choice(shield.actions))
                state = draw.choice(strategy.successors(state)[action])[1]
        assert np.array_equal(shield.masks(states, memory), np.array(masks))
        assert np.array_equal(shield.masks(np.array(states), memory=np.array(memory)), np.array(masks))
        # Without memory, a state has the mask of all its episodes, or is refused.
        refused = 0
        for values, seen in memories.items():
            try:
                assert {tuple(shield.masks([values])[0])} == seen
            except meliora.UsageError as error:
                assert "depend on the memory" in str(error)
                refused += 1
        assert refused < len(memories)
        with pytest.raises(meliora.UsageError, match="shorter"):
            shield.masks(states, memory[:-1])
        with pytest.raises(meliora.UsageError, match="longer"):
            shield.masks(states[:-1], memory)
        with pytest.raises(meliora.UsageError, match="is not one of the state"):
            shield.masks(states, [memory[0] + 1] + memory[1:])
        with pytest.raises(meliora.UsageError, match="does not know the state"):
            shield.masks([[99, *states[0][1:]]])
        assert shield.masks([]).shape == (0, len(shield.actions))


def test_a_shield_is_pickled_and_copied_with_its_episode() -> None:
    shield = world().strategy("sasi").shield()
    assert len(pickle.loads(pickle.dumps(shield))) == len(shield)
    shield.correct((0, False), "wait")
    twins = [pickle.loads(pickle.dumps(shield)), copy.copy(shield), copy.deepcopy(shield), shield.copy()]
    for twin in twins:
        # `wait` was taken, so `roll` cannot have led here.
        with pytest.raises(meliora.UsageError, match="cannot follow by `wait`"):
            twin.step((2, False))
        assert twin.allowed((0, True)) == ("roll", "wait")
        twin.step((2, True))
    # The episode of the original did not move.
    assert shield.allowed((0, True)) == ("roll", "wait")
    restore, (table, node, taken) = shield.__reduce__()
    for wrong in ((table[:-1], node, taken), (table, 10**6, taken), (table, node, 99), (table.replace(b'"sasi"', b'"best"'), node, taken)):
        with pytest.raises(meliora.UsageError, match="the pickled shield is damaged"):
            restore(*wrong)


def test_the_wrapper_of_gymnasium_corrects_actions() -> None:
    pytest.importorskip("gymnasium", reason="needs gymnasium")
    import gymnasium
    import numpy as np

    from meliora.gym import ShieldedEnv

    class World(gymnasium.Env[Any, Any]):
        action_space: Any = gymnasium.spaces.Discrete(4)
        observation_space: Any = gymnasium.spaces.Discrete(10)

        def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> Any:
            super().reset(seed=seed)
            self.s, self.on = 0, False
            return 0, {"seen": True}

        def step(self, action: int) -> Any:
            if action == 2:
                self.on = not self.on
            else:
                assert action == 0
                self.s = int(self.np_random.integers(1, 3))
            return 2 * self.s + self.on, 0.0, self.s > 0, False, {}

    shield = world().strategy("sasi").shield()
    envs = [ShieldedEnv(World(), shield.copy(), lambda observed: (observed // 2, observed % 2)) for _ in range(2)]
    vector = gymnasium.vector.SyncVectorEnv([lambda: envs[0], lambda: envs[1]])
    _, infos = vector.reset(seed=[1, 2])
    assert infos["action_mask"].tolist() == 2 * [[True, False, True, False]]
    # One waits, the other decides.
    _, _, ends, _, infos = vector.step(np.array([2, 0]))
    assert ends.tolist() == [False, True]
    assert infos["action_mask"].tolist() == [[True, False, True, False], [False, False, True, False]]
    assert [mask.tolist() for mask in vector.call("action_masks")] == infos["action_mask"].tolist()

    env = ShieldedEnv(World(), shield, lambda observed: (observed // 2, observed % 2 == 1))
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.action_masks()
    _, info = env.reset(seed=1)
    env.action_masks()[0] = False
    assert env.action_masks().tolist() == [True, False, True, False]
    assert info["seen"] and info["action_mask"].tolist() == [True, False, True, False]
    _, _, over, _, info = env.step(2)
    assert (over, info["corrected"]) == (False, False)
    _, _, over, _, info = env.step(1)
    assert (over, info["corrected"]) == (True, True)
    assert info["action_mask"].tolist() == [False, False, True, False]


def test_the_wrapper_passes_the_check_of_gymnasium() -> None:
    pytest.importorskip("gymnasium", reason="needs gymnasium")
    from gymnasium.utils.env_checker import check_env

    from meliora.gym import ModelEnv, ShieldedEnv

    analysis = world()
    shield = analysis.strategy("sasi").shield()
    explored = analysis.model.explore()
    env = ShieldedEnv(ModelEnv(explored, actions=shield.actions, goal=explored.where("s>=3")), shield)
    check_env(env, skip_render_check=True)
    # Later calls do not change the result of an earlier one.
    _, first = env.reset(seed=1)
    assert first["action_mask"] is not env.reset(seed=1)[1]["action_mask"]


def test_a_label_that_may_violate_a_requirement_is_refused_with_its_state() -> None:
    model = meliora.Model.from_string(
        "mdp module m s : [0..2] init 0; [b] s=0 -> (s'=1); [b] s=0 -> (s'=2); [c] s=0 -> (s'=1); endmodule"
    )
    found = model.check(meliora.Preferences.from_string("objective A = F s=0; require G !(s=1);"))
    with pytest.raises(meliora.UsageError, match=r"in the state s=0, `b\(m#2\)` keeps the requirements"):
        found.strategy("sasi").shield()
