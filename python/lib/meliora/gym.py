"""Environments of Gymnasium: one that behaves as a model says, and a shield for any. Needs the package ``gymnasium``."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Literal, Union

import gymnasium
import numpy as np

from ._native import Exploration, Region, Shield
from .errors import UsageError

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["ModelEnv", "ShieldedEnv"]

_State = dict[str, Any]
#: A policy of the opponent: it takes one of the actions of a state.
_Policy = Callable[[_State, Sequence[str]], str]


class ModelEnv(gymnasium.Env[Any, Any]):
    """An environment that behaves as a model says: an mdp, or a game in which only we act.

    In a game the opponent moves inside ``reset`` and ``step``, until it is our turn: one step is our action and all its
    answers. An observation is an array with the values of the variables, Booleans as 0 and 1, names of values as numbers;
    it is also a state of a shield. The action ``i`` is ``actions[i]``; to take one that is not enabled raises UsageError. So
    Gymnasium's ``check_env``, which takes any action, needs the environment within a ShieldedEnv.

    ``info`` has ``action_mask``, the enabled actions; ``state``, the state as a dictionary; and ``moves``, what happened since
    our turn: for each step the player (None if the model is not a game), the action, and the state after it. ``info`` of
    ``reset`` also has ``start``, the state before these moves.

    The reward is 1 for the step that enters ``goal``, and 0 for all others. An episode is terminated in ``goal`` and in
    deadlocks, and truncated if the opponent moves ``patience`` times without giving us a turn.

    Args:
        explored: The states of the model: ``model.explore()``.
        opponent: How the opponent chooses: "random" draws one of its actions uniformly, with the seed of ``reset``; a function
            gets the state and the names of the actions, and returns one of them. Promises of shields and strategies hold
            against each opponent; a worst one is not found by chance.
        goal: The states that end an episode; None for no goal.
        start: The state where episodes start; None for the initial states, of which one is drawn. ``reset`` with
            ``options={"state": …}`` starts elsewhere.
        actions: The names of the actions, as ``shield.actions``; None for those of the model.
        patience: The greatest number of moves of the opponent in a row.
    """

    def __init__(
        self,
        explored: Exploration,
        *,
        opponent: Union[Literal["random"], _Policy] = "random",
        goal: Region | None = None,
        start: _State | None = None,
        actions: Sequence[str] | None = None,
        patience: int = 1000,
    ) -> None:
        if opponent != "random" and not callable(opponent):
            raise UsageError(f"opponent={opponent!r}: it is \"random\" or a function")
        self.explored, self.goal, self.start, self.patience = explored, goal, start, patience
        self.actions = tuple(explored.model.actions if actions is None else actions)
        self._opponent = None if opponent == "random" else opponent
        self._theirs, self._deadlocks = explored.theirs, explored.deadlocks
        self._variables = list(explored.model.variables.values())
        low, high = ([getattr(v, end) for v in self._variables] for end in ("low", "high"))
        self.observation_space = gymnasium.spaces.Box(np.array(low), np.array(high), dtype=np.int64)
        self.action_space = gymnasium.spaces.Discrete(len(self.actions))
        self._now: _State | None = None

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        super().reset(seed=seed)
        start = (options or {}).get("state", self.start)
        if start is None:
            drawn = int(self.np_random.integers(2**63))
            (start,) = self.explored.initial.sample(1, seed=drawn)
        elif start not in self.explored.states:
            raise UsageError(f"{start} is not a state of the scope")
        self._now = dict(start)
        moves: list[tuple[str | None, str, _State]] = []
        self._answer(moves)
        return self._observation(), {**self._info(moves), "start": dict(start)}

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        if self._is_over():
            raise gymnasium.error.ResetNeeded("the episode is over: call `reset` first")
        moves: list[tuple[str | None, str, _State]] = []
        self._take(self._choice(self.actions[int(action)]), moves)
        ours = self._answer(moves)
        over = self._is_over()
        reached = self.goal is not None and self._state() in self.goal
        return self._observation(), float(reached), over, not ours and not over, self._info(moves)

    def action_masks(self) -> NDArray[np.bool_]:
        """Returns the enabled actions. MaskablePPO of the package ``sb3-contrib`` calls this."""
        waits = self._is_over() or self._state() in self._theirs
        enabled = [] if waits else list(self.explored.successors(self._state()))
        return np.array([any(_is_called(name, action) for name in enabled) for action in self.actions], dtype=bool)

    def _state(self) -> _State:
        if self._now is None:
            raise gymnasium.error.ResetNeeded("there is not an episode yet: call `reset` first")
        return self._now

    def _is_over(self) -> bool:
        state = self._state()
        return state in self._deadlocks or (self.goal is not None and state in self.goal)

    def _choice(self, action: str) -> str:
        """Returns the one enabled choice with a label."""
        enabled = [name for name in self.explored.successors(self._state()) if _is_called(name, action)]
        if len(enabled) != 1:
            problem = "is not enabled" if not enabled else f"stands for several choices: {', '.join(enabled)}"
            raise UsageError(f"the action `{action}` {problem} in {self._now}")
        return enabled[0]

    def _take(self, choice: str, moves: list[tuple[str | None, str, _State]]) -> None:
        state = self._state()
        successors = self.explored.successors(state)[choice]
        weights = np.array([probability for probability, _ in successors])
        drawn = int(self.np_random.choice(len(successors), p=weights / weights.sum()))
        self._now = successors[drawn][1]
        moves.append((self.explored.owner(state), choice, self._now))

    def _answer(self, moves: list[tuple[str | None, str, _State]]) -> bool:
        """Lets the opponent move, `patience` times at most; returns whether it is our turn then."""
        for _ in range(self.patience):
            if self._is_over() or self._state() not in self._theirs:
                break
            self._take(self._answered(), moves)
        return self._state() not in self._theirs

    def _answered(self) -> str:
        """Returns the choice of the opponent."""
        enabled = list(self.explored.successors(self._state()))
        if self._opponent is None:
            return enabled[int(self.np_random.integers(len(enabled)))]
        chosen = self._opponent(dict(self._state()), enabled)
        if chosen not in enabled:
            raise UsageError(f"the opponent took {chosen!r} in {self._now}; its actions are {', '.join(enabled)}")
        return chosen

    def _observation(self) -> NDArray[np.int64]:
        state = self._state()
        numbers = [v.low + v.values.index(state[v.name]) if v.values else int(state[v.name]) for v in self._variables]
        return np.array(numbers, dtype=np.int64)

    def _info(self, moves: list[tuple[str | None, str, _State]]) -> dict[str, Any]:
        return {"action_mask": self.action_masks(), "state": dict(self._state()), "moves": moves}


def _is_called(name: str, action: str) -> bool:
    """Returns whether a choice has a label: a choice among several with one label is called ``label(…)``."""
    return name == action or name.startswith(f"{action}(")


class ShieldedEnv(gymnasium.Wrapper[Any, Any, Any, Any], gymnasium.utils.RecordConstructorArgs):
    """An environment that takes only actions that a shield permits.

    ``info["action_mask"]`` of ``reset`` and ``step`` says which actions are permitted next, and ``info["corrected"]`` of
    ``step`` is True if another action was taken than the one asked for. ``state`` converts an observation to a state of the
    shield; without it, observations are states. The action ``i`` of the environment is ``shield.actions[i]``.

    A shield keeps its promise only if the environment behaves as the model says. A step that the model does not have raises
    UsageError. After the end of an episode the mask is that of the last state. A shield has one episode, so each environment
    of a vector needs a copy: ``shield.copy()``.

    The shield of a game keeps its promise against every opponent. If the opponent moves inside the environment, the shield
    has to see its moves: ``info["moves"]`` lists, after each step, what happened since our turn, and ``info["start"]`` of
    ``reset`` is where the episode started, as ``ModelEnv`` does.
    """

    def __init__(
        self, env: gymnasium.Env[Any, Any], shield: Shield, state: Callable[[Any], Any] | None = None
    ) -> None:
        # So that `gymnasium.make` can build it again from its `spec`; a shield has one episode.
        gymnasium.utils.RecordConstructorArgs.__init__(self, _disable_deepcopy=True, shield=shield.copy(), state=state)
        gymnasium.Wrapper.__init__(self, env)
        self.shield = shield
        self._state = state or _itself
        self._now: Any = None

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        observation, info = self.env.reset(seed=seed, options=options)
        self._now = self._state(observation)
        # The opponent may have moved already; what counts is the whole episode.
        self.shield.reset(info.get("start", self._now))
        for _, _, entered in info.get("moves", ()):
            self.shield.step(entered)
        return observation, {**info, "action_mask": self.action_masks()}

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        asked = int(action)
        taken = self.shield.correct(self._now, asked)
        observation, reward, terminated, truncated, info = self.env.step(taken)
        self._now = self._state(observation)
        for _, _, entered in info.get("moves", ()):
            self.shield.step(entered)
        info = {**info, "action_mask": self.action_masks(), "corrected": taken != asked}
        return observation, reward, terminated, truncated, info

    def action_masks(self) -> NDArray[np.bool_]:
        """Returns the actions that are permitted next, in an array that may be written. MaskablePPO of the package
        ``sb3-contrib`` calls this.
        """
        if self._now is None:
            raise gymnasium.error.ResetNeeded("`action_masks` needs an episode: call `reset` first")
        return self.shield.mask(self._now).copy()


def _itself(observation: Any) -> Any:
    # A function with a name, so that the environment can be pickled.
    return observation
