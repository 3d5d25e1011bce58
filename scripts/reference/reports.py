"""The reports of the commands `info`, `reach` and `check`: the fields that the definitions cover."""

import math

from reference.analysis import Analysis
from reference.model import explore, reachability
from reference.questions import Question
from reference.leaves import cases, conditions
from reference.temporal import Monitor


def counts(mdp, analysis=None):
    states = analysis.distinct(mdp.states) if analysis else mdp.states
    found = {
        "states": str(len(states)),
        "choices": str(sum(len(mdp.choices[s]) for s in states)),
        "transitions": str(sum(len(c.to) for s in states for c in mdp.choices[s])),
        "deadlocks": str(len(mdp.deadlocks.intersection(states))),
        "initial": str(len(mdp.initial)),
    }
    if analysis and analysis.play:
        found["model_states"] = str(len({mdp.plain(s) for s in mdp.states}))
    if analysis and analysis.preferences.required:
        found["unsafe"] = str(len(analysis.mdp.unsafe.intersection(states)))
    return found


def info(program, scope="reachable", limit=None):
    return {"model": {"constants": program.constants}, "counts": counts(explore(program, scope, limit))}


def reach(program, scope, target=None, formula=None, limit=None, coalition=()):
    """The four regions of a target or of a formula."""
    coalition = program.named_players(coalition)
    if target is not None:
        whole = explore(program, scope, limit).played_by(coalition)
        found = whole.where(target)
        regions, report = reachability(whole, found), {"target": str(len(found))}
    else:
        question = Question(program, scope, formula, limit=limit, coalition=coalition)
        whole, regions, report = question.whole, question.regions(), {}
    report.update(scope=scope, counts=counts(whole), **{name: str(len(region)) for name, region in regions.items()})
    report["initial"] = {name: amount(region, whole.initial) for name, region in regions.items()}
    return report


def amount(region, states):
    held = [s in region for s in states]
    return "all" if all(held) else "some" if any(held) else "none"


def check(program, preferences, scope="reachable", safety="prefix", limit=None, coalition=()):
    analysis = Analysis(program, preferences, scope, safety, limit, coalition)
    mdp, names = analysis.mdp, preferences.names
    known = [analysis.classes[s] for s in analysis.distinct(mdp.states) if s not in mdp.unsafe]
    return {
        "model": {"constants": program.constants},
        "players": players(analysis.whole, coalition or preferences.coalition),
        "scope": scope,
        "safety": safety,
        "empty": preferences.empty,
        "counts": counts(analysis.whole, analysis),
        "objectives": [objective(analysis, i) for i in range(len(names))],
        "classes": [
            {"most_preferred": [names[i] for i in sorted(c)], "states": str(known.count(c))}
            for c in sorted(set(known), key=sorted)
        ],
        "improvement": improvement(analysis),
        **{kind: levels(analysis, kind) for kind in ("sasi", "spi")},
        "initial": [initially(analysis, s) for s in mdp.initial[:16]],
    }


def players(mdp, coalition=()):
    """The players of a game; empty for other models."""
    ours = mdp.program.named_players(coalition)
    return [
        {"name": name, "ours": at in ours, "states": str(mdp.owners.count(at))}
        for at, name in enumerate(mdp.program.players)
    ]


def objective(analysis, number):
    regions = {"target": analysis.targets, "almost_sure": analysis.sure, "positive": analysis.positive}
    found = {"name": analysis.preferences.names[number]}
    found.update({name: str(len(analysis.distinct(region[number]))) for name, region in regions.items()})
    found.update(shares(analysis, number))
    if analysis.play:
        leaves = {leaf for case in cases(conditions(analysis.formulas[number])) for _, leaf in case}
        found["observer"] = math.prod(len(set(Monitor(leaf).residuals().values())) for leaf in leaves)
    return found


def share(inside):
    """`all`, `some` or `none` of the initial states, of which the list says whether they are in a region."""
    return "all" if all(inside) else "some" if any(inside) else "none"


def shares(analysis, number):
    """The initial states in which an objective is sure, and in which it is possible."""
    regions = {"sure": analysis.sure, "possible": analysis.positive}
    return {name: share([s in region[number] for s in analysis.whole.initial]) for name, region in regions.items()}


def improvement(analysis):
    """Section 4: the numbers are those of V = S x {0,1}; dropped transitions are counted over S."""
    if analysis.safety == "prefix":
        return None
    safe = analysis.distinct(set(analysis.mdp.states) - analysis.mdp.unsafe)
    kept = sum(len(nodes) for s in safe for _, nodes in analysis.kept(s))
    dropped = sum(len(c.to) for s in safe for c in analysis.mdp.choices[s]) - kept
    return {"states": str(2 * len(safe)), "transitions": str(2 * kept), "dropped": str(dropped)}


def levels(analysis, kind):
    found = analysis.levels(kind)
    sizes = [str(len(analysis.distinct(states))) for states in found.sets]
    return {"levels": sizes, "unbounded": str(len(analysis.distinct(found.fixpoint)))}


def initially(analysis, state):
    """The entry of an initial state; an unsafe one has neither class nor rank."""
    named = analysis.program.named(analysis.whole.plain(state))
    if state in analysis.mdp.unsafe:
        return {"state": named, "unsafe": {}}
    sasi, spi = analysis.levels("sasi"), analysis.levels("spi")
    return {
        "state": named,
        **({"owner": "opponent"} if state in analysis.whole.theirs else {}),
        "sure": [name for name, region in zip(analysis.preferences.names, analysis.sure) if state in region],
        "possible": [name for name, region in zip(analysis.preferences.names, analysis.positive) if state in region],
        "most_preferred": [analysis.preferences.names[i] for i in sorted(analysis.classes[state])],
        "sasi_rank": sasi.rank(state),
        "spi_rank": spi.rank(state),
        "sasi_actions": [c.name for c in sasi.permitted(state)],
        "spi_actions": [c.name for c in spi.permitted(state)],
    }
