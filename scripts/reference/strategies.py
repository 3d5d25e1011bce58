"""Sections 5 and 10: what the strategies do in a state where planning starts."""

from dataclasses import replace

from reference.model import almost_sure, layers
from reference.product import secured
from reference.temporal import YES


def gained(preferences, old, new):
    """The members of a class that are strictly preferred to one of another class; all that improve on nothing."""
    if not old and preferences.improves(old, new):
        return set(new)
    return {j for j in new if any((j, i) in preferences.strict for i in old)}


def lost(preferences, old, new):
    if not new and preferences.weakens(old, new):
        return set(old)
    return {i for i in old if any((i, j) in preferences.strict for j in new)}


def explain(analysis, kind, state):
    """For each choice of a state: what the strategies of SASI or SPI say when planning starts there."""
    levels = analysis.levels(kind)
    known = analysis.classes[state] is not None
    game = levels.game(state) if known else None
    kept = {choice.name: nodes for choice, nodes in analysis.kept(state)}
    permitted = {choice.name for choice in levels.permitted(state)} if known else set()
    progress = {choice.name for choice in levels.progress(state)} if known else set()
    found = {}
    for choice in analysis.whole.choices[state]:
        goals = set()
        if game and choice.name in kept:
            goals = {t for t in choice.to if kept[choice.name] & game.goals & game.arena.entered(t)}
        found[choice.name] = {
            "kept": choice.name in kept,
            "permitted": choice.name in permitted,
            "progress": choice.name in progress,
            "successors": {t: successor(analysis, levels, state, t, p, t in goals) for t, p in choice.to.items()},
        }
    return found


def successor(analysis, levels, state, to, probability, goal):
    """What a report says about a successor. Unsafe states have no class and are compared with nothing."""
    preferences, old, new = analysis.preferences, analysis.classes[state], analysis.classes[to]
    compared = old is not None and new is not None
    change = preferences.change(old, new) if compared else "lateral"
    return {
        "probability": probability,
        "unsafe": new is None,
        "most_preferred": sorted(new or ()),
        "change": change,
        "gained": sorted(gained(preferences, old, new)) if compared else [],
        "lost": sorted(lost(preferences, old, new)) if compared else [],
        "rank": levels.rank(to),
        "dropped": analysis.safety == "transition" and change == "weakening",
        "goal": goal,
    }


def achieving(analysis, objective, state):
    """Section 10: the choices that stay in ASWin(F_i), and those of them that come closer to F_i, by name."""
    sure, target = analysis.sure[objective], analysis.targets[objective]
    if state not in sure:
        return [], []
    staying = [choice for choice in analysis.mdp.choices[state] if choice.successors <= sure]
    distance = layers(analysis.mdp.moves, target, sure)
    closer = [c for c in staying if any(distance[t] < distance[state] for t in c.to)]
    return [c.name for c in staying], [c.name for c in closer]


def achieved(analysis, objective, state):
    """Whether an objective is achieved when a path has come to a state: the state is in F_i, or the path up to it shows
    that the formula is satisfied. A formula of which no path shows that is never achieved."""
    if not analysis.play:
        return state in analysis.targets[objective]
    monitors = [monitor.formula for monitor in analysis.product.monitors]
    formula = analysis.formulas[objective]
    if formula not in monitors:
        return False
    must, _ = analysis.product.read(state)[0][monitors.index(formula)]
    return must == YES


def kept_sure(analysis, objective, reference):
    """Section 10, commit: the states where kept choices, compared with a class, achieve an objective surely."""
    if analysis.safety == "prefix":
        arena = analysis.arenas[reference]
        choices = [[choice for choice, _ in arena.moves[s]] for s in analysis.mdp.states]
    else:
        choices = [[choice for choice, _ in analysis.kept(s)] for s in analysis.mdp.states]
    kept = replace(analysis.mdp, choices=choices)
    target = analysis.targets[objective]
    if analysis.play:
        target = secured(analysis.product, kept, analysis.formulas[objective])
    return almost_sure(kept.moves, target)


def pursued(analysis, state, named=None):
    """Section 10, commit: the objective that a plan takes at rank 0, and whether the plan commits; None without one."""
    here = analysis.classes[state]
    members = sorted(here or (), key=lambda i: (i != named, i))
    without = [i for i in members if state in kept_sure(analysis, i, here)]
    return (without[0], False) if without else (members[0], True) if members else None
