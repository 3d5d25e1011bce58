"""The models that strategies induce: their steps are those of the model, and they keep the promises."""

import csv
import re
from dataclasses import dataclass, replace
from fractions import Fraction

from reference.model import Choice, Mdp, almost_sure, attractor
from reference.product import Product, satisfaction
from tester.program import key, uncell
from tester.promises import claims, options_of, starts


@dataclass
class Induced:
    """The model of a strategy: `of[s]` is the state of the reference, `facts[s]` its variables and labels."""

    mdp: Mdp
    of: list
    facts: list


def induced(context):
    """A strategy's model has steps of the model only, and keeps its promise."""
    kind, objective, variant = options_of(context)
    if not starts(context):
        return
    folder = context.program.folder / "induced"
    options = ["--format", "explicit", "--kind", kind, "--scheduler", variant, "--out", folder]
    options += ["--objective", objective] if objective else []
    context.program.about("export", *options)
    found = read_induced(context, folder / f"{kind}-{variant}")
    if found is None:
        return
    labels_of_the_model(context, kind, found)
    if not (context.is_game and variant == "permissive"):  # the only ones that are games again
        in_other_formats(context, f"{kind}-{variant}", options)
    kept(context, kind, objective, found)


def kept(context, kind, objective, found):
    """A strategy keeps its promise in its model."""
    if context.is_game and context.analysis.play:
        # Here the opponent's actions are drawn at random; the reference judges formulas of games in the worst case.
        return
    if kind in ("sasi", "spi"):
        improvements(context, kind, found)
    elif kind == "achieve":
        number = context.names.index(objective)
        wanted = [s for s in found.mdp.initial if found.of[s] in context.analysis.sure[number]]
        satisfied(context, found, wanted, [number])
    elif context.analysis.safety != "transition":
        ranked = context.analysis.levels("sasi")
        wanted = [
            s for s in found.mdp.initial if ranked.rank(found.of[s]) != 0 or context.analysis.classes[found.of[s]]
        ]
        satisfied(context, found, wanted, range(len(context.names)))


def followed(context):
    """The table of a whole strategy that achieves something, followed as its documentation says: its steps are those of
    the model, and it keeps its promise."""
    kind, objective, variant = options_of(context)
    if kind not in ("plan", "achieve"):
        return
    file = context.program.folder / "followed.csv"
    options = ["--objective", objective] if objective else []
    report = context.program.about("strategy", "--kind", kind, *options, "--all", "--csv", file)
    starts = {key(entry["state"]) for entry in context.report["initial"]}
    nodes = [{**entry["state"], "labels": set(), "pursued": ""} for entry in report["states"]]
    choices = [{} for _ in nodes]
    for entry, facts in zip(report["states"], nodes):
        facts["labels"] |= {"init"} if entry["start"] and key(entry["state"]) in starts else set()
    for row in csv.DictReader(open(file, encoding="utf-8", newline="")):
        node, facts = int(row["node"]), nodes[int(row["node"])]
        facts["pursued"] = str(context.names.index(row["pursues"])) if row["pursues"] in context.names else ""
        taken = row["permitted"] if variant == "permissive" else row["pick"]
        if row["then"] and taken != "false":  # the opponent's actions are neither
            choices[node][uncell(row["action"])] = {int(step.split(":")[1]) for step in row["then"].split()}
    for node, own in enumerate(choices):
        if not own:
            own["settled"] = {node}
            nodes[node]["labels"].add("settled")
    found = walked(context, nodes, choices, lambda variable, facts: facts[variable["name"]])
    if found is not None:
        kept(context, kind, objective, found)


def labels_of_the_model(context, kind, found):
    """A strategy's model keeps the labels of the model; one with a name of its own has `_2` after it."""
    own = {"improved", "settled", *(("achieved", "committed") if kind in ("plan", "achieve") else ())}
    for name, condition in context.case.labels:
        holds, written = context.analysis.whole.where(condition), f"{name}_2" if name in own else name
        expected = {s for s in found.mdp.states if found.of[s] in holds}
        got = {s for s in found.mdp.states if written in found.facts[s]["labels"]}
        context.same(f"states with the label {written} of {kind}", expected, got)


def in_other_formats(context, stem, options):
    """The program reads a strategy's model back from each format, and finds the same regions and values."""
    program, folder = context.program, context.program.folder / "induced"
    first, *others = open(folder / f"{stem}.lab", encoding="utf-8").read().splitlines()
    names = label_names(first)
    held = {names[number] for line in others for number in line.partition(":")[2].split()} - {"init", "deadlock"}
    properties = [f'{p} [ F "{name}" ]' for name in sorted(held)[:6] for p in ("P>=1", "Pmax=?", "Pmin=?")]
    asked = [word for text in properties for word in ("--property", text)]
    expected = program.ask("reach", folder / f"{stem}.tra", *asked, allowed=(0, 1))["properties"] if asked else []
    for written in ("drn", "umb") if asked else ():
        again = program.folder / f"induced-{written}"
        where = options.index("--out") + 1
        more = [*options[:where], again, *options[where + 1 :]]
        more[more.index("--format") + 1] = written
        program.about("export", *more)
        tables = [open(f / f"{stem}.csv", encoding="utf-8").read() for f in (folder, again)]
        context.same(f"table of actions of {written}", *tables)
        got = program.ask("reach", again / f"{stem}.{written}", *asked, allowed=(0, 1))["properties"]
        for text, old, new in zip(properties, expected, got):
            regions = [
                {k: v for k, v in entry.items() if k.startswith("p") and k != "property"} for entry in (old, new)
            ]
            context.same(f"regions of {text} of {written}", *regions)
            if old.get("value") and not context.is_rare():
                near = all(abs(old["value"][b] - new["value"][b]) <= 1e-5 for b in ("lower", "upper"))
                context.same(
                    f"value of {text} of {written}", "" if near else old["value"], "" if near else new["value"]
                )


def label_names(line):
    """The names of labels by their numbers, as the first line of a label file declares them."""
    return {number: name.replace('""', '"') for number, name in re.findall(r'(\d+)="((?:[^"]|"")*)"', line)}


def read_induced(context, stem):
    """Reads `.tra`, `.lab` and the table of actions, and walks through them together with the reference."""
    rows = list(csv.DictReader(open(f"{stem}.csv", encoding="utf-8")))
    lines = open(f"{stem}.lab", encoding="utf-8").read().splitlines()
    names = label_names(lines[0])
    for line in lines[1:]:
        number, _, own = line.partition(":")
        rows[int(number)]["labels"] = {names[n] for n in own.split()}
    lines, choices = open(f"{stem}.tra", encoding="utf-8").read().splitlines(), [{} for _ in rows]
    is_chain = len(lines[0].split()) == 2
    for state, *rest in (line.split() for line in lines[1:]):
        choice, to = (0, rest[0]) if is_chain else (int(rest[0]), rest[1])
        row = int(state.partition(":")[0])  # in games, the player follows
        name = uncell(rows[row]["actions"]).split(" | ")[choice]
        choices[row].setdefault(name, set()).add(int(to))
    return walked(context, rows, choices, lambda variable, row: value_of(variable, row[variable["name"]]))


def walked(context, rows, choices, value_in):
    """The pairs of a state of the strategy's model and a state of the reference that the same paths reach; None if a
    step is not one of the model. `value_in` gives the value of a variable in a row."""
    whole, variables = context.analysis.whole, context.report["model"]["variables"]
    number, pairs, moves = {}, [], []

    def plain(row):
        return tuple((v["name"], value_in(v, rows[row])) for v in variables[: context.relation.width])

    def named(state):
        return key(context.source.named(whole.plain(state)))

    def numbered(pair):
        if pair not in number:
            number[pair] = len(pairs)
            pairs.append(pair)
        return number[pair]

    roots = [row for row, facts in enumerate(rows) if "init" in facts.get("labels", ())]
    fresh = {named(s): s for s in whole.initial}
    initial = [numbered((row, fresh[plain(row)])) for row in roots]
    for row, state in pairs:  # grows while we walk it
        known, to = {choice.name: choice for choice in whole.choices[state]}, set()
        for name, successors in choices[row].items():
            if name == "settled":
                to.add(number[row, state])
                continue
            expected = {named(t): t for t in known[name].to} if name in known else {}
            where = f"successors of {rows[row]} by {name}"
            if not context.same(where, expected.keys(), {plain(t) for t in successors}):
                return None
            to |= {numbered((t, expected[plain(t)])) for t in successors}
        # Each permitted choice is taken again and again, at random.
        moves.append([Choice("any", dict.fromkeys(sorted(to), Fraction(1)), {})])
    mdp = Mdp(context.source, [None] * len(pairs), moves, initial, set())
    return Induced(mdp, [state for _, state in pairs], [{"labels": set(), **rows[row]} for row, _ in pairs])


def value_of(variable, text):
    if variable["type"] == "bool":
        return text == "true"
    number = int(text)
    return variable["values"][number - variable["low"]] if "values" in variable else number


def improvements(context, kind, found):
    """SASI makes its improvements almost surely, SPI with positive probability; no step weakens."""
    analysis, levels = context.analysis, context.analysis.levels(kind)
    safe = {s for s in found.mdp.states if found.of[s] not in analysis.mdp.unsafe}
    for start in safe.intersection(found.mdp.initial):
        context.same("unsafe states", set(), reached_from(found.mdp, start) - safe)
    if analysis.safety == "transition":
        return
    if analysis.safety == "action":
        for state in found.mdp.states:
            for to in found.mdp.choices[state][0].to:
                old, new = analysis.classes[found.of[state]], analysis.classes[found.of[to]]
                context.same("a step weakens", False, to != state and analysis.preferences.weakens(old, new))
    moves = found.mdp.moves
    for start in safe.intersection(found.mdp.initial):
        rank = levels.rank(found.of[start])
        goal = set(found.mdp.states)
        for _ in range(4 if rank == "unbounded" else min(rank, 4)):
            improving = {s for s in goal if "improved" in found.facts[s]["labels"]}
            before = almost_sure(moves, improving) if kind == "sasi" else attractor(moves, improving)
            goal = {s for s in found.mdp.states if any(m <= before if kind == "sasi" else m & before for m in moves[s])}
        context.same(f"{rank} improvements from {found.facts[start]}", True, start in goal)


def reached_from(mdp, start):
    found, todo = {start}, [start]
    while todo:
        new = {t for choice in mdp.choices[todo.pop()] for t in choice.to} - found
        found |= new
        todo += new
    return found


def satisfied(context, found, wanted, objectives):
    """From some states, almost every path satisfies one of some objectives, the one that it pursues."""
    analysis, won = context.analysis, set()
    for number in objectives:
        here = {s for s in found.mdp.states if found.facts[s]["pursued"] == str(number)}
        ended = {s for s in here if "settled" in found.facts[s]["labels"]}
        good = {s for s in ended if claims(analysis, number, found.of[s])}
        context.same("an objective is achieved where a path ends", set(), ended - good)
        if analysis.play:
            # Within the states that pursue the objective, the monitors' marks decide.
            going = [
                own if s in here - ended and own[0].successors <= here - ended else []
                for s, own in enumerate(found.mdp.choices)
            ]
            marks, accepted = (
                {g: {s for s in found.mdp.states if found.of[s] in m} for g, m in of.items()}
                for of in (analysis.product.marks, analysis.product.accepted)
            )
            inside = Product(replace(found.mdp, choices=going), analysis.product.monitors, marks, accepted)
            good |= satisfaction(inside, inside.mdp, analysis.formulas[number])["pmax_one"] - ended
        won |= good
    sure = almost_sure(found.mdp.moves, won)
    for state in wanted:
        context.same(f"achieves from {at_text(found, state)}", True, state in sure)


def at_text(found, state):
    return ", ".join(f"{k}={v}" for k, v in found.facts[state].items() if k not in ("labels", "state"))


ALL = {"induced": induced, "followed": followed}
