"""Questions of one command each: `info`, states by rank, levels that are cut, members of a dump, bounds of numbers."""

import random
from fractions import Fraction

from reference.improvement import UNBOUNDED
from reference.model import explore
from reference.reports import counts
from tester.program import key

COMPARE = {"<=": lambda a, b: a <= b, "<": lambda a, b: a < b, ">=": lambda a, b: a >= b, ">": lambda a, b: a > b}


def info(context):
    """Sizes, variables and rewards of the model alone, and of its product with the monitors."""
    program, case, report = context.program, context.case, context.report
    names = program.settings("scope", "engine", "coalition")
    names += program.settings("order") if case.settings["engine"] == "symbolic" else []
    alone, product = (
        program.ask("info", program.model, *names, *more) for more in ([], ["--preferences", program.prefs])
    )
    context.same("counts", counts(explore(context.source, case.settings["scope"], 3000)), alone["counts"])
    expected = {name: count for name, count in report["counts"].items() if name != "unsafe"}
    context.same("counts with monitors", expected, product["counts"])
    earned = [item.startswith("[") for item in case.rewards]
    rewards = [{"name": "cost", "states": earned.count(False), "choices": earned.count(True)}] if earned else []
    if program.model.suffix == ".prism":  # JANI has no items
        context.same("rewards", rewards, alone["rewards"])
    for found in (alone, product):
        variables = found["model"]["variables"]
        symbolic = case.settings["engine"] == "symbolic"
        bits = [f"{v['name']}.{k}" if v["type"] == "int" else v["name"] for v in variables for k in range(v["bits"])]
        context.same(
            "bits of the order", sorted(bits) if symbolic else None, symbolic and sorted(found["order"]) or None
        )
        context.same("nodes", symbolic, found["nodes"] is not None)
    names = [*context.source.named(next(context.source.all_states()))]
    context.same("variables", names, [v["name"] for v in alone["model"]["variables"]])
    context.same("variables with monitors", report["model"]["variables"], product["model"]["variables"])


def ranks(context):
    """`strategy --rank` lists exactly the states of a rank; unsafe states have none."""
    relation, kind = context.relation, ("sasi", "spi", "plan", "achieve")[context.case.seed % 4]
    levels = context.analysis.levels("spi" if kind == "spi" else "sasi")
    options = ["--kind", kind] + (["--objective", context.names[0]] if kind == "achieve" else [])
    safe = [n for n in relation.of if relation.one(n) not in context.analysis.mdp.unsafe]
    for rank in [*range(len(levels.sets) + 2), UNBOUNDED]:
        expected = {name for name in safe if levels.rank(relation.one(name)) == rank}
        report = context.program.about("strategy", *options, "--rank", rank)
        found = [key(entry["state"]) for entry in report["states"]]
        context.same(f"states of rank {rank} of {kind}", (len(found), expected), (len(set(found)), set(found)))
        context.same(f"asked for rank {rank} of {kind}", len(report["states"]), int(report["asked"]))
        known = context.strategy(*options)
        for entry in report["states"]:
            # The rank alone asks neither for the longest path nor for a cycle.
            one = {what: value for what, value in known[key(entry["state"])].items() if what != "cycle"}
            context.same(f"{kind} in {entry['state']} of rank {rank}", {**one, "longest_play": None}, entry)
    limited = context.program.about("strategy", *options, "--rank", 0, "--limit", 1)
    context.same("limited states", min(1, int(limited["asked"])), len(limited["states"]))


def cut(context):
    """`--max-level`: the levels up to a number, and the ranks and actions that they give."""
    relation = context.relation
    most = 1 + context.case.seed % 3
    report = context.program.about("check", "--max-level", most)
    for kind in ("sasi", "spi"):
        found, whole = context.analysis.levels(kind), context.report[kind]
        ended = len(found.sets) < most
        expected = {"levels": whole["levels"][:most], "unbounded": whole["unbounded"] if ended else None}
        context.same(f"{kind} up to level {most}", expected, report[kind])
        for entry in report["initial"]:
            state = relation.one(key(entry["state"]))
            if state not in context.analysis.mdp.unsafe:
                rank, permitted = cut_at(found, state, most)
                where = f"{entry['state']} up to level {most}"
                context.same(f"{kind}_rank of {where}", rank, entry[f"{kind}_rank"])
                context.same(f"{kind}_actions of {where}", permitted, sorted(entry[f"{kind}_actions"]))
        options = ["--kind", kind, "--max-level", str(most)]
        for name, entry in context.strategy(*options).items():
            state = relation.one(name)
            if state in context.analysis.mdp.unsafe:
                continue
            rank, permitted = cut_at(found, state, most)
            context.same(f"{kind}_rank of {dict(name)} up to level {most}", rank, entry[f"{kind}_rank"])
            got = sorted(a["name"] for a in entry["actions"] if a.get("permitted"))
            context.same(f"{kind} permits in {dict(name)} up to level {most}", permitted, got)


def cut_at(levels, state, most):
    """The rank and the permitted actions of a state if the search ends after some levels."""
    rank = levels.rank(state)
    ended = len(levels.sets) < most
    depth = len(levels.sets) if rank == UNBOUNDED else rank
    if ended or depth < most:
        return rank, sorted(c.name for c in levels.permitted(state))
    game = levels.games[most - 1][levels.classes[state]]
    return most, sorted(c.name for c in game.permitted(levels.node(state)))


def bounded(seed, text, most, least):
    """Properties that compare the greatest and the least probability in some states with a number between 0 and 1, each
    with whether it holds in all of them."""
    draw = random.Random(seed)
    values = sorted({value for value in (*most, *least) if 0 < value < 1})
    bounds = [Fraction(draw.randint(1, 99), 100), *map(near, draw.sample(values, min(2, len(values))))]
    compared = comparisons(draw, bounds, 3, most, least)
    return [(f"P{operator}{decimal(bound)} [ {text} ]", holds) for operator, bound, holds in compared]


def comparisons(draw, bounds, amount, most, least):
    """Some operators with each bound, and whether they hold of the greatest or the least values in all states."""
    for bound in bounds:
        for strategies, operator in draw.sample([(s, o) for s in ("", "max", "min") for o in COMPARE], amount):
            least_counts = strategies == "min" or not strategies and operator.startswith(">")
            values = least if least_counts else most
            yield strategies + operator, bound, all(COMPARE[operator](value, bound) for value in values)


def near(value):
    """A decimal number equal to a value, or close to it."""
    tens = Fraction(round(value * 10**12), 10**12)
    return tens if 0 < tens < 1 else Fraction(1, 2)


def decimal(value):
    """The exact text of a decimal number with at most 12 digits."""
    digits = f"{int(value * 10**12):012d}"
    return f"0.{digits}".rstrip("0")


def earning(seed, condition, least, most):
    """The same for expected rewards until a condition."""
    draw = random.Random(seed)
    finite = [value for value in (*least, *most) if value < 10**6]
    bounds = [
        Fraction(draw.randint(1, 30), 10),
        *(Fraction(round(v * 100), 100) for v in draw.sample(finite, min(1, len(finite)))),
    ]
    compared = comparisons(draw, bounds, 2, most, least)
    return [(f'R{{"cost"}}{operator}{float(bound)} [ F {condition} ]', holds) for operator, bound, holds in compared]


ALL = {"info": info, "ranks": ranks, "cut": cut}
