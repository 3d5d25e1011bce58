"""The checks of what `check`, `strategy` and `values` say, against the reference."""

import math
from fractions import Fraction

from reference.reports import shares
from reference.strategies import explain
from tester.context import LEVELS, WITHIN
from tester.program import key

PRECISION = Fraction(1, 10**6)
NO_VALUES = {"unsafe": True, "levels": [], "number": None, "within": None}


def model(context):
    """States, actions and successors of the program are those of the reference."""
    context.same("states", "", context.relation.wrong[0] if context.relation.wrong else "")


def counts(context):
    """Sizes of the model, outcomes, classes, improvement MDP and levels."""
    report, analysis, relation = context.report, context.analysis, context.relation
    whole, mdp = analysis.whole, analysis.mdp
    everywhere = [relation.one(name) for name in relation.of]
    expected = {
        "states": str(len(everywhere)),
        "choices": str(sum(len(whole.choices[s]) for s in everywhere)),
        "transitions": str(sum(len(c.to) for s in everywhere for c in whole.choices[s])),
        "deadlocks": relation.count(whole.deadlocks),
        "initial": str(len(whole.initial)),
    }
    if context.preferences.required:
        expected["unsafe"] = relation.count(mdp.unsafe)
    if analysis.play:
        expected["model_states"] = str(len({name[: relation.width] for name in relation.of}))
    context.same("counts", expected, report["counts"])
    for i, entry in enumerate(report["objectives"]):
        context.same(f"almost_sure of {entry['name']}", relation.count(analysis.sure[i]), entry["almost_sure"])
        context.same(f"positive of {entry['name']}", relation.count(analysis.positive[i]), entry["positive"])
        expected = shares(analysis, i)
        context.same(f"shares of {entry['name']}", expected, {what: entry[what] for what in expected})
        if context.secured(i) is not None:
            context.same(f"target of {entry['name']}", relation.count(analysis.targets[i]), entry["target"])
        context.same(f"observer of {entry['name']}", analysis.play, "observer" in entry)
    classes = {}
    for name in relation.of:
        members = analysis.classes[relation.one(name)]
        if members is not None:
            shown = ",".join(context.named(members))
            classes[shown] = classes.get(shown, 0) + 1
    got = {",".join(entry["most_preferred"]): int(entry["states"]) for entry in report["classes"]}
    context.same("classes", classes, got)
    improvement(context, [s for s in everywhere if s not in mdp.unsafe])


def improvement(context, safe):
    report, analysis, relation = context.report, context.analysis, context.relation
    if analysis.safety == "prefix":
        context.same("improvement", None, report["improvement"])
    else:
        kept = sum(len(nodes) for s in safe for _, nodes in analysis.kept(s))
        restricted = sum(len(c.to) for s in safe for c in analysis.mdp.choices[s])
        expected = {"states": str(2 * len(safe)), "transitions": str(2 * kept), "dropped": str(restricted - kept)}
        context.same("improvement", expected, report["improvement"])
    for kind in ("sasi", "spi"):
        levels = analysis.levels(kind)
        expected = {"levels": [relation.count(w) for w in levels.sets], "unbounded": relation.count(levels.fixpoint)}
        context.same(f"{kind} levels", expected, report[kind])


def initial(context):
    """What `check` says about initial states."""
    analysis, relation = context.analysis, context.relation
    for entry in context.report["initial"]:
        state = relation.one(key(entry["state"]))
        known = analysis.classes[state] is not None
        if not context.same(f"unsafe of {entry['state']}", not known, "unsafe" in entry) or not known:
            continue
        context.same("most_preferred", context.named(analysis.classes[state]), entry["most_preferred"])
        for what, regions in (("sure", analysis.sure), ("possible", analysis.positive)):
            context.same(what, context.named(i for i, region in enumerate(regions) if state in region), entry[what])
        for kind in ("sasi", "spi"):
            levels = analysis.levels(kind)
            context.same(f"{kind}_rank", levels.rank(state), entry[f"{kind}_rank"])
            permitted = sorted(c.name for c in levels.permitted(state))
            context.same(f"{kind}_actions", permitted, sorted(entry[f"{kind}_actions"]))


def strategies(context):
    """What the strategies of SASI and SPI do in every state."""
    for kind in ("sasi", "spi"):
        answers = context.strategy("--kind", kind)
        for name, states in context.relation.of.items():
            for state in states:
                strategy_at(context, kind, dict(name), state, answers[name])


def strategy_at(context, kind, named, state, entry):
    analysis = context.analysis
    context.same(f"unsafe of {named}", analysis.classes[state] is None, entry.get("unsafe", False))
    context.same(f"most_preferred of {named}", context.named(analysis.classes[state]), entry["most_preferred"])
    for other in ("sasi", "spi"):
        context.same(f"{other}_rank of {named}", analysis.levels(other).rank(state), entry[f"{other}_rank"])
    expected, theirs = explain(analysis, kind, state), state in analysis.whole.theirs
    mover_of(context, named, state, entry)
    for action in entry["actions"]:
        here, where = expected[action["name"]], f"{kind} {action['name']} in {named}"
        for what in ("kept", "permitted", "progress", "verdict"):
            # What the opponent does is neither permitted nor forbidden.
            context.same(f"{what} of {where}", None if theirs and what != "verdict" else here[what], action.get(what))
        plain = {key(context.source.named(analysis.whole.plain(t))): t for t in here["successors"]}
        for successor in action["successors"]:
            to = plain[key(successor["state"])[: context.relation.width]]
            successor_of(context, f"{where} to {successor['state']}", here["successors"][to], successor)
    if theirs:
        taken = entry.keys() & {"progress_action", "chosen_action"}
        context.same(f"actions of strategies in {named}", set(), taken)
        return
    progress = [name for name, here in expected.items() if here["progress"]]
    context.same(f"progress_action of {named}", bool(progress), entry["progress_action"] is not None)
    context.same(f"progress_action of {named}", True, entry["progress_action"] in (progress or [None]))


def mover_of(context, named, state, entry):
    """Who chooses in a state of a game."""
    whole = context.analysis.whole
    at = whole.owners[state] if whole.owners else None
    expected = ("opponent" if state in whole.theirs else None, None if at is None else [*context.source.players][at])
    context.same(f"owner of {named}", expected, (entry.get("owner"), entry.get("player")))


def successor_of(context, where, expected, got):
    near = math.isclose(expected["probability"], got["probability"], rel_tol=1e-9, abs_tol=1e-300)
    context.same(f"probability of {where}", True, near)
    context.same(f"unsafe of {where}", expected["unsafe"], got.get("unsafe", False))
    for what in ("change", "rank", "dropped", "goal"):
        context.same(f"{what} of {where}", expected[what], got[what])
    for what in ("most_preferred", "gained", "lost"):
        context.same(f"{what} of {where}", context.named(expected[what]), got[what])


def values(context):
    """Probabilities, costs, numbers and curves of every state."""
    relation, quantities = context.relation, context.quantities
    numbers, curves = quantities.numbers(), quantities.within(LEVELS, WITHIN)
    entries = {key(entry["state"]): entry for entry in context.values["states"]}
    context.same("states", relation.of.keys(), entries.keys())
    for name, entry in entries.items():
        node = quantities.own(relation.one(name))
        if relation.one(name) in context.analysis.mdp.unsafe:
            found = {what: entry[what] for what in ("unsafe", "levels", "number", "within")}
            context.same(f"values of {dict(name)}", NO_VALUES, found)
            continue
        context.within(f"N of {dict(name)}", numbers.get(node, Fraction(0)), entry["number"])
        for level in entry["levels"]:
            level_of(context, node, dict(name), level)
            for n, p in enumerate(level.get("within") or []):
                value = curves[level["improvements"] - 1][n].get(node, Fraction(0))
                near = abs(Fraction(p) - value) <= Fraction(1, 10**9)
                context.same(f"P^{n} of {dict(name)}", "" if near else float(value), "" if near else p)


def level_of(context, node, named, level):
    k = level["improvements"]
    (probabilities, actions), (costs, paid) = context.probabilities[k - 1], context.costs[k - 1]
    precision = math.inf if context.is_rare() else PRECISION
    context.within(f"P_{k} of {named}", probabilities.get(node, Fraction(0)), level["probability"], precision)
    context.within(f"C_{k} of {named}", costs.get(node), level["cost"], precision)
    possible = {a.name: a for a in actions.get(node, [])} if context.probabilities[0][0].get(node) else {}
    certain = {a.name: a for a in paid.get(node, [])}
    context.same(f"actions of P_{k} of {named}", sorted(possible), sorted(a["action"] for a in level["actions"]))
    for action in level["actions"]:
        here = possible.get(action["action"])
        if here:
            where = f"of {action['action']} in {named}"
            context.within(f"P_{k} {where}", here.value(probabilities), action["probability"], precision)
            sure = certain.get(action["action"])
            context.within(f"C_{k} {where}", sure and sure.value(costs), action["cost"], precision)


def choices(context):
    """`--choose likely` and `cheap`: the chosen action attains the value, without an opponent in the fewest steps."""
    for choose, kind in (("likely", "spi"), ("cheap", "sasi")):
        reward = context.program.settings("reward") if choose == "cheap" else []
        answers = context.strategy("--choose", choose, "--levels", str(LEVELS), *reward)
        for name, entry in answers.items():
            node = context.quantities.own(context.relation.one(name))
            choice_of(context, choose, dict(name), node, entry)
            if not context.is_rare() and not context.is_game:
                fewest_of(context, choose, dict(name), node, entry)


def is_near(value, best):
    return abs(value - best) <= PRECISION * max(1, best)


def choice_of(context, choose, named, node, entry):
    tables = context.probabilities if choose == "likely" else context.costs
    able = [k for k, (table, _) in enumerate(tables, 1) if (table.get(node) if choose == "likely" else node in table)]
    attains, chosen = entry["attains"], entry.get("chosen_action")
    if not able:
        context.same(
            f"{choose} aims of {named}", (None, 0), (chosen, attains["improvements"] if attains else 0)
        )
        return
    k = max(able)
    if not context.same(f"{choose} aims of {named}", k, attains and attains["improvements"]):
        return
    (table, actions), probability = tables[k - 1], context.probabilities[k - 1][0][node]
    precision = math.inf if context.is_rare() else PRECISION
    context.within(f"{choose} P_{k} of {named}", probability, attains["probability"], precision)
    if choose == "cheap":
        context.within(f"C_{k} of {named}", table[node], attains["cost"], precision)
    if context.relation.one(key(entry["state"])) in context.analysis.whole.theirs:
        return
    # Values that differ by less than the precision are equal to the program.
    values = {a.name: a.value(table) for a in actions[node]}
    best = [name for name, v in values.items() if v not in (None, math.inf) and is_near(v, table[node])]
    context.same(f"{choose} action of {named}", True, chosen in best)


def fewest_of(context, choose, named, node, entry):
    """Of the actions that attain the value, the chosen one needs the fewest steps."""
    k = entry["attains"]["improvements"] if entry["attains"] else 0
    table, actions = context.steps[choose][k - 1] if k else ({}, {})
    if node in table:
        value = next((a.value(table) for a in actions[node] if a.name == entry["chosen_action"]), None)
        fewest = value is not None and is_near(value, table[node])
        context.same(f"{choose} needs the fewest steps from {named}", True, fewest)


ALL = {"model": model, "check": counts, "initial": initial, "strategy": strategies, "values": values, "choose": choices}
