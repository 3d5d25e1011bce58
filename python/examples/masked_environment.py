"""An environment as reinforcement learning has them, whose action mask permits what surely improves.

The interface is Gymnasium's: `reset` and `step` return an observation and an `info` with the mask, so that an agent that
takes masks explores without ever losing what the strategy promises.
"""

import random
from pathlib import Path
from typing import Any

import numpy as np

import meliora

models = Path(__file__).resolve().parents[2] / "models"


class Robot:
    """The robot of the paper; a reward of 1 for each improvement."""

    def __init__(self, model: meliora.Model, strategy: meliora.Strategy) -> None:
        self.model, self.strategy = model, strategy
        self.actions = model.actions

    def reset(self, seed: int) -> tuple[np.ndarray, dict[str, Any]]:
        self.random = random.Random(seed)
        self.play = self.strategy.play(self.model.state())
        return self.observe()

    def step(self, action: int) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        enabled = {taken.name: taken for taken in self.play.explain().actions}
        successors = enabled[self.actions[action]].successors
        weights = [successor.probability for successor in successors]
        after = self.random.choices(successors, weights)[0].state
        improved = self.play.step(after)
        observation, info = self.observe()
        return observation, float(improved), self.play.over, False, info

    def observe(self) -> tuple[np.ndarray, dict[str, Any]]:
        return np.array(list(self.play.state.values()), dtype=int), {"action_mask": self.play.mask()}


model = meliora.Model.from_file(models / "robot5x5.prism")
strategy = model.check(models / "robot5x5.pref").strategy("sasi")
environment = Robot(model, strategy)
totals = []
for episode in range(200):
    observation, info = environment.reset(seed=episode)
    agent, total, over = random.Random(episode), 0.0, False
    while not over:
        action = agent.choice(np.flatnonzero(info["action_mask"]))
        observation, reward, over, _, info = environment.step(action)
        total += reward
    totals.append(total)
print(f"At least {min(totals):.0f} in each of {len(totals)} plays: improvements")
