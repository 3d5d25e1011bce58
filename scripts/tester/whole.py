"""Whole strategies, runs, cycles of improvements and regions of questions, followed step by step by the reference."""

import csv
import io

from reference.improvement import UNBOUNDED
from reference.shields import Shield as Machine
from tester.program import cell, key


def whole(context):
    """The table of a whole strategy: each node permits what the reference permits with the memory of the node, and each
    step leads to a node with the memory that follows."""
    if context.case.seed % 2:
        return
    kind = ("sasi", "spi")[context.case.seed // 2 % 2]
    program = context.program
    file = program.folder / "whole.csv"
    report = program.about("strategy", "--kind", kind, "--all", "--csv", file)
    nodes = report["states"]
    context.same("numbers of nodes", list(range(len(nodes))), [entry["node"] for entry in nodes])
    names = sorted(key(entry["state"]) for entry in nodes if entry["start"])
    context.same("starts", sorted(context.relation.of), names)
    machine = Machine(context.analysis, kind)
    todo = [
        (entry["node"], state, machine.start(state))
        for entry in nodes
        if entry["start"]
        for state in context.relation.of.get(key(entry["state"]), ())
    ]
    known = set(todo)
    while todo:
        here = todo.pop()
        for follower in steps_of(context, machine, nodes, *here):
            if follower not in known:
                known.add(follower)
                todo.append(follower)
    context.same("nodes that no path has", [], sorted(set(range(len(nodes))) - {node for node, _, _ in known}))
    rows_of(context, nodes, list(csv.DictReader(io.StringIO(file.read_text()))))


def steps_of(context, machine, nodes, node, state, memory):
    """Compares a node with a state and memory of the reference. Returns the triples that follow."""
    entry, analysis = nodes[node], context.analysis
    where = f"node {node}, {entry['state']}"
    plain = key(context.source.named(analysis.whole.plain(state)))
    context.same(f"state of {where}", plain, key(entry["state"])[: context.relation.width])
    context.same(f"level of {where}", memory.level, entry["level"])
    if analysis.classes[state] is not None and memory.level != 0:
        reference = context.named(machine.reference(state, memory))
        context.same(f"reference of {where}", reference, entry["reference"])
    theirs = state in analysis.whole.theirs
    permitted = set() if memory.level == 0 else permitted_by(machine, state, memory)
    taken = {c.name for c in analysis.whole.choices[state]} if theirs and memory.level != 0 else permitted
    choices, found = {c.name: c for c in analysis.whole.choices[state]}, []
    for action in entry["actions"]:
        if not theirs:
            context.same(f"{action['name']} permitted in {where}", action["name"] in permitted, action["permitted"])
        followed = [s for s in action["successors"] if "node" in s]
        expected = len(action["successors"]) if action["name"] in taken else 0
        if not context.same(f"nodes after {action['name']} of {where}", expected, len(followed)):
            continue
        plain = {key(context.source.named(analysis.whole.plain(t))): t for t in choices[action["name"]].to}
        for successor in followed:
            to = plain[key(successor["state"])[: context.relation.width]]
            found.append((successor["node"], to, machine.after(state, memory, to)))
    return found


def permitted_by(machine, state, memory):
    permitted, _ = machine.permitted(state, memory)
    return permitted


def rows_of(context, nodes, rows):
    """The lines of the table are those of the report."""
    expected = [
        (
            str(entry["node"]),
            str(entry["start"]).lower(),
            str(entry["level"]),
            "+".join(entry["reference"]),
            cell(action["name"]),
            [s["node"] for s in action["successors"] if "node" in s],
        )
        for entry in nodes
        for action in entry["actions"]
    ]
    got = [
        (*(row[name] for name in ("node", "start", "level", "reference", "action")), followers(row["then"]))
        for row in rows
    ]
    context.same("lines of the whole strategy", len(expected), len(got))
    for wanted, row in zip(expected, got):
        context.same(f"line of node {wanted[0]}", wanted, row)


def followers(cell):
    return [int(step.split(":")[1]) for step in cell.split()]


def runs(context):
    """The table of runs: each is a path of the model with the events of the reference, and together they are those of
    the report."""
    if context.case.seed % 2 == 0:
        return
    kind = ("sasi", "spi")[context.case.seed // 2 % 2]
    file = context.program.folder / "runs.csv"
    options = ["--kind", kind, "--runs", 10, "--steps", 200, "--seed", context.case.seed, "--csv", file]
    report = context.program.about("simulate", *options)
    paths = {}
    for row in csv.DictReader(io.StringIO(file.read_text())):
        paths.setdefault(int(row["start"]), {}).setdefault(int(row["run"]), []).append(row)
    context.same("starts of runs", list(range(1, len(report["plays"]) + 1)), sorted(paths))
    for number, play in enumerate(report["plays"], 1):
        own = paths.get(number, {})
        context.same("runs from a start", list(range(1, 11)), sorted(own))
        made = {}
        for path in own.values():
            times = run_of(context, kind, play, path)
            made[times] = made.get(times, 0) + 1
        told = {entry["times"]: entry["plays"] for entry in play["improvements"]}
        context.same(f"improvements of runs from {play['state']}", told, made)


def run_of(context, kind, play, path):
    """Follows a run. Returns the number of its improvements."""
    relation, analysis, machine = context.relation, context.analysis, Machine(context.analysis, kind)
    names = list(play["state"])
    name = key(play["state"])
    state = relation.one(name)
    memory, times = machine.start(state), 0
    first = [*map(cell, play["state"].values()), ""]
    context.same("step 0 of a run", first, [path[0][name] for name in (*names, "action")])
    for number, row in enumerate(path[1:], 1):
        choices = {cell(c.name): c for c in analysis.whole.choices[state]}
        where = f"step {number} from {play['state']} by {row['action']}"
        if not context.same(f"choice of {where}", True, row["step"] == str(number) and row["action"] in choices):
            return times
        plain = {}
        for to in choices[row["action"]].to:
            values = context.source.named(analysis.whole.plain(to))
            plain[tuple(map(cell, values.values()))] = to
        to = plain.get(tuple(row[n] for n in names[: relation.width]))
        if not context.same(f"successor of {where}", True, to is not None):
            return times
        events = [event for event in row["event"].split("; ") if event]
        old, new = analysis.classes[state], analysis.classes[to]
        expected = ["improvement"] if machine.counts(state, memory, to) else []
        weakened = [analysis.preferences.weakens(c, new) for c in (old, analysis.classes[relation.one(name)])]
        expected += [event for event, is_one in zip(("weakening", "weakens the start"), weakened) if is_one]
        context.same(f"events of {where}", expected, events)
        context.same(f"most_preferred after {where}", "+".join(context.named(new)), row["most_preferred"])
        times += "improvement" in events
        state, memory = to, machine.after(state, memory, to)
    return times


def cycles(context):
    """An unbounded rank has a cycle of permitted steps that improve, and no other rank has one."""
    for kind in ("sasi", "spi"):
        machine = Machine(context.analysis, kind)
        for name, entry in context.strategy("--kind", kind).items():
            state = context.relation.one(name)
            expected = context.analysis.classes[state] is not None and machine.start(state).level == UNBOUNDED
            if context.same(f"{kind} cycle of {dict(name)}", expected, "cycle" in entry) and expected:
                cycle_of(context, machine, kind, state, entry["cycle"])


def cycle_of(context, machine, kind, state, cycle):
    relation, whole = context.relation, context.analysis.whole
    memory, seen, improved = machine.start(state), [], []
    for number, step in enumerate(cycle["steps"]):
        where = f"step {number} of the {kind} cycle from {step['state']}"
        seen.append((state, memory))
        theirs = state in whole.theirs
        context.same(f"owner of {where}", "opponent" if theirs else None, step.get("owner"))
        context.same(f"permitted is {where}", True, theirs or step["action"] in permitted_by(machine, state, memory))
        choices = {c.name: c for c in whole.choices[state]}
        plain = {key(context.source.named(whole.plain(t))): t for t in choices[step["action"]].to}
        to = plain.get(key(step["to"])[: relation.width])
        if not context.same(f"successor of {where}", True, to is not None):
            return
        improved.append(machine.counts(state, memory, to))
        context.same(f"improvement of {where}", improved[-1], step["improves"])
        state, memory = to, machine.after(state, memory, to)
    again = cycle["repeats_from"]
    names = [key(context.source.named(whole.plain(s))) for s in (state, seen[again][0])]
    context.same(f"{kind} cycle comes back", (names[1], seen[again][1]), (names[0], memory))
    context.same(f"{kind} cycle improves", True, any(improved[again:]))


ALL = {"whole": whole, "runs": runs, "cycles": cycles}
