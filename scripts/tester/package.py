"""What the Python package says, against the command: reports, values, explanations, simulations and shields."""

import json
import math
import random
import tempfile

from tester.context import LEVELS, WITHIN
from tester.program import key
from tester.promises import RUNS, STEPS, options_of

REPORTED = ("counts", "objectives", "classes", "improvement", "sasi", "spi", "initial")
OF_ACTION = ("name", "kept", "permitted", "progress", "verdict")
OF_SUCCESSOR = ("state", "probability", "unsafe", "most_preferred", "rank", "change", "gained", "lost", "dropped", "goal")
OF_SIMULATION = ("rank", "settled", "weakened_step", "weakened_start", "achieved_runs", "kept_runs")


def package(context):
    """All of it for one case. The command was compared with the reference, so it is what is expected."""
    import meliora

    case, names = context.case, ["scope", "safety", "engine", "threads"]
    names += ["order"] if case.settings["engine"] == "symbolic" else []
    model = meliora.Model.from_string(case.model_text())
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
        if case.settings["safety"] != "transition":
            try:
                shielded(context, meliora.Shield, strategy)
            except meliora.UsageError as error:
                if "choices with one label together" not in str(error):
                    raise
                told_apart(context, strategy.kind)
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


def explained(context, where, entry, found):
    """An explanation says what `strategy` says."""
    context.same(f"unsafe of {where}", entry.get("unsafe", False), found.unsafe)
    for what in ("most_preferred", "progress_action"):
        context.same(f"{what} of {where}", entry[what], as_json(getattr(found, what)))
    expected = [[action[what] for what in OF_ACTION] for action in entry["actions"]]
    context.same(f"actions of {where}", expected, [[getattr(a, what) for what in OF_ACTION] for a in found.actions])
    for action, here in zip(entry["actions"], found.actions):
        expected = [{"unsafe": False, **successor} for successor in action["successors"]]
        expected = [[successor[what] for what in OF_SUCCESSOR] for successor in expected]
        got = [[as_json(getattr(s, what)) for what in OF_SUCCESSOR] for s in here.successors]
        context.same(f"successors of {action['name']} of {where}", expected, got)


def simulated(context, analysis):
    """Equal seeds give equal runs, so the counts are those of `simulate`."""
    kind, objective, variant = options_of(context)
    options = ["--kind", kind, "--strategy", variant, "--runs", RUNS, "--steps", STEPS, "--seed", context.case.seed]
    options += ["--objective", objective] if objective else []
    strategy = analysis.strategy(kind, objective=objective)
    for play in context.program.about("simulate", *options)["plays"]:
        if play.get("unsafe"):
            continue
        found = strategy.simulate(play["state"], runs=RUNS, steps=STEPS, seed=context.case.seed, picks=variant)
        for what in OF_SIMULATION:
            if what in play:
                context.same(f"{what} of {kind} from {play['state']}", play[what], as_json(getattr(found, what)))


def shielded(context, Shield, strategy):
    """A shield, and its copy on disk, permit what the strategy permits, along random paths."""
    shield, draw = strategy.shield(), random.Random(context.case.seed)
    with tempfile.TemporaryDirectory() as folder:
        shield.save(folder)
        loaded = Shield.load(folder)
    context.same("states of the loaded shield", len(shield), len(loaded))
    fresh = {tuple(context.source.named(context.analysis.whole.plain(s)).items()) for s in context.relation.fresh()}
    starts, seen = [], set()
    for name in context.relation.of:  # the first state with the values of a start has its fresh monitors
        if name[: context.relation.width] in fresh - seen:
            seen.add(name[: context.relation.width])
            starts.append(dict(name))
    for start in starts:
        for _ in range(3):
            follow(context, (shield, loaded), strategy, start, draw)


def told_apart(context, kind):
    """A shield may refuse a strategy only if choices of one label differ in some state."""
    names = [[action["name"] for action in entry["actions"]] for entry in context.strategy("--kind", kind).values()]
    context.same("some choices share a label", True, any(len(labels(n)) < len(n) for n in names))


def follow(context, shields, strategy, start, draw, steps=12):
    """One random path of permitted actions."""
    play, width = strategy.play(start), context.relation.width
    for shield in shields:
        shield.reset(tuple(start.values())[:width])
    for number in range(steps):
        now, where = tuple(play.state.values())[:width], f"{strategy.kind} after {number} steps in {play.state}"
        if play.over:
            return
        permitted = play.actions()
        for shield in shields:
            context.same(f"ahead of {where}", play.ahead, shield.ahead(now))
            by_label(context, where, permitted, strategy.explain(play.state), shield.allowed(now))
        allowed = shields[0].allowed(now)
        permitted = [action for action in permitted if label(action) in allowed]
        action = draw.choice(permitted)
        for shield in shields:
            context.same(f"correct of {where}", label(action), label(shield.correct(now, label(action))))
        _, after = draw.choice(strategy.successors(play.state)[action])
        play.step(after)
        for shield in shields:
            shield.step(tuple(after.values())[:width])


def by_label(context, where, permitted, explained, allowed):
    """A label is allowed if all its choices are permitted, and no other one if one of these makes progress.

    In any case some choice of an allowed label is permitted, and some label is allowed.
    """
    others = labels({action.name for action in explained.actions} - set(permitted))
    sure = [name for name in labels(permitted) if name not in others]
    if set(sure) & set(labels(a.name for a in explained.actions if a.progress)):
        context.same(f"allowed of {where}", sure, labels(allowed))
    context.same(f"allowed at least of {where}", [], sorted(set(sure) - set(labels(allowed))))
    context.same(f"allowed at most of {where}", [], sorted(set(labels(allowed)) - set(labels(permitted))))
    context.same(f"something allowed of {where}", bool(permitted), bool(allowed))


def label(action):
    """Choices with the same label are permitted together."""
    return action.split("(")[0]


def labels(actions):
    return sorted({label(action) for action in actions})


ALL = {"python": package}
