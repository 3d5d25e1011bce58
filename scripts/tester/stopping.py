"""`reach --stop-at-target`: paths that stop where the question is decided."""

from reference.model import explore, reachability
from reference.preferences import target_of
from reference.questions import Question, deciding, reached_until, rewards
from tester.games import coalitions
from tester.regions import NEEDED, value_of

STOP = "--stop-at-target"


def stop(context):
    """Targets, formulas and rewards: the answer in the initial states is that for the whole model, and the regions are
    those of the states that are left."""
    case = context.case
    whole = explore(context.source, "reachable", 3000)
    text = context.preferences.objectives[case.seed // 3 % len(context.names)][1]
    target = target_of(text)
    if target is not None:
        at_target(context, whole, target)
    if context.is_game:
        return
    decided = deciding(whole, text)
    operator = [*NEEDED][case.seed // 5 % len(NEEDED)]
    asked = f"{operator} [ {text} ]"
    if decided is None:
        refused(context, asked)
    else:
        context.case.features.add("stops at the target")
        of_formula(context, whole, (asked, operator, text), decided)
    if target is not None and "cost" in context.source.rewards:
        earned(context, whole, target)
    combined(context, asked)


def options(context):
    symbolic = context.case.settings["engine"] == "symbolic"
    return context.program.settings("engine", "threads", *(["order"] if symbolic else []))


def report_of(context, *words):
    return context.program.ask("reach", context.program.model, *words, STOP, *options(context), allowed=(0, 1))


def sizes(context, what, whole, decided, report):
    """The states that are left, and their deadlocks. Returns the states."""
    left = reached_until(whole, decided)
    context.same(f"states of {what}", str(len(left)), report["counts"]["states"])
    context.same(f"deadlocks of {what}", str(len(whole.deadlocks & left - decided)), report["counts"]["deadlocks"])
    context.same(f"says that {what} stops", True, report["stops_at_target"])
    return left


def at_target(context, whole, target):
    """The four regions of a target, in a game for some players."""
    words, played = [], whole
    if context.is_game:
        every = coalitions(len(context.case.players))
        coalition = every[1 + context.case.seed % (len(every) - 1)]
        words = ["--coalition", ",".join(context.case.players[at] for at in sorted(coalition))]
        played = whole.played_by(coalition)
    goal = whole.where(target)
    report = report_of(context, "--target", target, *words)
    left = sizes(context, f"{target} {words}", whole, goal, report)
    for name, states in reachability(played, goal).items():
        if report[name] is not None:
            context.same(f"{name} of {target} {words} that stops", str(len(states & left)), report[name])


def of_formula(context, whole, asked, decided):
    """The regions, the verdict and the value of a property."""
    words, operator, text = asked
    question = Question(context.source, "reachable", text, (), 3000)
    regions, starts = question.regions(), question.whole.initial
    report = report_of(context, "--property", words)
    left = sizes(context, words, whole, decided, report)
    for name in NEEDED[operator]:
        context.same(f"{name} of {words} that stops", str(len(regions[name] & left)), report[name])
    if operator.endswith("?"):
        values = question.most() if operator == "Pmax=?" else question.least()
        values = [values[s] for s in starts]
        value_of(context, f"{words} that stops", values, report["properties"][0]["value"])
        filtered(context, words, {"min": min(values), "max": max(values), "avg": sum(values) / len(values)}, left)
    else:
        holding = regions[NEEDED[operator][0]].intersection(starts)
        context.same(f"holds of {words} that stops", len(holding) == len(starts), report["holds"])
        filtered(context, words, {"exists": bool(holding), "count": len(holding)}, left)


def filtered(context, words, values, left):
    """A function of the property in the initial states."""
    function, expected = [*values.items()][context.case.seed // 7 % len(values)]
    text = f'filter({function}, {words}, "init")'
    report = report_of(context, "--property", text)
    context.same(f"states of {text} that stops", str(len(left)), report["counts"]["states"])
    if function == "exists":
        context.same(f"holds of {text} that stops", expected, report["holds"])
    else:
        value_of(context, f"{text} that stops", [expected], report["properties"][0]["value"])


def earned(context, whole, target):
    """The least and the greatest reward until a target."""
    goal = whole.where(target)
    for best, values in zip(("min", "max"), rewards(whole, goal, "cost")):
        words = f'R{{"cost"}}{best}=? [ F {target} ]'
        report = report_of(context, "--property", words)
        sizes(context, words, whole, goal, report)
        value = report["properties"][0]["value"]
        value_of(context, f"{words} that stops", [values[s] for s in whole.initial], value)


def refused(context, asked, *more, status=3):
    """A question with an option that it cannot be asked with."""
    found, out, errors = context.program.run("reach", context.program.model, "--property", asked, STOP, *more)
    context.same(f"status of {asked} {more} that stops", (status, True), (found, STOP in errors + out))


def combined(context, asked):
    """Options that cannot be combined with it are named."""
    more = [["--scope", "all"], ["--property", "P>=1 [ F x=0 ]"]]
    more += [["--require", formula] for formula in context.preferences.required[:1]]
    refused(context, asked, *more[context.case.seed % len(more)], status=2)


ALL = {"stop": stop}
