"""Sections 5 and 10: what the strategies do in a state where planning starts."""

import functools
import itertools
from dataclasses import dataclass, replace

from reference.games import conditions_in_game
from reference.leaves import cases, conditions
from reference.model import Mdp, almost_sure, layers
from reference.product import secured


def gained(preferences, old, new):
    """The members of a class that are strictly preferred to one of another class; all that improve on nothing."""
    if not old and preferences.improves(old, new):
        return set(new)
    return {j for j in new if any((j, i) in preferences.strict for i in old)}


def lost(preferences, old, new):
    if not new and preferences.weakens(old, new):
        return set(old)
    return {i for i in old if any((i, j) in preferences.strict for j in new)}


def explain(analysis, kind, state):
    """For each choice of a state: what the strategies of SASI or SPI say when planning starts there. In a state of the
    opponent only what the choices lead to counts."""
    levels = analysis.levels(kind)
    known = analysis.classes[state] is not None
    game = levels.game(state) if known else None
    kept = {choice.name: nodes for choice, nodes in analysis.kept(state)}
    permitted = {choice.name for choice in levels.permitted(state)} if known else set()
    progress = {choice.name for choice in levels.progress(state)} if known else set()
    found = {}
    for choice in analysis.whole.choices[state]:
        goals = set()
        if game and choice.name in kept:
            goals = {t for t in choice.to if kept[choice.name] & game.goals & game.arena.entered(t)}
        found[choice.name] = {
            "kept": choice.name in kept,
            "permitted": choice.name in permitted,
            "progress": choice.name in progress,
            "leaves": analysis.leaves(state, choice),
            "successors": {t: successor(analysis, levels, state, t, p, t in goals) for t, p in choice.to.items()},
        }
        exposes = analysis.exposes(choice)
        answer = answered if state in analysis.whole.theirs else verdict
        found[choice.name]["verdict"] = answer(known, kind, game is None, exposes, found[choice.name])
    return found


def answered(known, kind, at_rest, exposes, choice):
    """The first of what a choice of the opponent leads to."""
    successors = choice["successors"].values()
    if any(s["unsafe"] for s in successors):
        return "violates"
    if any(s["change"] == "weakening" for s in successors):
        return "weakens"
    if exposes:
        return "exposes"
    if not choice["kept"] and choice["leaves"]:
        return "unsafe"
    improving = [s["change"] == "improving" for s in successors]
    return "improves" if all(improving) else "may-improve" if any(improving) else "lateral"


def verdict(known, kind, at_rest, exposes, choice):
    """The first reason that applies to a choice while improvements are ahead, and where none is."""
    successors = choice["successors"].values()
    if choice["permitted"]:
        goals = [s["goal"] for s in successors if not s["dropped"]]
        progress = "approaches" if choice["progress"] else "stays"
        return "improves" if all(goals) else "may-improve" if any(goals) else progress
    if not known or any(s["unsafe"] for s in successors):
        return "violates"
    if not choice["kept"]:
        weakens = any(s["change"] == "weakening" for s in successors)
        return "weakens" if weakens else "exposes" if exposes else "unsafe"
    return "nothing-ahead" if at_rest else "strays" if kind == "sasi" else "hopeless"


def pursuing(analysis, objective, reference, state, choice):
    """The same while an objective is pursued: by choices that never weaken a class, or by all."""
    way, classes = pursuit(analysis, objective, reference), analysis.classes
    if choice in way.staying(state):
        achieves = [t in way.target for t in choice.to]
        progress = "nears" if choice in way.closer(state) else "keeps"
        return "achieves" if all(achieves) else "may-achieve" if any(achieves) else progress
    if any(classes[t] is None for t in choice.to):
        return "violates"
    if reference is not None and choice not in way.mdp.choices[state]:
        weakens = any(analysis.preferences.weakens(reference, classes[t]) for t in choice.to)
        return "weakens" if weakens else "exposes" if analysis.exposes(choice) else "unsafe"
    return "forfeits"


def successor(analysis, levels, state, to, probability, goal):
    """What a report says about a successor. Unsafe states have no class and are compared with nothing."""
    preferences, old, new = analysis.preferences, analysis.classes[state], analysis.classes[to]
    compared = old is not None and new is not None
    change = preferences.change(old, new) if compared else "lateral"
    return {
        "probability": probability,
        "unsafe": new is None,
        "most_preferred": sorted(new or ()),
        "change": change,
        "gained": sorted(gained(preferences, old, new)) if compared else [],
        "lost": sorted(lost(preferences, old, new)) if compared else [],
        "rank": levels.rank(to),
        "dropped": analysis.safety == "transition" and change == "weakening",
        "goal": goal,
    }


@dataclass
class Pursuit:
    """How an objective is achieved: the choices that may be taken, F_i, and the states where they achieve it surely."""

    mdp: Mdp
    target: set
    sure: set

    def staying(self, state):
        """The choices of the permissive strategy."""
        return [c for c in self.mdp.choices[state] if c.successors <= self.sure] if state in self.sure else []

    def closer(self, state):
        """The choices of the permissive strategy that come closer to F_i."""
        distance = self.distances
        return [c for c in self.staying(state) if any(distance[t] < distance[state] for t in c.to)]

    @functools.cached_property
    def distances(self):
        return layers(self.mdp.moves, self.target, self.sure)


# Bounded: the cache keeps the analyses that it remembers.
@functools.lru_cache(maxsize=64)
def pursuit(analysis, objective, reference=None):
    """Section 10, achieve: by all choices or, for a plan that has not committed, by those that never weaken, compared
    with a class. Under `transition`, a kept choice may weaken by a dropped successor."""
    if reference is None:
        return Pursuit(analysis.mdp, analysis.targets[objective], analysis.sure[objective])
    arena = analysis.arenas[reference]
    choices = [[c for c, nodes in arena.moves[arena.node(s)] if len(nodes) == len(c.to)] for s in analysis.mdp.states]
    kept = replace(analysis.mdp, choices=choices)
    target = analysis.targets[objective]
    if analysis.play:
        target = secured(analysis.product, kept, analysis.formulas[objective])
    return Pursuit(kept, target, almost_sure(kept.moves, target))


def achieved(analysis, objective, state, every=True):
    """Whether an objective is achieved when a path has come to a state: the state is in F_i, or all words that continue
    the path satisfy the formula. They may be all words, or only those of letters that are possible."""
    if not analysis.play:
        return state in analysis.targets[objective]
    parts = conditions_in_game if analysis.program.players else conditions
    return state in achieving(analysis, parts(analysis.formulas[objective]), every)


@functools.lru_cache(maxsize=256)
def achieving(analysis, condition, every):
    """The states up to which a path shows that a Boolean combination of leaves is satisfied: no word that follows
    satisfies a case of the negation."""
    at, steps = joint(analysis, condition, every)
    refuting = set().union(*(repeated(steps, case) for case in cases(contrary(condition))))
    return {s for s in at if not refuting & followed(steps, at[s], lambda marks: True)}


def joint(analysis, condition, every):
    """The monitors of a combination of leaves side by side: what they know in each state, and for each joint state the
    joint states that follow, with the leaves that are marked. Letters are all, or those that are possible."""
    product, program = analysis.product, analysis.program
    leaves = {formula for case in cases(condition) for _, formula in case}
    places = [place for place, monitor in enumerate(product.monitors) if monitor.formula in leaves]
    watched = [product.monitors[place] for place in places]
    at = {s: tuple(product.read(s)[0][place] for place in places) for s in product.mdp.states}
    names = sorted({name for monitor in watched for name in monitor.atoms})
    values = itertools.product((False, True), repeat=len(names))
    if not every:
        values = {tuple(bool(program.compile(name)(s)) for name in names) for s in program.all_states()}
    letters, steps, todo = [dict(zip(names, signs)) for signs in values], {}, list(at.values())
    while todo:
        here = todo.pop()
        if here not in steps:
            read = [[m.read(s, m.letter(letter.get)) for m, s in zip(watched, here)] for letter in letters]
            steps[here] = {
                (tuple(s for s, _ in own), frozenset(m.formula for m, (_, marked) in zip(watched, own) if marked))
                for own in read
            }
            todo += [to for to, _ in steps[here]]
    return at, steps


def is_recurrence(analysis, condition):
    """Whether the words that satisfy a combination of leaves are those of some Pi2 formula: no cycle that satisfies it
    is a part of one that does not (Landweber)."""
    _, steps = joint(analysis, condition, False)
    for case in cases(contrary(condition)):
        off = {formula for kind, formula in case if kind == "finally"}
        for start in repeated(steps, case):
            around = {t for t in followed(steps, start, off.isdisjoint) if start in followed(steps, t, off.isdisjoint)}
            cycle = {s: {(t, m) for t, m in steps[s] if t in around and off.isdisjoint(m)} for s in around}
            if any(repeated(cycle, own) for own in cases(condition)):
                return False
    return True


def contrary(condition):
    """The negation of a combination of leaves."""
    if condition[0] in ("and", "or"):
        return ("or" if condition[0] == "and" else "and", *map(contrary, condition[1:]))
    return ("finally" if condition[0] == "again" else "again", condition[1])


def repeated(steps, case):
    """The joint states on cycles with all marks that a case wants again and again, and none that must cease."""
    again, off = ({formula for kind, formula in case if kind == wanted} for wanted in ("again", "finally"))
    after = {s: followed(steps, s, off.isdisjoint) for s in steps}
    found = set()
    for s, reached in after.items():
        cycle = {t for t in reached if s in after[t]}
        inside = [marks for t in cycle for to, marks in steps[t] if to in cycle and off.isdisjoint(marks)]
        if inside and again <= set().union(*inside):
            found |= cycle
    return found


def followed(steps, start, fits):
    """The joint states that steps with fitting marks lead to, with the first one."""
    found, todo = {start}, [start]
    while todo:
        new = {to for to, marks in steps[todo.pop()] if fits(marks)} - found
        found |= new
        todo += new
    return found


def pursued(analysis, state, named=None):
    """Section 10, commit: the objective that a plan takes at rank 0, and whether the plan commits; None without one."""
    here = analysis.classes[state] or frozenset()
    members = [named] if named in here else sorted(here)
    without = [i for i in members if state in pursuit(analysis, i, here).sure]
    return (without[0], False) if without else (members[0], True) if members else None
