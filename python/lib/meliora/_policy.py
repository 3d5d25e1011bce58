"""Strategies of properties that a program can follow."""

from __future__ import annotations

import json
import os
import random
from pathlib import Path
from typing import Any, Mapping


class Policy:
    """A strategy of a property as a function from states to actions, which remembers the path.

    Args:
        policy: What ``ask(policy=True)["policy"]`` is, or the path of a JSON file of ``meliora reach --policy``.
        seed: The seed of draws, for strategies with chance, such as those of ``multi``.

    Example:
        >>> import meliora
        >>> model = meliora.Model.from_file("models/drone.prism", constants={"B": 6, "wind": 0.2})
        >>> policy = meliora.Policy(model.ask('Pmax=? [ F<=4 "goal" ]', policy=True)["policy"])  # doctest: +SKIP
        >>> policy({"x": 0, "y": 0})  # doctest: +SKIP
        'east'
    """

    def __init__(self, policy: str | os.PathLike[str] | dict[str, Any], seed: int | None = None) -> None:
        found = policy if isinstance(policy, dict) else json.loads(Path(policy).read_text(encoding="utf-8"))
        if not isinstance(found, dict) or "strategies" not in found:
            raise ValueError("expected the strategies of a property: a list of rules has no memory, and is read as it is")
        self.property: str = found["property"]
        self._strategies: list[dict[str, Any]] = found["strategies"]
        self._random = random.Random(seed)
        self.reset()

    @property
    def values(self) -> list[Any]:
        """The values that the strategy in use attains: one, or one for each objective of ``multi``."""
        return list(self._strategy["values"])

    def reset(self) -> None:
        """Forgets the path, and draws one of several strategies."""
        shares = [float(_fraction(own["share"])) for own in self._strategies if own["share"] is not None]
        one = len(shares) == len(self._strategies) > 1
        drawn = self._random.choices(range(len(shares)), shares)[0] if one else 0
        self._strategy = self._strategies[drawn]
        self._open = list(range(self._strategy.get("starts") or 1))

    def __call__(self, state: Mapping[str, Any]) -> str | None:
        """Returns the action in the next state of the path; None where the path is decided, or another side chooses.

        Raises:
            KeyError: The strategy does not come to this state now.
        """
        nodes, wanted = self._strategy["nodes"], dict(state)
        found = next((at for at in self._open if nodes[at]["state"] == wanted), None)
        if found is None:
            raise KeyError(f"the strategy does not come to this state now: {wanted}")
        actions = nodes[found]["actions"]
        if not actions:
            self._open = [found]
            return None
        if nodes[found].get("other"):
            self._open = [to["node"] for action in actions for to in action["successors"]]
            return None
        taken = self._random.choice(actions)
        self._open = [to["node"] for to in taken["successors"]]
        action: str = taken["action"]
        return action

    def table(self) -> list[dict[str, Any]]:
        """Returns one row for each state with memory: ``node``, ``state``, ``memory``, ``steps`` and ``action``."""
        return [
            {
                "node": at,
                "state": node["state"],
                "memory": node.get("memory"),
                "steps": node.get("steps", 0),
                "action": None if node.get("other") else " | ".join(own["action"] for own in node["actions"]) or None,
            }
            for at, node in enumerate(self._strategy["nodes"])
        ]


def _fraction(share: Any) -> float:
    above, _, below = str(share).partition("/")
    return float(above) / float(below or 1)
