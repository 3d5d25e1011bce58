"""Regions of the Python package as sets and arrays, and what `reach` says in Python."""

import itertools
import math
import random

from reference.games import LeftOut
from reference.prism import InputError
from reference.questions import Question
from tester.program import key
from tester.dumps import regions_of

BETWEEN = {
    "&": set.__and__, "|": set.__or__, "-": set.__sub__, "^": set.__xor__,
    "<=": set.__le__, "<": set.__lt__, ">=": set.__ge__, ">": set.__gt__, "==": set.__eq__, "!=": set.__ne__,
}  # fmt: skip


class Sets:
    """The states of the program as the reference sees them: sets of names instead of regions."""

    def __init__(self, context, analysis):
        self.context, self.analysis = context, analysis
        self.every = set(context.relation.of)
        self.variables = analysis.to_dict()["model"]["variables"]

    def named(self, states):
        """The states of the program that stand for states of the reference."""
        return {name for name in self.every if self.context.relation.one(name) in states}

    def same(self, what, expected, region):
        """A region has exactly some states: listed, counted, iterated and by membership."""
        listed = [key(state) for state in region.states(len(self.every) + 1)]
        got = len(listed), set(listed), region.count(), bool(region), {n for n in self.every if dict(n) in region}
        size = len(expected)
        self.context.same(f"states of {what}", (size, expected, size, size > 0, expected), got)

    def array(self, what, expected, region):
        """The arrays of a region: over one variable, over two, and with the value of another one."""
        spans = [v for v in self.variables if v["type"] == "int"]
        pairs = [(None, spans[0]), *itertools.combinations(spans[:3], 2)]
        fixed = self.variables[-1]
        for row, column in pairs:
            axes = [v for v in (row, column) if v]
            for where in [{}] + ([{fixed["name"]: values_of(fixed)[-1]}] if fixed not in axes else []):
                inside = {n for n in expected if where.items() <= dict(n).items()}
                cells = {tuple(dict(n)[v["name"]] for v in axes) for n in inside}
                grid = [cell in cells for cell in itertools.product(*map(values_of, axes))]
                got = region.to_numpy(row and row["name"], column["name"], where or None)
                shape = tuple(len(values_of(v)) for v in axes)
                found = (shape, grid), (got.shape, got.ravel().tolist())
                self.context.same(f"array of {what} over {[v['name'] for v in axes]} with {where}", *found)


def values_of(variable):
    """The values of a variable from the smallest on."""
    if variable["type"] == "bool":
        return [False, True]
    return variable.get("values") or list(range(variable["low"], variable["high"] + 1))


def sets(context, analysis):
    """All regions of an analysis, and operators on some of them."""
    found, regions, draw = Sets(context, analysis), regions_of(context), random.Random(context.case.seed)
    of = {name: analysis.region(name) for name in analysis.region_names}
    space = analysis.exploration
    of.update({"reachable": space.states, "initial": space.initial, "deadlock": space.deadlocks})
    of.update({f"player:{name}": region for name, region in space.players.items()})
    expected = {name: found.named(states) for name, states in regions.items()}
    known = {name for name in of if name in expected or not name.startswith("target:")}
    context.same("names of regions", {n for n in expected if expected[n] or n in of}, known)
    for name in known & expected.keys():
        found.same(name, expected[name], of[name])
    known = sorted(known & expected.keys())
    for name in draw.sample(known, min(3, len(known))):
        found.array(name, expected[name], of[name])
        x = draw.randint(0, context.case.size)
        found.same(f"{name} where x is {x}", {n for n in expected[name] if dict(n)["x"] == x}, of[name].where(x=x))
        sample = [key(state) for state in of[name].sample(min(2, len(expected[name])), seed=context.case.seed)]
        context.same(f"sample of {name}", True, len(set(sample)) == len(sample) and set(sample) <= expected[name])
    for first, second in (draw.choices(known, k=2) for _ in range(4)):
        operators(found, (first, second), (expected[first], expected[second]), (of[first], of[second]))
    by_objective(context, found, expected)
    for kind in ("sasi", "spi"):
        ranked(found, kind, expected)


def operators(found, names, expected, regions):
    first, second = regions
    got = {
        "&": first & second, "|": first | second, "-": first - second, "^": first ^ second,
        "<=": first <= second, "<": first < second, ">=": first >= second, ">": first > second,
        "==": first == second, "!=": first != second,
    }  # fmt: skip
    for sign, operator in BETWEEN.items():
        what, value = f"{names[0]} {sign} {names[1]}", operator(*expected)
        if isinstance(value, bool):
            found.context.same(what, value, got[sign])
        else:
            found.same(what, value, got[sign])
    found.same(f"~{names[0]}", found.every - expected[0], ~first)


def by_objective(context, found, expected):
    """The regions of objectives and classes, by their names."""
    analysis = found.analysis
    for what, of in (
        ("target", analysis.target),
        ("almost-sure", analysis.almost_sure),
        ("positive", analysis.positive),
    ):
        context.same(f"objectives of {what}", context.names, list(of))
        for name in context.names:
            if f"{what}:{name}" in expected:
                found.same(f"{what} of {name}", expected[f"{what}:{name}"], of[name])
    classes = {tuple(entry["most_preferred"]): entry for entry in context.report["classes"]}
    context.same("classes", classes.keys(), analysis.classes.keys())
    for members, region in analysis.classes.items():
        found.same(f"class {members}", expected["class:" + ("+".join(members) or "nothing")], region)
    for name in found.every:
        own = tuple(context.named(context.analysis.classes[context.relation.one(name)]))
        context.same(f"most_preferred of {dict(name)}", own, analysis.most_preferred(dict(name)))


def ranked(found, kind, expected):
    """Levels: their regions, the rank of each state, and the array of ranks."""
    context, levels, reference = found.context, getattr(found.analysis, kind), found.context.analysis.levels(kind)
    sizes = [len(expected[f"{kind}:{k}"]) for k in range(1, len(reference.sets) + 1)]
    context.same(f"counts of {kind}", (sizes, True), (levels.counts, levels.complete))
    found.same(f"unbounded of {kind}", expected[f"{kind}:unbounded"], levels.unbounded)
    safe = {n for n in found.every if context.relation.one(n) not in context.analysis.mdp.unsafe}
    ranks = {n: number(reference.rank(context.relation.one(n))) if n in safe else None for n in found.every}
    got = {n: levels.rank(dict(n)) for n in found.every}
    context.same(f"ranks of {kind}", ranks, {n: None if math.isnan(rank) else rank for n, rank in got.items()})
    for k in range(len(sizes) + 1):
        found.same(f"at least {k} of {kind}", {n for n in safe if ranks[n] >= k}, levels.at_least(k))
        found.same(f"exactly {k} of {kind}", {n for n in safe if ranks[n] == k}, levels.exactly(k))
    greatest = [
        max((ranks[n] for n in safe if dict(n)["x"] == x), default=math.nan) for x in range(context.case.size + 1)
    ]
    context.same(f"array of ranks of {kind}", str(list(map(float, greatest))), str(levels.to_numpy(None, "x").tolist()))


def number(rank):
    return math.inf if rank == "unbounded" else rank


def together(context, analysis):
    """`jointly` is `check --jointly`."""
    report = context.program.about("check", "--jointly")
    expected = {
        tuple(entry["most_preferred"]): {tuple(j["objectives"]): int(j["states"]) for j in entry.get("jointly") or []}
        for entry in report["classes"]
    }
    got = analysis.jointly()
    sizes = {members: {names: region.count() for names, region in of.items()} for members, of in got.items()}
    context.same("jointly", expected, sizes)


def reach(context, meliora, model):
    """The regions of a formula, as text, as a property and as a set of states, against the reference."""
    case, text = context.case, context.preferences.objectives[context.case.seed % len(context.names)][1]
    names = ["scope", "engine", "threads"] + (["order"] if case.settings["engine"] == "symbolic" else [])
    space = model.explore(**{name: case.settings[name] for name in names})
    # The exploration of a model does not know what a preference file says.
    ours = context.source.named_players(list(filter(None, case.settings["coalition"].split(","))))
    try:
        question = Question(context.source, case.settings["scope"], text, (), 3000, ours)
        regions, starts = question.regions(), question.whole.initial
    except (InputError, LeftOut):
        return  # the opponent of the preferences makes the formula easier
    named = f"<<{','.join(sorted(context.case.players[at] for at in ours))}>> " if context.is_game else ""
    properties = IN_GAMES if context.is_game else PROPERTIES
    holds = {f"{named}{p} [ {text} ]": set(starts) <= regions[name] for p, name in properties.items()}
    for asked, expected in {text: None, **holds}.items():
        found = space.reach(asked)
        context.same(f"holds of {asked}", expected, found.holds)
        for name, region in regions.items():
            states = {key(context.source.named(question.whole.plain(s))) for s in region}
            got = [key(state)[: len(context.source.variables)] for state in getattr(found, name).states(4000)]
            context.same(f"{name} of {asked}", (len(states), states), (len(got), set(got)))
    condition = f"x>={case.size // 2}"
    region = space.where(condition)
    states = {key(context.source.named(question.whole.plain(s))) for s in question.whole.where(condition)}
    context.same(f"states where {condition}", states, {key(state) for state in region.states(4000)})
    for name in regions:
        given = [getattr(space.reach(target), name) for target in (region, condition, f"F {condition}")]
        context.same(f"{name} of a region and of its condition", [True] * 2, [given[0] == other for other in given[1:]])


IN_GAMES = {"P>=1": "pmax_one", "P>0": "pmax_positive"}
PROPERTIES = {"P>=1": "pmin_one", "Pmax>=1": "pmax_one", "P>0": "pmin_positive", "Pmax>0": "pmax_positive"}
