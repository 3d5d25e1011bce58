"""CliffWalking on slippery ground: the actions after which a dry way to the goal remains certain."""

from typing import Any

import gymnasium

import meliora

cliff: Any = gymnasium.make("CliffWalking-v1", is_slippery=True).unwrapped
model = meliora.Model.from_transitions(cliff.P, labels={"fallen": [36]}, start=[24])
wishes = meliora.Preferences({"Dry": '!"fallen" U "done"', "Wet": 'F "done"'}, ["Dry > Wet"])
print(model.check(wishes).strategy("sasi").shield().mask(24))
