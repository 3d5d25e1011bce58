"""Taxi in the rain: the actions after which a delivery without a detour of the passenger remains certain."""

from typing import Any

import gymnasium

import meliora

taxi: Any = gymnasium.make("Taxi-v4", is_rainy=True).unwrapped
astray = [taxi.encode(row, column, 2, 1) for row in range(5) for column in range(5)]
aboard = taxi.encode(4, 0, 4, 1)
model = meliora.Model.from_transitions(taxi.P, labels={"astray": astray}, start=aboard)
wishes = meliora.Preferences({"Direct": '!"astray" U "done"', "Late": 'F "done"'}, ["Direct > Late"])
print(model.check(wishes).strategy("sasi").shield().mask(aboard))
