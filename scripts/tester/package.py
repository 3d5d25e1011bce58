"""What the Python package says, against the command: reports, values, explanations, simulations and shields."""

import json
import math

from tester import sets
from tester.context import LEVELS, WITHIN
from tester.promises import RUNS, STEPS, options_of
from tester.shields import shields

REPORTED = ("counts", "objectives", "classes", "improvement", "sasi", "spi", "initial")
OF_ACTION = ("name", "kept", "permitted", "progress", "verdict")
OF_SUCCESSOR = (
    "state",
    "probability",
    "unsafe",
    "most_preferred",
    "rank",
    "change",
    "gained",
    "lost",
    "dropped",
    "goal",
)
OF_PLAN = ("pursues", "commits", "achieved")
OF_SIMULATION = ("rank", "settled", "weakened_step", "weakened_start", "achieved_runs", "kept_runs")


def package(context):
    """All of it for one case. The command was compared with the reference, so it is what is expected."""
    import meliora

    case, names = context.case, ["scope", "safety", "engine", "threads"]
    names += ["order"] if case.settings["engine"] == "symbolic" else []
    model = meliora.Model.from_string(case.model_text())
    context.same(
        "labels", sorted({text[1 : text.index("]")] for _, text in case.commands} - {""}), sorted(model.actions)
    )
    preferences = meliora.Preferences.from_string(case.preferences_text())
    analysis = model.check(preferences, **{name: case.settings[name] for name in names})
    report = plain(analysis.to_dict())
    for what in REPORTED:
        context.same(f"{what} of check", context.report.get(what), report.get(what))
    states = [entry["state"] for entry in context.values["states"]]
    exact = case.seed % 3 == 0
    values = analysis.values(states, levels=LEVELS, within=WITHIN, reward=case.settings["reward"], exact=exact)
    context.same("values", rounded(context.values["states"]), rounded(plain(values)))
    for kind in ("sasi", "spi"):
        strategy = analysis.strategy(kind)
        for name, entry in context.strategy("--kind", kind).items():
            explained(context, f"{kind} in {dict(name)}", entry, strategy.explain(dict(name)))
            masked(context, f"{kind} in {dict(name)}", entry, strategy, model.actions)
        if case.settings["safety"] != "transition":
            shields(context, meliora, strategy)
    number = case.seed % len(context.names)
    for kind, named in (("plan", None), ("plan", context.names[number]), ("achieve", context.names[number])):
        strategy, options = analysis.strategy(kind, objective=named), ("--objective", named) if named else ()
        for name, entry in context.strategy("--kind", kind, *options).items():
            explained(context, f"{kind} {named} in {dict(name)}", entry, strategy.explain(dict(name)), OF_PLAN)
            masked(context, f"{kind} {named} in {dict(name)}", entry, strategy, model.actions)
    sets.sets(context, analysis)
    sets.together(context, analysis)
    sets.reach(context, meliora, model)
    simulated(context, analysis)


def plain(value):
    """What a program reads from JSON."""
    return json.loads(json.dumps(value))


def rounded(value):
    """Numbers with nine digits, 0 below 1e-300: the order of the states may move the last bit of a sum."""
    if isinstance(value, float):
        return 0.0 if abs(value) < 1e-300 else float(f"{value:.9g}")
    if isinstance(value, dict):
        return {name: rounded(part) for name, part in value.items()}
    return [rounded(part) for part in value] if isinstance(value, list) else value


def as_json(value):
    return list(value) if isinstance(value, tuple) else "unbounded" if value == math.inf else value


def explained(context, where, entry, found, more=()):
    """An explanation says what `strategy` says."""
    context.same(f"unsafe of {where}", entry.get("unsafe", False), found.unsafe)
    for what in ("most_preferred", *more):
        context.same(f"{what} of {where}", entry[what], as_json(getattr(found, what)))
    # In Python, the progress strategy takes no action where it ends.
    context.same(f"progress_action of {where}", entry["chosen_action"], found.progress_action)
    expected = [[action[what] for what in OF_ACTION] for action in entry["actions"]]
    context.same(f"actions of {where}", expected, [[getattr(a, what) for what in OF_ACTION] for a in found.actions])
    for action, here in zip(entry["actions"], found.actions):
        expected = [{"unsafe": False, **successor} for successor in action["successors"]]
        expected = [[successor[what] for what in OF_SUCCESSOR] for successor in expected]
        got = [[as_json(getattr(s, what)) for what in OF_SUCCESSOR] for s in here.successors]
        context.same(f"successors of {action['name']} of {where}", expected, got)


def masked(context, where, entry, strategy, actions):
    """The masks of a state: for each label, whether a choice with it is selected."""
    actions_of = {what: [a["name"] for a in entry["actions"] if a[what]] for what in ("permitted", "progress", "kept")}
    actions_of["progress"] = actions_of["progress"][:1]
    actions_of["chosen"] = [entry["chosen_action"]] if entry["chosen_action"] else []
    for which, names in actions_of.items():
        selected = {name.split("(")[0] for name in names}
        got = strategy.mask(entry["state"], which=which).tolist()
        context.same(f"mask of {which} of {where}", [action in selected for action in actions], got)


def simulated(context, analysis):
    """Equal seeds give equal runs, so the counts are those of `simulate`."""
    kind, objective, variant = options_of(context)
    options = ["--kind", kind, "--scheduler", variant, "--runs", RUNS, "--steps", STEPS, "--seed", context.case.seed]
    options += ["--objective", objective] if objective else []
    strategy = analysis.strategy(kind, objective=objective)
    for play in context.program.about("simulate", *options)["plays"]:
        if play.get("unsafe"):
            continue
        found = strategy.simulate(play["state"], runs=RUNS, steps=STEPS, seed=context.case.seed, picks=variant)
        for what in OF_SIMULATION:
            if what in play:
                context.same(f"{what} of {kind} from {play['state']}", play[what], as_json(getattr(found, what)))


ALL = {"python": package}
