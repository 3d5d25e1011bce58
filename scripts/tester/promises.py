"""What strategies promise: simulated paths, and the models that strategies induce."""

import csv
from dataclasses import dataclass, replace
from fractions import Fraction

from reference.model import Choice, Mdp, almost_sure, attractor
from reference.product import Product, satisfaction
from reference.reports import players
from reference.shields import Shield as Machine
from reference.strategies import achieved, gained, lost, pursued, pursuing, pursuit
from reference.temporal import parts
from tester.context import LEVELS
from tester.program import key

RUNS, STEPS = 20, 3000
OF_PURSUIT = ("pursues", "commits", "gives_up")


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
    report = context.program.about("simulate", *options)
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


def chosen(context):
    """Simulations that choose by value report the value that the reference computes."""
    for choose, kind, tables in (("likely", "spi", context.probabilities), ("cheap", "sasi", context.costs)):
        reward = context.program.settings("reward") if choose == "cheap" else []
        options = ["--kind", kind, "--choose", choose, "--levels", LEVELS, "--runs", RUNS, "--steps", STEPS]
        for play in context.program.about("simulate", *options, *reward)["plays"]:
            state = context.relation.one(key(play["state"]))
            if state in context.analysis.mdp.unsafe:
                continue
            path_of(context, choose, None, "progress", play)
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
    if kind == "sasi" and rank != "unbounded" and not context.is_rare():
        context.same("fewer_than_rank", 0, play["fewer_than_rank"])
    decided = all(is_cosafe(analysis, i) for i in range(len(context.names)))
    if kind == "achieve":
        promised = state in analysis.sure[context.names.index(objective)]
    else:
        promised = kind == "plan" and (rank != 0 or bool(analysis.classes[state]))
    if promised and decided and not context.is_rare():
        context.same("achieved_runs", RUNS, play["achieved_runs"])


def pursues(context):
    """The objective that a plan takes, with and without a name, and the actions of plans and of `achieve`."""
    number = context.case.seed % len(context.names)
    name = ("--objective", context.names[number])
    for named, options in ((None, ()), (number, name)):
        for at_state, state, entry in safe_entries(context, "--kind", "plan", *options):
            planned_at(context, named, at_state, state, entry)
    for at_state, state, entry in safe_entries(context, "--kind", "achieve", *name):
        taken = (number, None) if state in context.analysis.sure[number] else None
        pursues_at(context, taken, at_state, state, entry)


def safe_entries(context, *options):
    """What `strategy` says in each safe state, with the state of the reference."""
    for name, entry in context.strategy(*options).items():
        state = context.relation.one(name)
        if state not in context.analysis.mdp.unsafe:
            yield f"{options} in {dict(name)}", state, entry


def planned_at(context, named, where, state, entry):
    """A plan improves as SASI does, then takes an objective, and may commit to it."""
    analysis = context.analysis
    levels = analysis.levels("sasi")
    if levels.rank(state) != 0:
        for what in ("permitted", "progress"):
            expected = sorted(c.name for c in getattr(levels, what)(state))
            context.same(f"{what} of {where}", expected, sorted(a["name"] for a in entry["actions"] if a.get(what)))
        context.same(f"pursues of {where}", (None, False, []), tuple(map(entry.get, OF_PURSUIT)))
        return
    found = pursued(analysis, state, named)
    reference = analysis.classes[state] if found and not found[1] else None
    pursues_at(context, found and (found[0], reference), where, state, entry, bool(found and found[1]))


def pursues_at(context, taken, where, state, entry, commits=False):
    """The objective that is pursued, by all choices or by those that never weaken a class, and how."""
    analysis = context.analysis
    done = done_in(context, where, state, entry["achieved"], set())
    objective, reference = taken or (None, None)
    commits = commits and objective not in done
    if state in analysis.whole.theirs:
        expected = (taken and context.names[objective], commits)
        context.same(f"pursues of {where}", expected, tuple(map(entry.get, OF_PURSUIT[:2])))
        return
    taken_action = [a for a in entry["actions"] if a["name"] == entry["chosen_action"]]
    given_up = {name for a in taken_action for s in a["successors"] for name in s["lost"]} if commits else set()
    expected = (taken and context.names[objective], commits, [n for n in context.names if n in given_up])
    context.same(f"pursues of {where}", expected, tuple(map(entry.get, OF_PURSUIT)))
    if taken:
        actions_at(context, objective, pursuit(analysis, objective, reference), where, state, entry)
        if not analysis.play and state not in analysis.targets[objective]:
            choices = {choice.name: choice for choice in analysis.whole.choices[state]}
            verdicts = {name: pursuing(analysis, objective, reference, state, c) for name, c in choices.items()}
            context.same(f"verdicts of {where}", verdicts, {a["name"]: a["verdict"] for a in entry["actions"]})


def actions_at(context, objective, way, where, state, entry):
    """The permitted actions and those that make progress. The regions of a formula bring strategies of their own: these
    must stay where it is sure."""
    staying, closer = ([c.name for c in found] for found in (way.staying(state), way.closer(state)))
    permitted, progress = ([a["name"] for a in entry["actions"] if a[what]] for what in ("permitted", "progress"))
    if context.analysis.play:
        context.same(f"permitted stays sure of {where}", set(), set(permitted) - set(staying))
        done = claims(context.analysis, objective, state)
        context.same(f"an action achieves, {where}", True, done or entry["progress_action"] is not None)
        return
    context.same(f"permitted of {where}", sorted(staying), sorted(permitted))
    if state not in way.target:
        context.same(f"progress of {where}", sorted(closer), sorted(progress))


@dataclass
class Induced:
    """The model of a strategy: `of[s]` is the state of the reference, `facts[s]` its variables and labels."""

    mdp: Mdp
    of: list
    facts: list


def induced(context):
    """A strategy's model has steps of the model only, and keeps its promise."""
    kind, objective, variant = options_of(context)
    if not starts(context):
        return
    folder = context.program.folder / "induced"
    options = ["--format", "explicit", "--kind", kind, "--scheduler", variant, "--out", folder]
    options += ["--objective", objective] if objective else []
    context.program.about("export", *options)
    found = read_induced(context, folder / f"{kind}-{variant}")
    if found is None:
        return
    labels_of_the_model(context, kind, found)
    if not (context.is_game and variant == "permissive"):  # the only ones that are games again
        in_other_formats(context, f"{kind}-{variant}", options)
    if context.is_game and context.analysis.play:
        # Here the opponent's actions are drawn at random; the reference judges formulas of games in the worst case.
        return
    if kind in ("sasi", "spi"):
        improvements(context, kind, found)
    elif kind == "achieve":
        number = context.names.index(objective)
        wanted = [s for s in found.mdp.initial if found.of[s] in context.analysis.sure[number]]
        satisfied(context, found, wanted, [number])
    elif context.analysis.safety != "transition":
        ranked = context.analysis.levels("sasi")
        wanted = [
            s for s in found.mdp.initial if ranked.rank(found.of[s]) != 0 or context.analysis.classes[found.of[s]]
        ]
        satisfied(context, found, wanted, range(len(context.names)))


def labels_of_the_model(context, kind, found):
    """A strategy's model keeps the labels of the model; one with a name of its own has `_2` after it."""
    own = {"improved", "settled", *(("achieved", "committed") if kind in ("plan", "achieve") else ())}
    for name, condition in context.case.labels:
        holds, written = context.analysis.whole.where(condition), f"{name}_2" if name in own else name
        expected = {s for s in found.mdp.states if found.of[s] in holds}
        got = {s for s in found.mdp.states if written in found.facts[s]["labels"]}
        context.same(f"states with the label {written} of {kind}", expected, got)


def in_other_formats(context, stem, options):
    """The program reads a strategy's model back from each format, and finds the same regions and values."""
    program, folder = context.program, context.program.folder / "induced"
    first, *others = open(folder / f"{stem}.lab", encoding="utf-8").read().splitlines()
    names = dict(entry.replace('"', "").split("=") for entry in first.split())
    held = {names[number] for line in others for number in line.partition(":")[2].split()} - {"init", "deadlock"}
    properties = [f'{p} [ F "{name}" ]' for name in sorted(held)[:6] for p in ("P>=1", "Pmax=?", "Pmin=?")]
    asked = [word for text in properties for word in ("--property", text)]
    expected = program.ask("reach", folder / f"{stem}.tra", *asked, allowed=(0, 1))["properties"] if asked else []
    for written in ("drn", "umb") if asked else ():
        again = program.folder / f"induced-{written}"
        where = options.index("--out") + 1
        more = [*options[:where], again, *options[where + 1 :]]
        more[more.index("--format") + 1] = written
        program.about("export", *more)
        tables = [open(f / f"{stem}.csv", encoding="utf-8").read() for f in (folder, again)]
        context.same(f"table of actions of {written}", *tables)
        got = program.ask("reach", again / f"{stem}.{written}", *asked, allowed=(0, 1))["properties"]
        for text, old, new in zip(properties, expected, got):
            regions = [
                {k: v for k, v in entry.items() if k.startswith("p") and k != "property"} for entry in (old, new)
            ]
            context.same(f"regions of {text} of {written}", *regions)
            if old.get("value") and not context.is_rare():
                near = all(abs(old["value"][b] - new["value"][b]) <= 1e-5 for b in ("lower", "upper"))
                context.same(
                    f"value of {text} of {written}", "" if near else old["value"], "" if near else new["value"]
                )


def read_induced(context, stem):
    """Reads `.tra`, `.lab` and the table of actions, and walks through them together with the reference."""
    rows = list(csv.DictReader(open(f"{stem}.csv", encoding="utf-8")))
    lines = open(f"{stem}.lab", encoding="utf-8").read().splitlines()
    names = {entry.split("=")[0]: entry.split("=")[1].strip('"') for entry in lines[0].split()}
    for line in lines[1:]:
        number, _, own = line.partition(":")
        rows[int(number)]["labels"] = {names[n] for n in own.split()}
    lines, choices = open(f"{stem}.tra", encoding="utf-8").read().splitlines(), [{} for _ in rows]
    is_chain = len(lines[0].split()) == 2
    for state, *rest in (line.split() for line in lines[1:]):
        choice, to = (0, rest[0]) if is_chain else (int(rest[0]), rest[1])
        row = int(state.partition(":")[0])  # in games, the player follows
        name = rows[row]["actions"].split(" | ")[choice]
        choices[row].setdefault(name, set()).add(int(to))
    return walked(context, rows, choices)


def walked(context, rows, choices):
    """The pairs of a state of the strategy's model and a state of the reference that the same paths reach; None if a
    step is not one of the model."""
    whole, variables = context.analysis.whole, context.report["model"]["variables"]
    number, pairs, moves = {}, [], []

    def plain(row):
        return tuple(value_of(v, rows[row][v["name"]]) for v in variables[: context.relation.width])

    def numbered(pair):
        if pair not in number:
            number[pair] = len(pairs)
            pairs.append(pair)
        return number[pair]

    roots = [row for row, facts in enumerate(rows) if "init" in facts.get("labels", ())]
    fresh = {whole.plain(s): s for s in whole.initial}
    initial = [numbered((row, fresh[plain(row)])) for row in roots]
    for row, state in pairs:  # grows while we walk it
        known, to = {choice.name: choice for choice in whole.choices[state]}, set()
        for name, successors in choices[row].items():
            if name == "settled":
                to.add(number[row, state])
                continue
            expected = {whole.plain(t): t for t in known[name].to} if name in known else {}
            if not context.same(
                f"successors of {rows[row]} by {name}", expected.keys(), {plain(t) for t in successors}
            ):
                return None
            to |= {numbered((t, expected[plain(t)])) for t in successors}
        # Each permitted choice is taken again and again, at random.
        moves.append([Choice("any", dict.fromkeys(sorted(to), Fraction(1)), {})])
    mdp = Mdp(context.source, [None] * len(pairs), moves, initial, set())
    return Induced(mdp, [state for _, state in pairs], [{"labels": set(), **rows[row]} for row, _ in pairs])


def value_of(variable, text):
    if variable["type"] == "bool":
        return text == "true"
    number = int(text)
    return variable["values"][number - variable["low"]] if "values" in variable else number


def improvements(context, kind, found):
    """SASI makes its improvements almost surely, SPI with positive probability; no step weakens."""
    analysis, levels = context.analysis, context.analysis.levels(kind)
    safe = {s for s in found.mdp.states if found.of[s] not in analysis.mdp.unsafe}
    for start in safe.intersection(found.mdp.initial):
        context.same("unsafe states", set(), reached_from(found.mdp, start) - safe)
    if analysis.safety == "transition":
        return
    if analysis.safety == "action":
        for state in found.mdp.states:
            for to in found.mdp.choices[state][0].to:
                old, new = analysis.classes[found.of[state]], analysis.classes[found.of[to]]
                context.same("a step weakens", False, to != state and analysis.preferences.weakens(old, new))
    moves = found.mdp.moves
    for start in safe.intersection(found.mdp.initial):
        rank = levels.rank(found.of[start])
        goal = set(found.mdp.states)
        for _ in range(4 if rank == "unbounded" else min(rank, 4)):
            improving = {s for s in goal if "improved" in found.facts[s]["labels"]}
            before = almost_sure(moves, improving) if kind == "sasi" else attractor(moves, improving)
            goal = {s for s in found.mdp.states if any(m <= before if kind == "sasi" else m & before for m in moves[s])}
        context.same(f"{rank} improvements from {found.facts[start]}", True, start in goal)


def reached_from(mdp, start):
    found, todo = {start}, [start]
    while todo:
        new = {t for choice in mdp.choices[todo.pop()] for t in choice.to} - found
        found |= new
        todo += new
    return found


def satisfied(context, found, wanted, objectives):
    """From some states, almost every path satisfies one of some objectives, the one that it pursues."""
    analysis, won = context.analysis, set()
    for number in objectives:
        here = {s for s in found.mdp.states if found.facts[s]["pursued"] == str(number)}
        ended = {s for s in here if "settled" in found.facts[s]["labels"]}
        good = {s for s in ended if claims(analysis, number, found.of[s])}
        context.same("an objective is achieved where a path ends", set(), ended - good)
        if analysis.play:
            # Within the states that pursue the objective, the monitors' marks decide.
            going = [
                own if s in here - ended and own[0].successors <= here - ended else []
                for s, own in enumerate(found.mdp.choices)
            ]
            marks, accepted = (
                {g: {s for s in found.mdp.states if found.of[s] in m} for g, m in of.items()}
                for of in (analysis.product.marks, analysis.product.accepted)
            )
            inside = Product(replace(found.mdp, choices=going), analysis.product.monitors, marks, accepted)
            good |= satisfaction(inside, inside.mdp, analysis.formulas[number])["pmax_one"] - ended
        won |= good
    sure = almost_sure(found.mdp.moves, won)
    for state in wanted:
        context.same(f"achieves from {at_text(found, state)}", True, state in sure)


def at_text(found, state):
    return ", ".join(f"{k}={v}" for k, v in found.facts[state].items() if k not in ("labels", "state"))


ALL = {"simulate": simulate, "chosen": chosen, "pursue": pursues, "induced": induced}
