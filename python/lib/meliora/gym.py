"""A shield for environments of Gymnasium. Needs the package ``gymnasium``."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import gymnasium

from ._native import Shield

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

__all__ = ["ShieldedEnv"]


class ShieldedEnv(gymnasium.Wrapper[Any, Any, Any, Any]):
    """An environment that takes only actions that a shield permits.

    ``info["action_mask"]`` of ``reset`` and ``step`` says which actions are permitted next, and ``info["corrected"]`` of
    ``step`` is True if another action was taken than the one asked for. ``state`` converts an observation to a state of the
    shield; without it, observations are states. The action ``i`` of the environment is ``shield.actions[i]``.

    A shield keeps its promise only if the environment behaves as the model says. A step that the model does not have raises
    UsageError. After the end of an episode the mask is that of the last state. A shield has one episode, so each environment
    of a vector needs a copy: ``shield.copy()``.
    """

    def __init__(
        self, env: gymnasium.Env[Any, Any], shield: Shield, state: Callable[[Any], Any] | None = None
    ) -> None:
        super().__init__(env)
        self.shield = shield
        self._state = state or _itself
        self._now: Any = None

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        observation, info = self.env.reset(seed=seed, options=options)
        self._now = self._state(observation)
        self.shield.reset(self._now)
        return observation, {**info, "action_mask": self.shield.mask(self._now)}

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        asked = int(action)
        taken = self.shield.correct(self._now, asked)
        observation, reward, terminated, truncated, info = self.env.step(taken)
        self._now = self._state(observation)
        info = {**info, "action_mask": self.shield.mask(self._now), "corrected": taken != asked}
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
