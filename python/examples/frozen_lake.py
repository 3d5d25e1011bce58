"""FrozenLake: the actions that surely improve. Near the goal, one action ends in the goal or where only the hole is sure."""

from typing import Any

import gymnasium

import meliora

lake: Any = gymnasium.make("FrozenLake-v1").unwrapped
model = meliora.Model.from_transitions(lake.P, labels={"goal": [15], "hole": [12]})
wishes = meliora.Preferences({"Hole": 'F "hole"', "Goal": 'F "goal"'}, ["Goal > Hole"])
print(model.check(wishes).strategy("sasi").mask({"state": 14}))
