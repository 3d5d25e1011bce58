"""What strategies promise on simulated paths."""

import random

from reference.product import satisfaction
from reference.reports import players
from reference.shields import Shield as Machine
from reference.strategies import achieved, gained, lost
from reference.temporal import parts
from tester.context import LEVELS
from tester.program import at, key

RUNS, STEPS = 20, 3000


def starts(context):
    """The safe initial states, by name, with their states of the reference."""
    known = {key(entry["state"]): context.relation.one(key(entry["state"])) for entry in context.report["initial"]}
    return {name: state for name, state in known.items() if state not in context.analysis.mdp.unsafe}


def options_of(context):
    """A kind, an objective and a variant of strategies, which depend on the seed alone."""
    seed, names = context.case.seed, context.names
    kind = ("sasi", "spi", "plan", "achieve")[seed % 4]
    # A plan takes an objective by name, or the first that it can keep.
    named = kind == "achieve" or kind == "plan" and seed // 16 % 2
    objective = names[(seed // 4) % len(names)] if named else None
    return kind, objective, ("progress", "permissive")[(seed // 8) % 2]


def opponent_of(context):
    """How the opponent of a game chooses; None for other models."""
    return ("random", "worst")[context.case.seed // 32 % 2] if context.is_game else None


def simulate(context):
    """Simulated paths are paths of the model, and keep the promises of their strategy."""
    kind, objective, variant = options_of(context)
    options = ["--kind", kind, "--scheduler", variant, "--runs", RUNS, "--steps", STEPS, "--seed", context.case.seed]
    options += ["--objective", objective] if objective else []
    opponent = opponent_of(context)
    options += ["--opponent", opponent] if opponent else []
    states = some_states(context)
    report = context.program.about("simulate", *options, *(word for state in states for word in ("--at", at(state))))
    if states:
        context.same("states of the runs", states, [play["state"] for play in report["plays"]])
    context.same("opponent", opponent, report.get("opponent"))
    for play in report["plays"]:
        name = key(play["state"])
        state = context.relation.one(name)
        unsafe = state in context.analysis.mdp.unsafe
        context.same(f"unsafe of {dict(name)}", unsafe, play.get("unsafe", False))
        if not unsafe:
            path_of(context, kind, objective, variant, play, opponent)
            movers_of(context, play)
            statistics_of(context, kind, objective, state, play)


def some_states(context):
    """For some cases, states in which runs begin instead of the initial ones: any of the scope."""
    draw = random.Random(context.case.seed)
    if draw.random() < 0.5:
        return []
    return draw.sample(context.check_states, min(3, len(context.check_states)))


def chosen(context):
    """Simulations that choose by value report the value that the reference computes."""
    for choose, kind, tables in (("likely", "spi", context.probabilities), ("cheap", "sasi", context.costs)):
        reward = context.program.settings("reward") if choose == "cheap" else []
        options = ["--kind", kind, "--choose", choose, "--levels", LEVELS, "--runs", RUNS, "--steps", STEPS]
        opponent = opponent_of(context)
        options += ["--opponent", opponent] if opponent else []
        for play in context.program.about("simulate", *options, *reward)["plays"]:
            state = context.relation.one(key(play["state"]))
            if state in context.analysis.mdp.unsafe:
                continue
            path_of(context, choose, None, "progress", play, opponent)
            node, value = context.quantities.own(state), play["value"]
            able = [k for k, (table, _) in enumerate(tables, 1) if node in table and (choose == "cheap" or table[node])]
            context.same(
                f"{choose} aims of {play['state']}", max(able, default=0), value["improvements"] if value else 0
            )
            if able and value:
                probability = context.probabilities[max(able) - 1][0][node]
                context.within(f"{choose} probability of {play['state']}", probability, value["probability"])


def movers_of(context, play):
    """The players of a simulation."""
    expected = [(player["name"], player["ours"]) for player in players(context.analysis.whole, context.coalition)]
    context.same("players", expected, [(player["name"], player["ours"]) for player in play.get("players", ())])


def path_of(context, kind, objective, variant, play, opponent=None):
    """The trace is a path of the model that stays where requirements can be kept, and reports what happens."""
    analysis, relation, name = context.analysis, context.relation, key(play["state"])
    entries, trace = context.strategy("--kind", "sasi"), play["trace"]
    known = set() if kind in ("plan", "achieve") else None
    known = done_in(context, f"the start {dict(name)}", relation.one(name), trace.get("achieved", []), known)
    course = Course(context, kind, relation.one(name), relation.one(name), opponent)
    for number, turn in enumerate(trace["turns"], 1):
        where = f"step {number} from {dict(name)} by {turn['action']}"
        actions = {action["name"]: action for action in entries[name]["actions"]}
        action = actions.get(turn["action"], {"successors": []})
        if not context.same(where, True, key(turn["state"]) in [key(s["state"]) for s in action["successors"]]):
            return
        name = key(turn["state"])
        state = relation.one(name)
        context.same(f"safe after {where}", True, state not in analysis.mdp.unsafe)
        course.turn(where, variant, state, turn)
        known = done_in(context, where, state, turn.get("achieved", []), known)


class Course:
    """A path on its way. Without a value to choose by, SASI and SPI have the memory that shields have, too."""

    def __init__(self, context, kind, start, state, opponent):
        self.context, self.kind, self.start, self.state, self.committed = context, kind, start, state, False
        self.opponent = opponent
        self.levels = context.analysis.levels("spi" if kind in ("spi", "likely") else "sasi")
        self.machine = Machine(context.analysis, kind) if kind in ("sasi", "spi") else None
        self.memory = self.machine and self.machine.start(state)

    def turn(self, where, variant, to, turn):
        """Compares one step with its definition."""
        same, analysis = self.context.same, self.context.analysis
        old, new, first = (analysis.classes[s] for s in (self.state, to, self.start))
        same(f"most_preferred after {where}", self.context.named(new), turn["most_preferred"])
        same(f"rank after {where}", self.levels.rank(to), turn["rank"])
        same(f"lost by {where}", self.context.named(lost(analysis.preferences, old, new)), turn["lost"])
        self.committed |= "commits" in turn
        weakens = [not self.committed and analysis.preferences.weakens(c, new) for c in (old, first)]
        same(f"weakening of {where}", weakens, [turn["weakens_step"], turn["weakens_start"]])
        if self.machine or analysis.safety != "prefix":
            reference = self.machine.reference(self.state, self.memory) if self.machine else old
            same(f"change by {where}", analysis.preferences.change(reference, new), turn["change"])
            same(f"gained by {where}", self.context.named(gained(analysis.preferences, reference, new)), turn["gained"])
        theirs = self.state in analysis.whole.theirs
        same(f"owner of {where}", "opponent" if theirs else None, turn.get("owner"))
        if self.machine:
            permitted, progress = self.machine.permitted(self.state, self.memory)
            taken = permitted if variant == "permissive" else progress
            taken = self.machine.answers(self.state, self.memory, self.opponent == "worst") if theirs else taken
            same(f"permitted is {where}", True, turn["action"] in taken)
            same(f"improves by {where}", self.machine.counts(self.state, self.memory, to), turn["improves"])
            self.memory = self.machine.after(self.state, self.memory, to)
        self.state = to


def done_in(context, where, state, said, known):
    """Compares the objectives that are said to be achieved in a state, besides those that are known. Returns all;
    strategies that improve know none."""
    if known is None:
        context.same(f"achieved by {where}", [], said)
        return None
    analysis, every = context.analysis, range(len(context.names))
    least, most = ({i for i in every if achieved(analysis, i, state, strict)} - known for strict in (True, False))
    new = {context.names.index(name) for name in said}
    context.same(f"achieved by {where}", context.named(least | new & most), said)
    return known | new


def claims(analysis, objective, state):
    """Whether a report may call an objective achieved: it is, or, for a formula that no path decides, every path that
    follows satisfies it."""
    if achieved(analysis, objective, state, False):
        return True
    return analysis.play and not is_cosafe(analysis, objective) and state in certain(analysis, objective)


def is_cosafe(analysis, objective):
    return not any(part[0] == "W" for part in parts(analysis.formulas[objective]))


def certain(analysis, objective):
    known = analysis.__dict__.setdefault("certain", {})
    if objective not in known:
        known[objective] = satisfaction(analysis.product, analysis.mdp, analysis.formulas[objective])["pmin_one"]
    return known[objective]


def statistics_of(context, kind, objective, state, play):
    """Counts of many paths that a promise makes certain."""
    analysis, rank = context.analysis, play["rank"]
    levels = analysis.levels("spi" if kind == "spi" else "sasi")
    context.same("rank", levels.rank(state), rank)
    if analysis.safety == "transition":
        return
    if kind in ("sasi", "spi"):
        context.same("weakened_reference", 0, play["weakened_reference"])
        if analysis.safety == "action":
            context.same("weakened_step", 0, play["weakened_step"])
        else:
            context.same("weakened_start", 0, play["weakened_start"])
    # No gain is an objective that was sure at the start.
    names = {context.names[i] for i in range(len(context.names)) if state in analysis.sure[i]}
    gained = {gain["objective"] for gain in play["gained"]}
    context.same("gained, and sure at the start", set(), gained & names)
    if kind == "sasi" and rank != "unbounded" and not context.is_rare():
        context.same("fewer_than_rank", 0, play["fewer_than_rank"])
    decided = all(is_cosafe(analysis, i) for i in range(len(context.names)))
    if kind == "achieve":
        promised = state in analysis.sure[context.names.index(objective)]
    else:
        promised = kind == "plan" and (rank != 0 or bool(analysis.classes[state]))
    if promised and decided and not context.is_rare():
        context.same("achieved_runs", RUNS, play["achieved_runs"])


ALL = {"simulate": simulate, "chosen": chosen}
