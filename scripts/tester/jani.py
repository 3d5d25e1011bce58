"""Models in JANI with names that PRISM's language does not have.

`Renamed` is the model for the reference: the locations of the automaton `m` are the values of x. `written` is the same
model as a JANI document.
"""

import re
from dataclasses import dataclass, field, fields, replace
from fractions import Fraction

from reference.prism import Program

CONDITION = re.compile(r"\bx *(?:<=|>=|!=|=|<|>) *\d+|\by\b")


@dataclass(eq=False)
class Renamed(Program):
    """A model whose first variable has named values. It comes last in states, after the global variables."""

    locations: list = field(default_factory=list)

    def named(self, state):
        first, *others = super().named(state).items()
        return {**dict(others), first[0]: self.locations[first[1]]}


def renamed(source, locations, actions, rewards):
    """The model with other names for the values of x, for its actions and for its reward structures."""
    first, *others = source.variables
    modules = {
        name: [replace(command, label=actions.get(command.label, "")) for command in commands]
        for name, commands in source.modules.items()
    }
    own = {f.name: getattr(source, f.name) for f in fields(Program)}
    own |= {"modules": modules, "variables": [replace(first, name="m_loc"), *others]}
    own |= {"rewards": {name: source.rewards[structure] for structure, name in rewards.items()}}
    return Renamed(**own, locations=locations)


def written(source, names, labels, properties=()):
    """A model as JANI, with names for the locations, the actions and the reward structures, and conditions on states by
    the names of their labels; None if its initial states depend on both variables."""
    _, actions, rewards = names
    starts = {state[0] for state in source.initial_states()}
    values = {state[1:] for state in source.initial_states()}
    if len(starts) * len(values) != len(source.initial_states()):
        return None
    flags = [
        {"name": variable.name, "type": "bool", **({} if len(values) > 1 else {"initial-value": next(iter(values))[0]})}
        for variable in source.variables[1:]
    ]
    transient = [{"name": name, "type": "bool", "transient": True, "initial-value": False} for name in labels]
    transient += [{"name": n, "type": "real", "transient": True, "initial-value": 0} for n in rewards.values()]
    return {
        "jani-version": 1,
        "name": "wild",
        "type": source.kind,
        "features": ["derived-operators"],
        "actions": [{"name": name} for name in actions.values()],
        "variables": [*flags, *transient],
        "properties": list(properties),
        "automata": [automaton(source, module, names, labels, starts) for module in source.modules],
        "system": {
            "elements": [{"automaton": module} for module in source.modules],
            "syncs": [vector(source, label, name) for label, name in actions.items()],
        },
    }


def reaching(name, flag):
    """A property that asks for the probability to reach the states with a label."""
    values = {"op": "Pmax", "exp": {"op": "F", "exp": flag}}
    expression = {"op": "filter", "fun": "max", "values": values, "states": {"op": "initial"}}
    return {"name": name, "expression": expression}


def automaton(source, module, names, labels, starts):
    """A module: `m` has a location for each value of x, the other one a single location."""
    locations, actions, rewards = names
    if module != "m":
        edges = [edge(source, command, "l", None, actions) for command in source.modules[module]]
        return {"name": module, "locations": [{"name": "l"}], "initial-locations": ["l"], "edges": edges}
    found = []
    for command in source.modules[module]:
        here = {state[0] for state in source.all_states() if command.guard(state)}
        found += [edge(source, command, locations[x], (x, locations), actions) for x in here]
    rows = []
    for x, name in enumerate(locations):
        values = [{"ref": label, "value": over_flag(source, holds, x)} for label, holds in labels.items()]
        values += [{"ref": n, "value": fraction(earned_in(source, s, x))} for s, n in rewards.items()]
        rows.append({"name": name, "transient-values": values})
    first = [locations[x] for x in sorted(starts)]
    return {"name": module, "locations": rows, "initial-locations": first, "edges": found}


def earned_in(source, structure, x):
    """The reward of the states with some value of x, on which alone it depends."""
    state = (x, False)[: len(source.variables)]
    return sum((Fraction(value(state)) for _, guard, value in source.rewards[structure] if guard(state)), Fraction(0))


def fraction(value):
    return {"op": "/", "left": value.numerator, "right": value.denominator}


def over_flag(source, holds, x):
    """A condition on the states with some value of x, as an expression over y."""
    if len(source.variables) == 1:
        return bool(holds((x,)))
    off, on = (bool(holds((x, y))) for y in (False, True))
    return on if on == off else "y" if on else {"op": "¬", "exp": "y"}


def edge(source, command, here, moves, actions):
    """A command as an edge: of `m` with the value of x and all locations, of the other module without."""
    x, locations = moves or (0, ["l"])
    some = (x, False)[: len(source.variables)]
    to = []
    for p, updates in source.weighted(command, some):
        after = [{"ref": "y", "value": over_flag(source, value, x)} for index, value in updates if index == 1]
        aim = next((locations[value(some)] for index, value in updates if index == 0), here)
        probability = {"exp": fraction(p)}
        to.append({"location": aim, "probability": probability, "assignments": after})
    named = {"action": actions[command.label]} if command.label else {}
    return {"location": here, "guard": {"exp": over_flag(source, command.guard, x)}, **named, "destinations": to}


def vector(source, label, name):
    """The synchronisation of a label: all modules take part that have it."""
    members = source.alphabet[label]
    return {"synchronise": [name if module in members else None for module in source.modules], "result": name}


def in_labels(text, labels):
    """A text in which labels stand for conditions on single variables."""
    return CONDITION.sub(lambda found: f'"{labels[found[0]]}"', text)
