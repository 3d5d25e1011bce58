"""Questions without preferences, sets of objectives, dumps, and models state by state."""

import itertools
import math
import random
from fractions import Fraction

from reference.model import explore
from reference.preferences import target_of
from reference.questions import Question, jointly, rewards
from tester.program import key
from tester.questions import bounded, earning


def reach(context):
    """The four regions of a formula, its probabilities and their bounds."""
    if context.is_game:
        return  # properties of a game name its players
    formula = context.preferences.objectives[context.case.seed % len(context.names)][1]
    text = context.program.text(formula)
    for required in {(), tuple(context.preferences.required)}:
        options = [word for formula in required for word in ("--require", context.program.text(formula))]
        question = Question(context.source, context.case.settings["scope"], formula, required, 3000)
        starts, regions = question.whole.initial, question.regions()
        most, least = ([values[s] for s in starts] for values in (question.most(), question.least()))
        bounds = bounded(context.case.seed, text, most, least)
        asked = [f"P>=1 [ {text} ]", f"Pmax=? [ {text} ]", f"Pmin=? [ {text} ]", *(text for text, _ in bounds)]
        report = reach_report(context, asked, options)
        entries = report["properties"]
        for asked_for, entry in zip(("P>=1", "Pmax=?", "Pmin=?"), entries):
            of_property(context, f"{asked_for} [ {text} ] with {options}", regions, NEEDED[asked_for], entry)
        alone(context, text, options, regions, starts)
        joined(context, text, options, regions, starts)
        unsafe = not question.unsafe().isdisjoint(starts)
        context.same("unsafe", unsafe, "unsafe" in report)
        if unsafe:
            context.same("holds where a start is unsafe", {False, None}, {entry["holds"] for entry in entries})
            context.same("values where a start is unsafe", {None}, {entry["value"] for entry in entries[1:3]})
            continue
        context.same("holds", set(starts) <= regions["pmin_one"], entries[0]["holds"])
        value_of(context, asked[1], most, entries[1]["value"])
        value_of(context, asked[2], least, entries[2]["value"])
        for (asked_for, holds), entry in zip(bounds, entries[3:]):
            context.same(f"holds of {asked_for} with {options}", holds, entry["holds"])


NEEDED = {
    "P>=1": ["pmin_one"],
    "Pmax=?": ["pmax_one", "pmax_positive"],
    "Pmin=?": ["pmin_one", "pmin_positive"],
    "Pmax>=1": ["pmax_one"],
    "Pmax>0": ["pmax_positive"],
    "P>0": ["pmin_positive"],
}


def of_property(context, what, regions, needed, entry):
    """The regions that an entry has are those of the reference, and those that the property needs are among them."""
    known = {name: entry[name] for name in regions if entry[name] is not None}
    context.same(f"regions of {what}", {name: str(len(regions[name])) for name in known}, known)
    context.same(f"regions that {what} needs", [], [name for name in needed if name not in known])


def alone(context, text, options, regions, starts):
    """One property alone: the regions that it needs, and its verdict."""
    asked_for = [*NEEDED][context.case.seed // 7 % len(NEEDED)]
    forms = ("{0}", "({0})") if asked_for.endswith("?") else ("{0}", "!!({0})", "true & ({0})", "!!(({0}) | false)")
    written = forms[context.case.seed % len(forms)].format(f"{asked_for} [ {text} ]")
    report = reach_report(context, [written], options)
    what = f"{written} alone with {options}"
    of_property(context, what, regions, NEEDED[asked_for], report)
    if "unsafe" not in report and not asked_for.endswith("?"):
        context.same(f"holds of {what}", set(starts) <= regions[NEEDED[asked_for][0]], report["holds"])
    if context.case.seed % 3 == 0 and context.case.settings["engine"] != "explicit":
        kept_regions(context, f"{asked_for} [ {text} ]", options, regions, report)


def joined(context, text, options, regions, starts):
    """Properties of several operators about the initial states, in a list and with their parts."""
    names = {f"{asked} [ {text} ]": regions[NEEDED[asked][0]] for asked in NEEDED if not asked.endswith("?")}
    (one, first), (two, second) = random.Random(context.case.seed).sample(sorted(names.items()), 2)
    expected = [
        (f"({one}) & !({two})", [s in first and s not in second for s in starts]),
        (f"({one}) | !({two})", [s in first or s not in second for s in starts]),
        (f"({one}) <=> ({two})", [(s in first) == (s in second) for s in starts]),
        (f'filter(exists, {one}, "init") => ({two})', [s in second or first.isdisjoint(starts) for s in starts]),
        (two, [s in second for s in starts]),
    ]
    report = reach_report(context, [written for written, _ in expected], options)
    if "unsafe" in report:
        expected = [(written, [False]) for written, _ in expected]
    for (written, truths), entry in zip(expected, report["properties"]):
        if len(starts) > 1 and "the initial states differ" in entry.get("reason", ""):
            continue
        context.same(f"holds of {written} with {options}", all(truths), entry["holds"])


def kept_regions(context, asked, options, regions, report):
    """`reach --out` writes the regions of a property, which `query` counts and `verify` refuses."""
    program, folder = context.program, context.program.folder / "regions"
    found = reach_report(context, [asked], [*options, "--out", folder])
    names = [region["name"] for region in found["written"]["regions"]]
    known = [name for name in regions if report[name] is not None]
    context.same(f"regions written for {asked}", sorted(known), sorted(name for name in names if name in regions))
    for name in known:
        count = program.ask("query", folder, name)["count"]
        context.same(f"{name} of {asked} in a dump", str(len(regions[name])), count)
    status, _, errors = program.run("verify", folder, program.model, program.prefs)
    context.same("verify of regions", (3, True), (status, "its regions are not certified" in errors))


def earned(context):
    """Expected rewards until a condition."""
    conditions = [target_of(text) for _, text in context.preferences.objectives]
    condition = next(filter(None, conditions), None)
    if context.is_game or condition is None or "cost" not in context.source.rewards:
        return
    whole = explore(context.source, context.case.settings["scope"], 3000)
    least, most = ([values[s] for s in whole.initial] for values in rewards(whole, whole.where(condition), "cost"))
    bounds = earning(context.case.seed, condition, least, most)
    asked = [f'R{{"cost"}}{m}=? [ F {condition} ]' for m in ("min", "max")] + [text for text, _ in bounds]
    entries = reach_report(context, asked, [])["properties"]
    value_of(context, asked[0], least, entries[0]["value"])
    value_of(context, asked[1], most, entries[1]["value"])
    for (text, holds), entry in zip(bounds, entries[2:]):
        context.same(f"holds of {text}", holds, entry["holds"])


def reach_report(context, asked, options):
    program = context.program
    words = [word for text in asked for word in ("--property", text)]
    names = ["scope", "engine", "threads"] + (["order"] if context.case.settings["engine"] == "symbolic" else [])
    return program.ask("reach", program.model, *words, *options, *program.settings(*names), allowed=(0, 1))


def value_of(context, what, values, bounds):
    """A value over several states: bounds of the least and of the greatest."""
    precision = math.inf if context.is_rare() else None
    for value, name in ((min(values), "lower"), (max(values), "upper")):
        got = math.inf if bounds[name] == "inf" else bounds[name]
        near, outside = is_near(value, got), got <= value if name == "lower" else got >= value
        context.same(
            f"{name} of {what}",
            "" if (near or precision) and outside else str(value),
            "" if (near or precision) and outside else got,
        )


def is_near(value, got):
    """A bound is near the value. Both may be infinite, and the value may be above the doubles."""
    if math.inf in (value, got):
        return value == got
    return abs(Fraction(got) - value) <= Fraction(11, 10**7) * max(1, value)


def together(context):
    """`check --jointly`: sets of most preferred outcomes that one path can achieve."""
    if context.is_game:
        return
    analysis, relation = context.analysis, context.relation
    report = context.program.about("check", "--jointly")
    for entry in report["classes"]:
        members = [context.names.index(name) for name in entry["most_preferred"]]
        got = {tuple(j["objectives"]): int(j["states"]) for j in entry.get("jointly") or []}
        of_class = [s for s in map(relation.one, relation.of) if analysis.classes[s] == frozenset(members)]
        expected = {}
        for size in range(2, len(members) + 1):
            for subset in itertools.combinations(members, size):
                count = sum(s in jointly_known(analysis, subset) for s in of_class)
                if count:
                    expected[tuple(context.named(subset))] = count
        context.same(f"jointly of {entry['most_preferred']}", expected, got)
    for entry in report["initial"]:
        state = relation.one(key(entry["state"]))
        if state in analysis.mdp.unsafe:
            continue
        members = sorted(analysis.classes[state])
        sets = [
            c
            for n in range(1, len(members) + 1)
            for c in itertools.combinations(members, n)
            if state in jointly_known(analysis, c)
        ]
        largest = [context.named(c) for c in sets if not any(set(c) < set(d) for d in sets)]
        context.same(f"jointly of {entry['state']}", sorted(largest), sorted(entry.get("jointly") or []))


def jointly_known(analysis, subset):
    known = analysis.__dict__.setdefault("jointly", {})
    if subset not in known:
        known[subset] = jointly(analysis, subset)
    return known[subset]


def compare(context):
    """Both engines agree."""
    report = context.program.about("compare", allowed=(0, 1))
    context.same("equal", (True, None), (report["equal"], report["difference"]))


ALL = {"reach": reach, "rewards": earned, "jointly": together, "compare": compare}
