"""Dumps: their regions, their members and choices, and what `verify` says of them."""

import csv
import json
import math
import random
from fractions import Fraction

import harness
from tester.context import LEVELS
from tester.program import at, key


def dumps(context):
    """A dump has the right regions, also in `query`, and `verify` accepts it."""
    relation, program = context.relation, context.program
    folder = program.folder / "dump"
    # Under `prefix`, a dump of a game has no more levels than there are.
    is_open = not (context.is_game and context.quantities.prefix) or context.analysis.levels("spi").sets
    is_valued = context.case.seed % 2 and is_open
    more = ["--values", "--levels", str(LEVELS), *program.settings("reward")] if is_valued else []
    report = program.about("export", "--out", folder, *more)
    verified(context, folder)
    if more and not context.analysis.play:
        bounded(context, folder)
    expected = regions_of(context)
    counts = {region["name"]: region["count"] for region in report["regions"]}
    for name, states in expected.items():
        context.same(f"region {name}", relation.count(states), counts.get(name, "0"))
    known = [name for name in counts if name in expected]
    for name in known[context.case.seed % len(known) :: 5]:
        states = [dict(name) for name in relation.of]
        asked = [word for state in states for word in ("--contains", at(state))]
        found = program.ask("query", folder, name, *asked, allowed=(0, 1))["contains"]
        for state, entry in zip(states, found):
            inside = relation.one(key(state)) in expected[name]
            context.same(f"{state} in {name}", inside, entry["contained"])
    members(context, folder, {name: states for name, states in expected.items() if name in counts})
    allowed_by(context, folder, counts)


def limited(context):
    """For some cases, a time limit may end the certificate, or parts of it: the regions of the dump are right, and
    `verify` accepts all but those that are named."""
    draw, program = random.Random(context.case.seed), context.program
    if draw.random() < 0.6:
        return
    whole = program.about("export", "--out", program.folder / "whole")
    seconds, folder = whole["time"]["total"], program.folder / f"limited_{program.model.stem}"
    limit = f"{max(1, round(1000 * seconds * draw.uniform(0.3, 1.2)))}ms"
    program.about("export", "--out", folder, "--timeout", limit, allowed=(0, 4))
    if not (folder / "manifest.json").exists():
        return  # the limit came before the regions
    manifest = json.loads((folder / "manifest.json").read_text())
    roots = {root["name"]: root["count"] for root in manifest["regions"]["roots"]}
    for name, states in regions_of(context).items():
        context.same(f"region {name} within {limit}", context.relation.count(states), roots.get(name, "0"))
    certificate = manifest.get("certificate")
    open_ = set(certificate.get("uncertified", ())) if certificate else set(roots)
    found = "whole" if not open_ else "in parts" if certificate else "missing"
    context.case.features.add(f"certificate {found}")
    options = program.settings("coalition")
    status, out, _ = program.run("verify", folder, program.model, program.prefs, *options, "--json")
    if certificate is None:
        context.same(f"status of verify without certificate within {limit}", 3, status)
        return
    context.same(f"status of verify within {limit}", 4 if open_ else 0, status)
    report = harness.json_object(out) or {}
    proved = {region["region"] for region in report["checked"] if region["inside"] and region["outside"]}
    context.same(f"violation within {limit}", None, report["violation"])
    context.same(f"regions that are neither proved nor named within {limit}", set(), roots.keys() - proved - open_)


def verified(context, folder):
    """`verify` accepts a dump for its coalition, and for no other."""
    program, number = context.program, len(context.case.players)
    verify = ("verify", folder, program.model, program.prefs, "--json")
    status, out, errors = program.run(*verify, *program.settings("coalition"))
    context.same("verify accepts", (0, ""), (status, "" if status == 0 else (out + errors)[-700:]))
    if context.is_game:
        other = "2" if context.ours != {1} else "1"
        status, out, _ = program.run(*verify, "--coalition", other)
        context.same("verify of another coalition", (number > 1, True), (status == 1, "the coalition is" in out))


def bounded(context, folder):
    """The bounds that `verify` confirms are narrow, and contain the values, against an opponent as well."""
    quantities, relation, variables = context.quantities, context.relation, context.source.variables
    if any(isinstance(value, str) for name in relation.of for _, value in name):
        return  # the table has the numbers of locations, and the reference their names
    numbers = {tuple(int(dict(name)[v.name]) for v in variables): relation.one(name) for name in relation.of}
    classes = {"+".join(context.named(c)) or "nothing": c for c in set(context.analysis.classes) - {None}}
    precision = math.inf if context.is_rare() else Fraction(1, 10**6)
    with open(folder / "values.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        state = numbers[tuple(int(row[v.name]) for v in variables)]
        node = (classes[row["arena"]], state) if quantities.prefix else state
        for k in (k for k in range(LEVELS) if f"p_{k + 1}_rank" in row):
            for letter, (table, _) in (("p", context.probabilities[k]), ("c", context.costs[k])):
                lower, upper = (row[f"{letter}_{k + 1}_{side}"] for side in ("lower", "upper"))
                value = table.get(node, Fraction(0) if letter == "p" else None)
                found = {"lower": bound(lower), "upper": bound(upper)} if lower else None
                if node not in (quantities.own(state), state) and letter == "c" and not found:
                    continue  # a level that no state of the class is in is not known elsewhere
                context.within(f"{letter}_{k + 1} of {row}", value, found, precision)
    context.case.features.add("values of a dump of a game" if context.is_game else "values of a dump")


def bound(text):
    """A bound of a table: a fraction, or the double nearest to a decimal."""
    return text if text == "inf" else Fraction(text if "/" in text else float(text))


def regions_of(context):
    analysis = context.analysis
    whole = analysis.whole
    found = {"reachable": set(whole.states), "initial": set(whole.initial), "deadlock": whole.deadlocks}
    if context.preferences.required:
        found["unsafe"] = set(analysis.mdp.unsafe)
    for at, name in enumerate(context.source.players):
        found[f"player:{name}"] = {s for s in whole.states if whole.owners[s] == at}
    if context.is_game and analysis.safety == "action":
        found["bad"] = analysis.bad
    for number, name in enumerate(context.names):
        found[f"almost-sure:{name}"], found[f"positive:{name}"] = analysis.sure[number], analysis.positive[number]
        if context.secured(number) is not None:
            found[f"target:{name}"] = analysis.targets[number]
    for known in set(analysis.classes) - {None}:
        states = {s for s, c in enumerate(analysis.classes) if c == known}
        found["class:" + ("+".join(context.named(known)) or "nothing")] = states
    for kind in ("sasi", "spi"):
        levels = analysis.levels(kind)
        found.update({f"{kind}:{k}": states for k, states in enumerate(levels.sets, 1)})
        found[f"{kind}:unbounded"] = levels.fixpoint
    return found


def members(context, folder, regions):
    """`query` counts and lists the states of regions and of expressions over them."""
    relation, program, draw = context.relation, context.program, random.Random(context.case.seed)
    first, second = draw.choices(sorted(regions), k=2)
    one, other, whole = regions[first], regions[second], regions["reachable"]
    bound = draw.randint(0, context.case.size)
    above = {s for s in whole if context.analysis.whole.plain(s)[0] >= bound}
    asked = {first: one, f"{first} & !{second}": one - other, f"!{first} | {second}": whole - one | other}
    for text, states in asked.items():
        for where, kept in (([], whole), (["--where", f"{context.source.variables[0].name} >= {bound}"], above)):
            expected = {name for name in relation.of if relation.one(name) in states & kept}
            found = program.ask("query", folder, text, *where, "--count", "--list", len(relation.of) + 1)
            listed, what = [key(entry["state"]) for entry in found["states"]], f"{text} {' '.join(where)}"
            context.same(f"count of {what}", str(len(expected)), found["count"])
            context.same(f"members of {what}", (len(expected), expected), (len(listed), set(listed)))
    some = program.ask("query", folder, first, "--list", 1)
    got = [relation.one(key(entry["state"])) in one for entry in some["states"]]
    context.same(f"one member of {first}", ([True] * min(1, len(one)), None), (got, some["count"]))


def allowed_by(context, folder, counts):
    """Choices of a dump: all of them, those that stay sure, and those of the levels."""
    analysis, relation = context.analysis, context.relation
    whole = {s: {c.name for c in analysis.whole.choices[s]} for s in analysis.whole.states}
    expected = {"choices": whole}
    for kind in ("sasi", "spi"):
        levels = analysis.levels(kind)
        for k, games in enumerate(levels.games, 1):
            name = f"strategy:{kind}:{'unbounded' if k > len(levels.sets) else k}"
            if name in counts:
                expected[name] = {
                    s: {c.name for c in games[levels.classes[s]].permitted(levels.node(s))}
                    for s in (levels.sets[k - 1] if k <= len(levels.sets) else levels.fixpoint)
                }
    for name, of in expected.items():
        found = context.program.ask("query", folder, name, "--count", "--list", len(relation.of) + 1)
        got = {key(entry["state"]): entry["choices"] for entry in found["states"]}
        wanted = {state: of[relation.one(state)] for state in relation.of if of.get(relation.one(state))}
        if context.same(f"states of {name}", wanted.keys(), got.keys()):
            for state, names in wanted.items():
                calls = [[name for name in names if is_called(dumped, name)] for dumped in got[state]]
                fits = len(names) == len(calls) and names == {one for called in calls for one in called}
                context.same(f"choices of {name} in {dict(state)}", "" if fits else names, "" if fits else got[state])
        context.same(f"count of {name}", str(sum(map(len, wanted.values()))), found["count"])


def is_called(dumped, name):
    """Whether a choice has a name of a dump, which lists the commands that have one number: `a(m#1|m#3,n#1)`. The
    choices of a `dtmc` are all called `uniform`."""
    if dumped == "uniform" or f"|{name}|" in f"|{dumped}|":
        return True
    (label, _, parts), (own, _, commands) = (text.rpartition("(") for text in (dumped, name))
    if not own:
        return f"|{name}|" in f"|{label}|"
    listed = zip(parts.rstrip(")").split(","), commands.rstrip(")").split(","))
    return own == label and all(command in part.split("|") for part, command in listed)


ALL = {"dump": dumps, "limited": limited}
