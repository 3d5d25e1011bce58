"""What the Python package says, against the command: reports, values, explanations, simulations and shields."""

import csv
import json
import math

from tester import environment, games, pages, sets, sweeps
from tester.context import LEVELS, WITHIN, Difference
from tester.program import Refused, rounded
from tester.promises import RUNS, STEPS, opponent_of, options_of
from tester.shields import shield_of_pursuit, shields

REPORTED = ("players", "counts", "objectives", "classes", "improvement", "sasi", "spi", "initial")
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
    """All of it for one case. The command was compared with the reference, so its results are expected."""
    import meliora

    case, model = context.case, modelled(context.case, meliora)
    labels = sorted({text[1 : text.index("]")] for _, text in case.commands} - {""})
    context.same("labels", labels, sorted(model.actions))
    preferences = meliora.Preferences.from_string(case.preferences_text())
    analysis = model.check(preferences, safety=case.settings["safety"], **options_of_model(context))
    report = plain(analysis.to_dict())
    for what in REPORTED:
        context.same(f"{what} of check", context.report.get(what), report.get(what))
    if context.is_game:
        environment.game(context, meliora, model, analysis)
    else:
        numbers(context, analysis)
        sets.together(context, analysis)
    for kind in ("sasi", "spi"):
        strategy = analysis.strategy(kind)
        told(context, kind, (), strategy, model.actions)
        if case.settings["safety"] != "transition":
            shields(context, meliora, strategy)
    pursuing(context, meliora, analysis)
    sets.sets(context, analysis)
    sets.reach(context, meliora, model)
    simulated(context, meliora, analysis)
    written(context, meliora, analysis)
    page(context, analysis)
    swept(context, meliora)


def refused(case, error):
    """A case that the reference refuses is refused by the package, too, for the same reason. Returns differences."""
    import meliora

    settings, reason = case.settings, games.reason_of(error)
    try:
        preferences = meliora.Preferences.from_string(case.preferences_text())
        options = {name: settings[name] for name in ("scope", "safety", "engine")}
        said = f"no error: {modelled(case, meliora).check(preferences, **options)}"
    except (meliora.InputError, meliora.UsageError) as raised:
        said = str(raised)
    # The package explores before it looks at the preferences.
    known = {reason, *(["two players may move"] if case.fault == "two movers" else [])}
    known |= set(games.OF_STATES) if case.unlisted else set()
    if any(games.SAID[one] in said for one in known):
        return []
    return [Difference("faults", "refused by the package", reason, said, [])]


def modelled(case, meliora):
    """The model, with the coalition that the options name."""
    model, named = meliora.Model.from_string(case.model_text()), named_players(case)
    return model.with_coalition(*named) if named else model


def named_players(case):
    """The coalition that the options name; a number is a player, too."""
    return [int(n) if n.isdigit() else n for n in case.settings["coalition"].split(",") if n]


def options_of_model(context):
    """The options of an exploration."""
    settings = context.case.settings
    names = ["scope", "engine", "threads"] + (["order"] if settings["engine"] == "symbolic" else [])
    return {name: settings[name] for name in names}


def numbers(context, analysis):
    """`values` of every state."""
    states = [entry["state"] for entry in context.values["states"]]
    exact, reward = context.case.seed % 3 == 0, context.case.settings["reward"]
    values = analysis.values(states, levels=LEVELS, within=WITHIN, reward=reward, exact=exact)
    context.same("values", *(rounded(by_name(found)) for found in (context.values["states"], plain(values))))


def by_name(states):
    """Values with actions in the order of their names: the order of states decides between equally good ones."""
    for state in states:
        for level in state["levels"]:
            level["actions"].sort(key=lambda action: action["action"])
    return states


def told(context, what, options, strategy, actions, more=()):
    """What a strategy says of each state, and its masks."""
    kind = what.split()[0]
    for name, entry in context.strategy("--kind", kind, *options).items():
        explained(context, f"{what} in {dict(name)}", entry, strategy.explain(dict(name)), more)
        masked(context, f"{what} in {dict(name)}", entry, strategy, actions)


def pursuing(context, meliora, analysis):
    """Strategies that achieve objectives, and their shields. Both refuse the same ones."""
    named = context.names[context.case.seed % len(context.names)]
    for kind, objective in (("plan", None), ("plan", named), ("achieve", named)):
        what, options = f"{kind} {objective}", ("--objective", objective) if objective else ()
        try:
            context.strategy("--kind", kind, *options)
        except Refused as refused:
            said = raised(
                meliora, lambda: analysis.strategy(kind, objective=objective).explain(context.check_states[0])
            )
            context.same(f"refusal of {what}", True, bool(said) and said in message_of(refused))
            continue
        strategy = analysis.strategy(kind, objective=objective)
        told(context, what, options, strategy, analysis.model.actions, OF_PLAN)
        if context.case.settings["safety"] != "transition":
            shield_of_pursuit(context, meliora, strategy, objective)


def raised(meliora, work):
    """The message of an error; None without one."""
    try:
        work()
    except (meliora.InputError, meliora.UsageError) as error:
        return str(error).splitlines()[0]
    return None


def message_of(refused):
    """The message of a refusal of the command, which may stand in JSON."""
    return str(refused).replace('\\"', '"')


def plain(value):
    """What a program reads from JSON."""
    return json.loads(json.dumps(value))


def as_json(value):
    if isinstance(value, float) and not math.isfinite(value):
        return "unbounded" if value == math.inf else None
    return list(value) if isinstance(value, tuple) else value


def explained(context, where, entry, found, more=()):
    """An explanation says what `strategy` says."""
    context.same(f"unsafe of {where}", entry.get("unsafe", False), found.unsafe)
    mover = (entry.get("owner") == "opponent", entry.get("player"))
    context.same(f"owner of {where}", mover, (found.theirs, found.owner))
    for what in ("most_preferred", *more):
        context.same(f"{what} of {where}", entry[what], as_json(getattr(found, what)))
    # In Python, the progress strategy takes no action where it ends. The opponent's actions have no marks.
    context.same(f"progress_action of {where}", entry.get("chosen_action"), found.progress_action)
    expected = [[action.get(what, False) for what in OF_ACTION] for action in entry["actions"]]
    context.same(f"actions of {where}", expected, [[getattr(a, what) for what in OF_ACTION] for a in found.actions])
    for action, here in zip(entry["actions"], found.actions):
        expected = [{"unsafe": False, **successor} for successor in action["successors"]]
        # In Python, the rank of an unsafe state is not a number.
        expected = [{**successor, "rank": None} if successor["unsafe"] else successor for successor in expected]
        expected = [[successor[what] for what in OF_SUCCESSOR] for successor in expected]
        got = [[as_json(getattr(s, what)) for what in OF_SUCCESSOR] for s in here.successors]
        context.same(f"successors of {action['name']} of {where}", expected, got)


def masked(context, where, entry, strategy, actions):
    """The masks of a state: for each label, whether a choice with it is selected."""
    actions_of = {
        what: [a["name"] for a in entry["actions"] if a.get(what)] for what in ("permitted", "progress", "kept")
    }
    actions_of["progress"] = actions_of["progress"][:1]
    actions_of["chosen"] = list(filter(None, [entry.get("chosen_action")]))
    for which, names in actions_of.items():
        selected = {name.split("(")[0] for name in names}
        got = strategy.mask(entry["state"], which=which).tolist()
        context.same(f"mask of {which} of {where}", [action in selected for action in actions], got)


def simulated(context, meliora, analysis):
    """Equal seeds give equal runs, so the counts are those of `simulate`."""
    kind, objective, variant = options_of(context)
    options = ["--kind", kind, "--scheduler", variant, "--runs", RUNS, "--steps", STEPS, "--seed", context.case.seed]
    options += ["--objective", objective] if objective else []
    against = {"opponent": opponent_of(context)} if context.is_game else {}
    options += [word for name, value in against.items() for word in (f"--{name}", value)]
    try:
        plays = context.program.about("simulate", *options)["plays"]
    except Refused:
        return  # `pursuing` compares refusals
    strategy = analysis.strategy(kind, objective=objective)
    for play in plays:
        if play.get("unsafe"):
            continue
        found = strategy.simulate(
            play["state"], runs=RUNS, steps=STEPS, seed=context.case.seed, picks=variant, **against
        )
        for what in OF_SIMULATION:
            if what in play:
                context.same(f"{what} of {kind} from {play['state']}", play[what], as_json(getattr(found, what)))
        moves = {player["name"]: player["steps"] for player in play.get("players", ())}
        context.same(f"moves of {kind} from {play['state']}", moves, found.moves)


def written(context, meliora, analysis):
    """A dump that the package writes and reads has the regions of the command's; both accept it, or refuse to write
    it."""
    program = context.program
    folders = [program.folder / name for name in ("of-the-package", "of-the-command")]
    try:
        report = program.about("export", "--out", folders[1])
    except Refused as refused:
        said = raised(meliora, lambda: analysis.export(folders[0]))
        context.same("refusal of a dump", True, bool(said) and said in message_of(refused))
        return
    analysis.export(folders[0])
    dump = meliora.Dump(folders[0])
    counts = {region["name"]: int(region["count"]) for region in report["regions"]}
    context.same("regions of a dump", counts, {name: dump.count(name) for name in dump.regions})
    verdict = meliora.verify(folders[0], analysis.model, analysis.preferences)
    context.same("verify accepts", (True, None), (verdict.accepted, verdict.violation))


def page(context, analysis):
    """The page has the data and the maps of `report`, which draws no other engine's."""
    if context.case.settings["engine"] == "symbolic":
        found = pages.Page(context, analysis.to_html())
        found.everywhere()
        found.maps()


def swept(context, meliora):
    """A sweep writes the table of the command, times and memory aside."""
    case, program = context.case, context.program
    if not sweeps.is_swept(case):
        return
    model, tables = program.folder / "swept.prism", [program.folder / f"{name}.csv" for name in ("command", "package")]
    model.write_text(sweeps.parametrised(case)[0], encoding="utf-8")
    options = program.settings("scope", "safety", "engine", "coalition")
    program.run("check", model, program.prefs, "-c", f"K=0:{case.size}", *options, "--csv", tables[0])
    settings = {name: case.settings[name] for name in ("scope", "safety", "engine")}
    coalition = named_players(case) or None
    meliora.sweep(model, program.prefs, K=range(case.size + 1), csv=tables[1], coalition=coalition, **settings)
    rows = [[without_costs(row) for row in csv.DictReader(table.open(encoding="utf-8"))] for table in tables]
    context.same("table of a sweep", *rows)


def without_costs(row):
    return {name: value for name, value in row.items() if name not in ("seconds", "peak_nodes", "peak_rss_bytes")}


ALL = {"python": package}
