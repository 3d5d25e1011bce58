"""Tables and graphs of strategies: lines of comma-separated values, and the paths under a permissive strategy."""

import csv
import io
import re

from reference.shields import Shield as Machine
from tester.program import at, cell, in_state, shown
from tester.promises import starts

TEXT = r'"((?:[^"\\]|\\.)*)"'
NODE = re.compile(rf"  s(\d+) \[label={TEXT}([^\]]*)\];")
CHOICE = re.compile(rf"  s(\d+) -> (a\d+_\d+) \[label={TEXT}, ([^\]]*)\];")
STEP = re.compile(r"  (a\d+_\d+) -> s(\d+) \[")


def tables(context):
    """For some cases, `strategy --csv` says of each state and action what the report says."""
    if not context.is_game and context.case.seed % 3 != 1:
        return
    kind = ("sasi", "spi")[context.case.seed % 2]
    known = context.strategy("--kind", kind)
    asked = [word for name in known for word in ("--at", at(dict(name)))]
    rows = csv.reader(io.StringIO(printed(context, "--kind", kind, *asked, "--csv", "-")))
    head, *lines = rows
    got = [dict(zip(head, line)) for line in lines]
    expected = [row for entry in known.values() for row in rows_of(context, entry)]
    context.same("lines of the table", len(expected), len(got))
    for wanted, row in zip(expected, got):
        context.same(f"line of {row}", wanted, {name: row.get(name) for name in wanted})
    if not context.analysis.play and len(starts(context)) == len(context.report["initial"]):
        graph(context, kind)


def printed(context, *options):
    """What `strategy` prints about the model with its preferences."""
    program, names = context.program, ["scope", "safety", "threads", "coalition", "engine"]
    status, out, errors = program.run("strategy", program.model, program.prefs, *program.settings(*names), *options)
    context.same(f"status of strategy {options[2:]}", (0, ""), (status, errors if status else ""))
    return out


def rows_of(context, entry):
    """The lines of one state."""
    theirs = entry.get("owner") == "opponent"
    for action in entry["actions"]:
        marks = {what: "" if theirs else shown(action[what]) for what in ("kept", "permitted", "progress")}
        pick = "" if theirs else shown(action["name"] == entry["chosen_action"])
        state = {name: cell(value) for name, value in entry["state"].items()}
        row = {**state, **marks, "pick": pick}
        row.update(action=cell(action["name"]), reason=action["reason"])
        row.update(most_preferred="+".join(entry["most_preferred"]))
        row.update(sasi_rank=shown(entry["sasi_rank"]), spi_rank=shown(entry["spi_rank"]))
        if context.is_game:
            player = entry.get("player")
            row.update(player=player or "", owner="opponent" if theirs else "ours" if player else "")
        yield row


def graph(context, kind):
    """The graph has the steps that the permissive strategy and the opponent may take until nothing is ahead."""
    text = printed(context, "--kind", kind, "--dot")
    nodes = {n: (re.sub(r"^\w+: ", "", first_line(words)), style) for n, words, style in NODE.findall(text)}
    steps = {}
    for action, to in STEP.findall(text):
        steps.setdefault(action, set()).add(nodes[to][0])
    choices = [(nodes[s][0], first_line(words), a, "dashed" in style) for s, a, words, style in CHOICE.findall(text)]
    got = {(state, name, frozenset(steps[a]), dashed) for state, name, a, dashed in choices}
    context.same(f"graph of {kind}", paths(context, kind), got)
    theirs = {text_of(context, s) for s in context.analysis.whole.theirs}
    for state, style in nodes.values():
        context.same(f"shape of {state}", state in theirs, "hexagon" in style)


def first_line(label):
    """The first line of a label of DOT."""
    return re.sub(r"\\(.)", lambda c: "\n" if c[1] == "n" else c[1], label).split("\n")[0]


def text_of(context, state):
    named = context.source.named(context.analysis.whole.plain(state))
    return ", ".join(f"{name}={in_state(value)}" for name, value in named.items())


def paths(context, kind):
    """The choices on the way: the state, their name, their successors, and whether the opponent takes them."""
    machine, whole, found = Machine(context.analysis, kind), context.analysis.whole, set()
    todo = [(state, machine.start(state)) for state in starts(context).values()]
    for state, memory in todo:  # grows while we walk it
        theirs = state in whole.theirs
        permitted, _ = machine.permitted(state, memory)
        permitted = {c.name for c in whole.choices[state]} if theirs else permitted
        for choice in whole.choices[state] if memory.level != 0 else ():
            if choice.name in permitted:
                successors = frozenset(text_of(context, to) for to in choice.to)
                found.add((text_of(context, state), choice.name, successors, theirs))
                after = [(to, machine.after(state, memory, to)) for to in choice.to]
                todo += [node for node in after if node not in todo]
    return found


ALL = {"tables": tables}
