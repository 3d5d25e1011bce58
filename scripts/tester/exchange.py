"""Models that are written state by state: their labels, and the answers when they are read back."""

import math
from dataclasses import replace

from reference.model import reachability
from reference.questions import chances
from tester.context import LEVELS
from tester.program import key
from tester.dumps import regions_of
from tester.regions import is_near, value_of


def exchanged(context):
    """A model that is written and read back gives the same answers; its labels are the regions.

    With monitors or requirements, the labels stand for them: a target is where an objective is secured, and a model
    whose paths stay outside of `unsafe` is the restricted one.
    """
    program, case = context.program, context.case
    written = ("explicit", "umb")[case.seed % 2] if context.is_game else ("explicit", "umb", "drn")[case.seed % 3]
    folder, suffix = program.folder / "model", {"explicit": "tra"}.get(written, written)
    report, path = program.about("export", "--format", written, "--out", folder), folder / f"model.{suffix}"
    labels = labels_of(context)
    counts = {label["name"]: label["states"] for label in report["labels"]}
    open_targets = {f"target_{name}" for i, name in enumerate(context.names) if context.secured(i) is None}
    for name in (labels.keys() | counts.keys()) - open_targets:
        expected = context.relation.count(labels.get(name, ()))
        context.same(f"states with the label {name} of {written}", expected, counts.get(name, "0"))
    for what in ("states", "choices", "transitions"):
        context.same(f"{what} of {written}", context.report["counts"][what], report[what])
    prefs = program.folder / "back.pref"
    by_name = written == "drn" or context.analysis.play or case.required
    prefs.write_text(by_labels(context, counts) if by_name else case.preferences_text())
    same_analysis(context, written, path, prefs)
    certified_again(context, written, path, prefs)
    if context.is_game:
        enforced_again(context, written, path, labels)
        return
    numbers_again(context, written, path, prefs)
    reached_again(context, written, path, labels)


def labels_of(context):
    """The labels of an export, each with its states."""
    analysis = context.analysis
    # Files say in a way of their own who chooses in a state.
    regions = regions_of(context).items()
    found = {n: s for n, s in regions if n not in ("reachable", "initial") and not n.startswith("player:")}
    for kind in ("sasi", "spi"):
        for state in set(analysis.whole.states) - analysis.mdp.unsafe:
            rank = analysis.levels(kind).rank(state)
            found.setdefault(f"{kind}_rank_{rank}", set()).add(state)
    found = {name.translate(str.maketrans("-:+", "___")): states for name, states in found.items()}
    return found | {name: analysis.whole.where(condition) for name, condition in context.case.labels}


def by_labels(context, counts):
    """The preferences in labels. A file without declarations has no label that no state has."""
    case = context.case
    held = {name for name, states in counts.items() if states != "0"}
    named = [(name, f'F "target_{name}"' if f"target_{name}" in held else "F false") for name in context.names]
    required = ['G !"unsafe"'] if "unsafe" in held else []
    return replace(case, objectives=named, required=required, history="state").preferences_text()


def same_analysis(context, written, path, prefs):
    """Sizes, classes, levels, and what is said of initial states. Valuations that are no states of the file are
    deadlocks without labels, in the scope `all`."""
    report = context.report
    back = context.program.ask("check", path, prefs, *context.program.settings("scope", "safety", "coalition"))
    more = int(back["counts"]["states"]) - int(report["counts"]["states"])
    for what in ("states", "choices", "transitions"):
        context.same(f"{what} read from {written}", int(report["counts"][what]) + more, int(back["counts"][what]))
    for what in ("sasi", "spi"):
        context.same(f"{what} of {written}", report[what], back[what])
    sides = [{",".join(e["most_preferred"]): int(e["states"]) for e in r["classes"]} for r in (report, back)]
    if more:
        sides[0][""] = sides[0].get("", 0) + more
    context.same(f"classes of {written}", *sides)
    if report["improvement"] and not more:
        context.same(f"improvement of {written}", report["improvement"], back["improvement"])
    named = context.case.kind != "dtmc"  # the choices of a chain have no names in these formats
    for what in ("most_preferred", "sasi_rank", "spi_rank", *(("sasi_actions", "spi_actions") if named else ())):
        sides = [sorted(said(e[what]) for e in r["initial"] if "unsafe" not in e) for r in (report, back)]
        context.same(f"{what} of {written}", *sides)


def certified_again(context, written, path, prefs):
    """`verify` accepts the dump of a file that was read. Players of a game own its states there, not its actions."""
    program, folder = context.program, context.program.folder / "again"
    program.ask("export", path, prefs, *program.settings("scope", "safety", "coalition"), "--out", folder)
    status, out, errors = program.run("verify", folder, path, prefs, *program.settings("coalition"), "--json")
    context.same(f"verify of a dump of {written}", (0, ""), (status, "" if status == 0 else (out + errors)[-700:]))


def said(value):
    """A list without its order, which is that of commands or of names; anything else as text."""
    return str(sorted(value) if isinstance(value, list) else value)


def numbers_again(context, written, path, prefs):
    """`values` of a file are those of the model, in all initial states together. PRISM's files have no rewards."""
    if context.is_rare():
        return
    program = context.program
    names = [key(entry["state"]) for entry in context.report["initial"]]
    before = [entry for entry in context.values["states"] if key(entry["state"]) in names]
    options = program.settings("scope", "safety", *([] if written == "explicit" else ["reward"]))
    after = program.ask("values", path, prefs, *options, "--levels", LEVELS)["states"]
    before, after = ([entry for entry in side if "unsafe" not in entry] for side in (before, after))
    same_numbers(context, f"N of {written}", *([e["number"] for e in side] for side in (before, after)))
    costs = written != "explicit" or context.case.settings["reward"] == "steps"
    for k in range(LEVELS):
        for name in ("probability", "cost") if costs else ("probability",):
            sides = ([e["levels"][k][name] for e in side if k < len(e["levels"])] for side in (before, after))
            same_numbers(context, f"{name} of {k + 1} improvements of {written}", *sides)


def same_numbers(context, what, before, after):
    """Bounds of equal numbers are near each other; the order of states does not count."""

    def sorted_bounds(side):
        return sorted(-1 if b is None else math.inf if b["lower"] == "inf" else b["lower"] for b in side)

    before, after = sorted_bounds(before), sorted_bounds(after)
    close = [math.isclose(a, b, rel_tol=1e-5, abs_tol=1e-5) for a, b in zip(before, after)]
    near = len(before) == len(after) and all(close)
    context.same(what, "" if near else before, "" if near else after)


def enforced_again(context, written, path, labels):
    """`reach` of labels of a game: what its coalition enforces, and what the opponent does."""
    whole = context.analysis.whole
    held = sorted(name for name, states in labels.items() if states and name != "deadlock" and "_rank_0" not in name)
    coalition = ",".join(name for at, name in enumerate(context.case.players) if at in context.ours)
    for name in held[context.case.seed % 5 :: max(1, len(held) // 3)]:
        options = ["--coalition", coalition, *context.program.settings("scope")]
        report = context.program.ask("reach", path, "--target", f'"{name}"', *options)
        for region, states in reachability(whole, labels[name]).items():
            context.same(f"{region} of {name} of {written}", context.relation.count(states), report[region])


def reached_again(context, written, path, labels):
    """`reach` of labels: regions and probabilities, with and without the requirement to avoid unsafe states."""
    analysis, program = context.analysis, context.program
    held = sorted(name for name, states in labels.items() if states and name != "deadlock" and "_rank_0" not in name)
    some = held[context.case.seed % 5 :: max(1, len(held) // 3)]
    asked = [f'{p} [ F "{name}" ]' for name in some for p in ("P>=1", "Pmax=?", "Pmin=?")]
    ways = [([], analysis.whole)] + ([(["--require", 'G !"unsafe"'], analysis.mdp)] if labels.get("unsafe") else [])
    for options, mdp in ways if asked else ():
        words = [word for text in asked for word in ("--property", text)]
        report = program.ask("reach", path, *words, *options, *program.settings("scope"), allowed=(0, 1))
        for name, number in zip(some, range(0, len(asked), 3)):
            entries, target = report["properties"][number : number + 3], labels[name]
            where = f"{name} of {written} with {options}"
            # Where a state is not a valuation of the file, every strategy avoids the label.
            for region, states in reachability(mdp, target).items():
                context.same(f"{region} of {where}", context.relation.count(states), entries[0][region])
            for values, entry in zip(chances(mdp, target), entries[1:]):
                if mdp.unsafe.isdisjoint(mdp.initial):
                    chance_of(context, written, f"{entry['property']} of {where}", values, entry["value"])


def chance_of(context, written, what, values, bounds):
    """A probability over the initial states. Those of archives are exact, the other formats have doubles."""
    values = [values[state] for state in context.analysis.whole.initial]
    if written == "umb":
        value_of(context, what, values, bounds)
    elif not context.is_rare():
        near = is_near(min(values), bounds["lower"]) and is_near(max(values), bounds["upper"])
        context.same(what, "" if near else (min(values), max(values)), "" if near else bounds)


ALL = {"exchange": exchanged}
