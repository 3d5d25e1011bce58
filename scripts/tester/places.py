"""`--at`: several states in one question, one of which may not be in the scope."""

import random

from tester.program import at, key, rounded


def places(context):
    """States that are asked about together have the answers that each has alone; with a state that is not in the scope
    none is answered."""
    draw, program = random.Random(context.case.seed), context.program
    if draw.random() < 0.5:
        return
    states = draw.choices(context.check_states, k=3)  # one may be named twice
    odd = unreached(context, draw)
    commands = [("strategy", "--kind", draw.choice(["sasi", "spi"]))]
    commands += [("simulate", "--runs", "3")] + ([] if context.is_game else [("values", "--levels", "2")])
    for command, *options in commands:
        found = program.about(command, *options, *words(states)).get("plays" if command == "simulate" else "states")
        context.same(f"states of {command}", list(map(key, states)), [key(entry["state"]) for entry in found])
        if command != "simulate":  # runs are drawn
            for state, entry in zip(states, found):
                (one,) = program.about(command, *options, *words([state]))["states"]
                context.same(f"{command} in {state} alone", rounded(one), rounded(entry))
        if odd is not None:
            settings = program.settings("scope", "safety", "coalition")
            asked = words([states[0], odd, states[1]])
            status, _, errors = program.run(command, program.model, program.prefs, *settings, *options, *asked)
            context.same(f"refusal of {odd}", (3, 1), (status, errors.count("no path reaches the state")))


def words(states):
    return [word for state in states for word in ("--at", at(state))]


def unreached(context, draw):
    """A state that is not in the scope, by the variables of the model; None without one."""
    relation, source = context.relation, context.source
    monitors = list(context.report["initial"][0]["state"].items())[relation.width :]
    named = [source.named(values) for values in source.all_states()]
    found = [state for state in named if (*state.items(), *monitors) not in relation.of]
    return draw.choice(found) if found else None


ALL = {"places": places}
