"""Games: their players, what each coalition enforces, and models and files whose players are wrong."""

import itertools
import random
import re
from dataclasses import replace
from fractions import Fraction

import harness
from reference.games import LeftOut
from reference.model import explore, reachability
from reference.preferences import target_of
from reference.prism import InputError, program_of
from reference.questions import Question
from reference.reports import amount, players
from tester.context import Difference
from tester.program import key
from tester.questions import COMPARE

NUMBERS = ("0", "1", "0.3", "0.75")


def owners(context):
    """Who chooses: the players with the numbers of their states, and the owners of initial states."""
    whole, given = context.analysis.whole, context.case.settings["coalition"]
    expected = players(whole, context.coalition)
    for at, player in enumerate(expected):
        player["states"] = context.relation.count({s for s in whole.states if whole.owners[s] == at})
    context.same("players", expected or None, context.report.get("players"))
    for entry in context.report["initial"]:
        is_theirs = context.relation.one(key(entry["state"])) in whole.theirs
        context.same(f"owner of {entry['state']}", "opponent" if is_theirs else None, entry.get("owner"))
    weakening(context)
    if context.is_game:
        alone = explore(context.source, context.case.settings["scope"], 3000)
        report = context.program.ask("info", context.program.model, *context.program.settings("scope", "coalition"))
        context.same("players of info", players(alone, given.split(",") if given else ()), report.get("players"))


def weakening(context):
    """The lemma of section 11: a step of the opponent weakens only if it leaves a target that counted."""
    analysis = context.analysis
    for state in analysis.mdp.theirs:
        for to in {to for choice in analysis.mdp.choices[state] for to in choice.to}:
            if analysis.preferences.weakens(analysis.classes[state], analysis.classes[to]):
                counted = [i for i in analysis.classes[state] if state in analysis.targets[i]]
                left = [i for i in counted if to not in analysis.sure[i]]
                context.same(f"a step of the opponent weakens in {state}", (False, True), (analysis.play, bool(left)))


def enforced(context):
    """What several coalitions enforce of a target and of an objective, without and with requirements."""
    if not context.is_game:
        return
    case, program, draw = context.case, context.program, random.Random(context.case.seed)
    names = program.settings("scope", "engine", "threads")
    names += program.settings("order") if case.settings["engine"] == "symbolic" else []
    formulas = [text for _, text in context.preferences.objectives]
    target = next(filter(None, map(target_of, formulas)), None)
    temporal = [text for text in formulas if target_of(text) is None]
    if target is not None:
        whole = explore(context.source, case.settings["scope"], 3000)
        every = coalitions(len(case.players))
        for coalition in draw.sample(every[1:], min(3, len(every) - 1)):
            words = ",".join(case.players[at] for at in sorted(coalition))
            report = program.ask("reach", program.model, "--target", target, "--coalition", words, *names)
            regions = reachability(whole.played_by(coalition), whole.where(target))
            for name, states in regions.items():
                context.same(f"{name} of {words}", str(len(states)), report[name])
                context.same(f"initial {name} of {words}", amount(states, whole.initial), report["initial"][name])
    for formula in ([f"F {target}"] if target else []) + draw.sample(temporal, min(2, len(temporal))):
        asked_of(context, draw, formula, names)


def asked_of(context, draw, formula, names):
    """Properties of one formula: several at once, and one alone."""
    players, required = context.case.players, context.preferences.required
    questions = [asked(draw, formula, players, who) for who in draw.choices(coalitions(len(players)), k=6)]
    for some in ([], required) if required else ([],):
        options = [word for text in some for word in ("--require", text)]
        for part in (questions, [draw.choice(questions)]):
            try:
                properties(context, part, formula, (some, [*options, *names]))
            except LeftOut:
                pass
            except InputError as error:
                words = [word for text, *_ in part for word in ("--property", text)]
                status, _, errors = context.program.run("reach", context.program.model, *words, *options, *names)
                said = next(said for reason, said in SAID.items() if reason in str(error))
                context.same(f"refusal of {formula}", (3, True), (status, said in errors))


def coalitions(count):
    """All sets of positions, the empty one first."""
    return [frozenset(some) for size in range(count + 1) for some in itertools.combinations(range(count), size)]


def asked(draw, formula, names, coalition):
    """A property of some players: its text, their positions, the operator, and the number that it compares with."""
    words = [names[at] if draw.random() < 0.8 else str(at + 1) for at in draw.sample(sorted(coalition), len(coalition))]
    shown = "*" if len(coalition) == len(names) and draw.random() < 0.5 else ",".join(words)
    operator, number = draw.choice(["=?", *COMPARE]), draw.choice(NUMBERS)
    best = draw.choice(["max", "min"]) if operator == "=?" else ""
    bound = "=?" if operator == "=?" else f"{operator}{number}"
    return f"<<{shown}>> P{best}{bound} [ {formula} ]", coalition, best or operator, Fraction(number)


def properties(context, questions, formula, conditions):
    """Verdicts and values of properties that name their players; a single one without an answer is refused."""
    program, (required, options) = context.program, conditions
    words = [word for text, *_ in questions for word in ("--property", text)]
    status, out, errors = program.run("reach", program.model, *words, *options, "--json")
    scope = context.case.settings["scope"]
    found = []
    for text, coalition, operator, number in questions:
        question = Question(context.source, scope, formula, required, 3000, coalition)
        found.append((text, question.regions(), verdict(question, operator, number)))
    report = harness.json_object(out) or {}
    context.same(f"status of {words} with {required}", True, "properties" in report and status in (0, 1))
    for (text, regions, expected), entry in zip(found, report.get("properties", ())):
        got = entry["holds"], entry.get("value")
        context.same(f"answer of {text} with {required}", (expected[0], True), (got[0], encloses(got[1], expected[1])))
        known = {name: entry[name] for name in regions if entry[name] is not None}
        sizes = {name: str(len(regions[name])) for name in known}
        context.same(f"regions of {text} with {required}", sizes, known)


QUALITATIVE = ((">=", 1), (">", 0), ("<", 1), ("<=", 0))


def encloses(bounds, expected):
    """Whether bounds are those of the least and the greatest of some values, up to the precision."""
    if bounds is None or expected is None:
        return bounds is expected
    lower, upper = Fraction(bounds["lower"]), Fraction(bounds["upper"])
    away = expected[0] - lower, upper - expected[1]
    return all(0 <= x <= Fraction(1, 10**6) for x in away)


def verdict(question, operator, number):
    """Whether a property holds in all initial states, and the least and the greatest value in them."""
    starts = question.whole.initial
    if not question.unsafe().isdisjoint(starts):
        return False if operator in COMPARE else None, None
    found = question.contested("pmax" if operator in ("max", ">=", ">") else "pmin")
    values = [found[s] for s in starts]
    shown = min(values), max(values)
    if operator not in COMPARE:
        return None, shown
    truth = all(COMPARE[operator](value, number) for value in values)
    return truth, None if (operator, number) in QUALITATIVE else shown


# What the reference says of wrong players, and what the program says.
SAID = {
    "two players may move": "several players may move in the state",
    "belongs to two players": "belongs to two players",
    "several choices belong to no player": "several choices belong to no player in the state",
    "owns what there is not": "unknown",
    "unknown player": "unknown player",
    "recurrence and persistence": "combines recurrence and persistence",
}
OF_STATES = ("two players may move", "several choices belong to no player")
OF_PREFERENCES = ("unknown player", "recurrence and persistence")


def reason_of(error):
    """The key of `SAID` that the reference names."""
    return next(reason for reason in SAID if reason in str(error))


def wrong(reason, owners):
    """Whether a state with these owners is refused for a reason of `OF_STATES`."""
    return len(owners) > 1 if reason == OF_STATES[0] else None in owners


def refused(case, program, error):
    """A case that the reference refuses is refused by all commands, for the same reason. Returns the numbers of
    comparisons by check, and the differences."""
    reason, movers = reason_of(error), None
    if reason in OF_STATES:
        source = program_of(case.model_text(), {})
        whole = explore(replace(source, players={}), case.settings["scope"], 3000)
        plain = map(whole.plain, whole.states)
        of = {source.show(values): source.movers(values) for values in plain}
        # One state may be of two players, another one of none: either may be found first.
        movers = {(SAID[one], state) for state, own in of.items() for one in OF_STATES if wrong(one, own)}
    found, compared = [], 0
    for command in ("check", "compare") if reason in OF_PREFERENCES else ("check", "compare", "info", "reach"):
        names = ["scope"] + ([] if command == "compare" else ["engine"])
        more = {"info": [], "reach": ["--target", "x=0"]}.get(command, [program.prefs])
        status, _, errors = program.run(command, program.model, *more, *program.settings(*names))
        compared += 1
        state = re.search(r"in the state (.*?):", errors)
        right = status == 3 and (movers is not None or SAID[reason] in errors)
        # The words of monitors follow the state.
        right &= movers is None or bool(state) and any(
            said in errors and f"{state[1]},".startswith(f"{mover},") for said, mover in movers
        )
        if not right:
            expected = (reason, movers)
            found.append(Difference("faults", f"refused by {command}", expected, errors[:600], program.asked[-1]))
    return {"faults": compared}, found


ALL = {"players": owners, "enforced": enforced}
