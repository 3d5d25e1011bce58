"""Sections 5 and 10: what the strategies do in a state where planning starts."""

from reference.model import layers, moves_of


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
    distance = layers(moves_of(analysis.mdp), target, sure)
    closer = [c for c in staying if any(distance[t] < distance[state] for t in c.to)]
    return [c.name for c in staying], [c.name for c in closer]


def commits(analysis, state, named=None):
    """Section 10, commit: the objective that a plan takes at rank 0, and whether choices that never weaken suffice."""
    members = sorted(analysis.classes[state], key=lambda i: (i != named, i))
    return next(((i, True) for i in members if analysis.is_kept_sure(i, state)), (members[0], False) if members else None)
