"""Policies of `verify`: what `reach --policy` writes, and lists of rules that are drawn and changed, against an evaluator."""

import random
from dataclasses import dataclass

from reference import planning, policies as of_rules
from reference.model import explore
from tester.jani import CONDITION
from tester.program import shown

MOST_STATES, DRAWN = 40, 3


@dataclass
class World:
    """A model state by state: `known` are the choices of each reachable state, `atoms_of` the atoms of each, and `every` those
    that drawn rules name."""

    starts: list
    goal: set
    known: dict
    atoms_of: dict
    every: list
    has_values: bool

    def steps(self, state):
        return self.known[state]

    def atoms(self, state):
        return self.atoms_of[state]

    def same(self, name, other):
        return name == other if self.has_values else plain(name) == plain(other)


def plain(name):
    """A name in PDDL, where capitals and blanks do not count."""
    return name.lower().replace(" ", "")


def policies(context):
    """The policies of a model with one player, for one of its conditions as the goal."""
    targets = CONDITION.findall(context.case.preferences_text())
    if context.is_game or context.is_rare() or not targets:
        return
    mdp = explore(context.source, "reachable", 3000)
    if len(mdp.values) > MOST_STATES:
        return
    target = random.Random(context.case.seed).choice(targets)
    atoms = {s: set(atoms_of(context.source.named(values))) for s, values in enumerate(mdp.values)}
    known = {s: [(c.name, c.successors) for c in own] for s, own in enumerate(mdp.choices)}
    every = sorted(set().union(*atoms.values()))
    world = World(mdp.initial, mdp.where(target), known, atoms, every, True)
    compare(context, world, [context.program.model], ["--target", context.program.text(target)])


def atoms_of(state):
    return [(name, shown(value)) for name, value in state.items()]


def compare(context, world, model, options):
    """Compares the verdicts of `verify` about written, drawn and changed policies."""
    draw, folder = random.Random(f"policy {context.case.seed}"), context.program.folder
    honest, exists = [], planned(world)
    for end in ("txt", "json"):
        file = folder / f"written.{end}"
        file.unlink(missing_ok=True)
        engine = context.program.settings("engine", "threads")
        context.program.ask("reach", *model, *options, "--policy", file, *engine, allowed=(0, 1))
        if context.same(f"a policy exists ({end})", exists is not None, file.exists()) and exists is not None:
            honest = of_rules.read(file.read_text(), world.has_values)
            judge(context, world, honest, (file, model, options), f"written policy ({end})")
    for _ in range(DRAWN):
        rules = list(draw.choice([honest, rules_of(world, exists or {}, draw), rules_of(world, {}, draw)]))
        for _ in range(draw.randrange(5)):
            change(world, rules, draw)
        file = folder / draw.choice(["drawn.txt", "drawn.json"])
        text = of_rules.written(rules, file.suffix == ".json")
        file.write_text(text)
        context.same("rules that are read again", rules, of_rules.read(text, world.has_values))
        strong = ["--strong"] * draw.randrange(2)
        context.case.features.add("a changed policy")
        judge(context, world, rules, (file, model, [*options, *strong]), f"policy {text!r}")


def judge(context, world, rules, asked, what):
    """Compares the verdict about one file."""
    file, model, options = asked
    expected = of_rules.is_plan(world, rules, "--strong" in options)
    context.case.features.add("an accepted policy" if expected else "a refused policy")
    status, out, errors = context.program.run("verify", file, *model, *options)
    context.same(f"verdict of the {what}", 0 if expected else 1, status if status in (0, 1) else (out + errors)[-500:])


def planned(world):
    """A choice for each state from which some strategy surely reaches the goal; None if there is none for a start."""
    known = {s: {at: frozenset(to) for at, (_, to) in enumerate(own)} for s, own in world.known.items()}
    sure = planning.strong_cyclic(known, world.goal)
    if not sure >= set(world.starts):
        return None
    chosen, near, more = {}, set(world.goal), True
    while more:
        more = {
            s: next((at for at, to in known[s].items() if to <= sure and to & near), None) for s in sure - near
        }
        more = {s: at for s, at in more.items() if at is not None}
        chosen, near = chosen | more, near | more.keys()
    return chosen


def rules_of(world, chosen, draw):
    """Rules for single states, of which not all name everything."""
    states = draw.sample(sorted(world.known, key=repr), len(world.known))
    return [rule(world, s, draw, draw.choice((1, 1, 0.7)), chosen.get(s)) for s in states if s not in world.goal]


def rule(world, state, draw, share, chosen=None):
    """A rule that holds in a state, with a share of its atoms, and perhaps without some of others."""
    holds = [(a, True) for a in world.every if a in world.atoms(state) and draw.random() < share]
    lacks = [(a, False) for a in world.every if a not in world.atoms(state) and draw.random() < (1 - share) / 2]
    steps = world.steps(state) or [("deadlock", {state})]
    at = draw.randrange(len(steps)) if chosen is None else chosen
    is_one_of_several = [name for name, _ in steps].count(steps[at][0]) > 1
    position = at if draw.random() < (0.8 if is_one_of_several else 0.1) else None
    return draw.sample(holds + lacks, len(holds + lacks)), steps[at][0], position


def change(world, rules, draw):
    """Changes a list of rules a little."""
    at, kind = draw.randrange(len(rules) + 1), draw.randrange(7)
    if at == len(rules) or kind == 0:
        state = draw.choice(sorted(world.known, key=repr))
        rules.insert(at, rule(world, state, draw, draw.choice((0, 0.5, 1))))
        return
    conditions, action, position = rules[at]
    if kind == 1:
        rules.insert(draw.randrange(len(rules)), rules.pop(at))
    elif kind == 2:
        rules[at] = [c for c in conditions if draw.random() < 0.7], action, position
    elif kind == 3 and conditions:
        atom, holds = draw.choice(conditions)
        rules[at] = [*conditions, (atom, not holds)], action, position
    elif kind == 4:
        other = draw.choice([action.upper(), action.capitalize(), action.replace("a", " a"), action + "#1"])
        rules[at] = conditions, other.strip() or action, position
    elif kind == 5:
        rules[at] = conditions, action, draw.choice((None, 0, 1, 2))
    else:
        rules.pop(at)


ALL = {"policies": policies}
