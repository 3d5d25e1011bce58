"""Sweeps: each instance says what the reference says, and what the command says of it alone."""

import csv
import itertools
import random
import re
from fractions import Fraction

from reference.games import LeftOut
from reference.prism import InputError, program_of
from reference.questions import Question
from reference.reports import players
from tester.program import shown

HALVES = re.compile(r"1/2 : (\S+) \+ 1/2 : ")
# What two runs of the same question need not have in common.
OF_THE_RUN = ("time", "memory")


def sweeps(context):
    """A sweep over some constants: the initial values, and a probability that may be 0 or 1."""
    if not is_swept(context.case):
        return
    draw, program = random.Random(context.case.seed), context.program
    text, ranges = parametrised(context.case, draw)
    model, table = program.folder / "sweep.prism", program.folder / "sweep.csv"
    model.write_text(text)
    asked = ",".join(f"{name}={written}" for name, (written, _) in ranges.items())
    options = program.settings("scope", "safety", "threads", "coalition", "engine")
    command = ("check", model, program.prefs, *options)
    more = [[], ["--jobs", 2], ["--csv", table]][draw.randrange(3)]
    runs = program.ask(*command, "-c", asked, *more, allowed=(0, 1))["runs"]
    instances = [dict(zip(ranges, values)) for values in itertools.product(*(values for _, values in ranges.values()))]
    context.same("instances of the sweep", instances, [run["constants"] for run in runs])
    for constants, run in zip(instances, runs):
        given = {name: shown(value) for name, value in constants.items()}
        where = f"check with {given}"
        try:
            source = program_of(text, given)
            analysis = context.analysis_of(source)
        except InputError:  # elsewhere two players may move
            context.same(f"status of {where}", "error", run["status"])
            continue
        except LeftOut:
            continue
        if context.same(f"status of {where}", "done", run["status"]):
            instance(context, where, analysis, run["result"])
    one = draw.randrange(len(runs))
    alone(context, command, instances[one], runs[one])
    if table.exists():
        tabulated(context, runs, table)
    asked_again(context, text, model, asked, instances)


def is_swept(case):
    return not case.starts and case.seed % 4 == 0


def parametrised(case, draw=None):
    """The model with a constant K, the initial value of x, and perhaps others: q, the initial value of y, and p, a
    probability. Returns the text, and for each constant the text of its values and the values."""
    text, ranges = case.model_text("K"), {"K": values_of(case.size, draw)}
    if draw and case.flag and draw.random() < 0.6:
        text = text.replace("y : bool init false", "y : bool init q")
        ranges["q"] = draw.choice([("{true,false}", [True, False]), ("false", [False])])
    if draw and HALVES.search(text) and draw.random() < 0.6:
        text = HALVES.sub(r"p : \1 + 1-p : ", text, count=1)
        ranges["p"] = draw.choice([("0:0.5:1", [0.0, 0.5, 1.0]), ("{0.25,1}", [0.25, 1.0]), ("0.5", [0.5])])
    kind, *lines = text.splitlines()
    types = {"K": "int", "q": "bool", "p": "double"}
    return "\n".join([kind, *(f"const {types[name]} {name};" for name in ranges), *lines, ""]), ranges


def values_of(size, draw):
    """Some values of x, as a range with or without a step, or as a list."""
    if draw is None or draw.random() < 0.4:
        return f"0:{size}", list(range(size + 1))
    if draw.random() < 0.5:
        return f"0:2:{size}", list(range(0, size + 1, 2))
    values = draw.sample(range(size + 1), min(size + 1, draw.choice([2, 3])))
    return f"{{{','.join(map(str, values))}}}", values


def instance(context, where, analysis, result):
    """One instance of a sweep."""
    whole, first = analysis.whole, analysis.whole.initial[0]
    for kind in ("sasi", "spi"):
        levels = analysis.levels(kind)
        if first not in analysis.mdp.unsafe:
            context.same(f"{kind}_rank of {where}", levels.rank(first), result["initial"][0][f"{kind}_rank"])
        if not analysis.play:  # monitors may have more states
            context.same(f"{kind} of {where}", [str(len(won)) for won in levels.sets], result[kind]["levels"])
    if not analysis.play:
        context.same(f"players of {where}", players(whole, context.coalition) or None, result.get("players"))
        context.same(f"states of {where}", str(len(whole.states)), result["counts"]["states"])


def alone(context, command, constants, run):
    """The command with the values of one instance writes the same object."""
    if run["status"] != "done":
        return
    given = ",".join(f"{name}={shown(value)}" for name, value in constants.items())
    result = context.program.ask(*command, "-c", given)
    both = (run["result"], result)
    parts = [{name: part for name, part in found.items() if name not in OF_THE_RUN} for found in both]
    context.same(f"the object of {given} alone", *parts)


def tabulated(context, runs, table):
    """The rows of a file."""
    rows = list(csv.DictReader(table.open(encoding="utf-8", newline="")))
    context.same("rows of the sweep", len(runs), len(rows))
    for run, row in zip(runs, rows):
        given = {name: shown(value) for name, value in run["constants"].items()}
        expected = {**given, "status": run["status"]}
        if run["status"] == "done":
            result = run["result"]
            expected["states"] = result["counts"]["states"]
            for kind in ("sasi", "spi"):
                levels = result[kind]["levels"]
                expected |= {f"{kind}_{k}": count for k, count in enumerate(levels, 1)}
                expected |= {f"{kind}_levels": str(len(levels)), f"{kind}_unbounded": result[kind]["unbounded"]}
        context.same(f"row of {given}", expected, {name: row.get(name) for name in expected})


def asked_again(context, text, model, asked, instances):
    """A property in all instances."""
    if context.is_game:
        return
    formula, program = context.preferences.objectives[0][1], context.program
    options = program.settings("scope", "threads", "engine")
    report = program.ask("reach", model, "--property", f"Pmax=? [ {formula} ]", "-c", asked, *options, allowed=(0, 1))
    for constants, run in zip(instances, report["runs"]):
        given = {name: shown(value) for name, value in constants.items()}
        question = Question(program_of(text, given), context.case.settings["scope"], formula, (), 3000)
        value, got = question.most()[question.whole.initial[0]], run["result"]["properties"][0]["value"]
        is_near = got is not None and abs(Fraction(got["lower"]) - value) <= Fraction(1, 10**6)
        context.same(f"value of {given}", "" if is_near else value, "" if is_near else got)


ALL = {"sweep": sweeps}
