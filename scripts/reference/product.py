"""Section 8: the product of a model with the monitors of formulas, and the regions of a formula in it."""

import functools
from dataclasses import dataclass, field

from reference.games import almost_surely, conditions_in_game
from reference.model import Moves, almost_sure, attractor, can_stay, explored, steps_of
from reference.leaves import cases, conditions
from reference.temporal import YES, Monitor, is_cosafe, negated


@dataclass(eq=False)
class Product:
    """The MDP of pairs of a state and the states of monitors, which have read the states before it.

    `marks[g]` are the states whose letter the monitor of g marks, `accepted[g]` those after which all words satisfy g.
    """

    mdp: object
    monitors: list
    marks: dict = field(default_factory=dict)
    accepted: dict = field(default_factory=dict)

    def merged(self, states):
        """Some states without those that differ only in states of monitors between which no path decides."""
        width, known = len(self.mdp.program.variables), [monitor.residuals() for monitor in self.monitors]
        found = {}
        for state in sorted(states):
            values = self.mdp.values[state]
            found.setdefault((*values[:width], *(told[own] for told, own in zip(known, values[width:]))), state)
        return set(found.values())

    def read(self, state):
        """The monitors' states and marks after a state."""
        return read(self.mdp.program, self.monitors, self.mdp.values[state])

    def violated(self, formula):
        """The states after which no word satisfies a safe formula."""
        place = [monitor.formula for monitor in self.monitors].index(formula)
        refuted = self.monitors[place].refuted()
        return {s for s in self.mdp.states if self.read(s)[0][place] in refuted}


def formulas_watched(formulas, in_game=False):
    """The Pi2 formulas whose monitors decide some formulas and their negations."""
    parts = conditions_in_game if in_game else conditions
    leaves = [leaf for f in formulas for g in (f, negated(f)) for case in cases(parts(g)) for _, leaf in case]
    return list(dict.fromkeys(leaves))


def product(program, roots, formulas, limit=None):
    """The product from fresh monitors on, from some states, initial states first."""
    monitors = [Monitor(f) for f in formulas]
    steps_or_loop, width = steps_of(program, ["steps", *program.rewards]), len(program.variables)

    def fresh(state):
        return (*state, *(monitor.start for monitor in monitors))

    def steps(state):
        then, _ = read(program, monitors, state)
        found, is_deadlock = steps_or_loop(state[:width])
        return [(name, costs, {(*t, *then): p for t, p in to.items()}) for name, costs, to in found], is_deadlock

    mdp = explored(program, map(fresh, roots), map(fresh, program.initial_states()), steps, limit)
    result = Product(mdp, monitors)
    result.marks, result.accepted = ({monitor.formula: set() for monitor in monitors} for _ in "ma")
    for state in mdp.states:
        for monitor, (must, _), marked in zip(monitors, *result.read(state)):
            if marked:
                result.marks[monitor.formula].add(state)
            if must == YES:
                result.accepted[monitor.formula].add(state)
    return result


def read(program, monitors, values):
    """The states of the monitors after they have read the state of a pair, and whether they mark it."""
    width = len(program.variables)
    plain, then = values[:width], []
    for monitor, state in zip(monitors, values[width:]):
        then.append(monitor.read(state, monitor.letter(lambda name: program.compile(name)(plain))))
    return tuple(state for state, _ in then), [marked for _, marked in then]


def secured(product, mdp, *formulas):
    """The union over the cases d of a conjunction of formulas of U_d: the greatest Z without the marks that must cease,
    from whose states some choices stay in Z surely and almost surely reach each mark that must recur."""
    moves, found = mdp.moves, set()
    parts = conditions_in_game if mdp.program.players else conditions
    for case in cases(functools.reduce(lambda a, b: ("and", a, b), map(parts, formulas))):
        ceasing = set().union(*(product.marks[g] for kind, g in case if kind == "finally"))
        recurring = [product.marks[g] for kind, g in case if kind == "again"]
        region, before = set(mdp.states) - ceasing - mdp.unsafe, None
        for kind, g in case:
            if kind == "again" and is_cosafe(g):
                region &= product.accepted[g]
        while region != before:
            before = region
            region = can_stay(moves, region)
            for marks in recurring:
                inside = Moves([m for m in own if m <= region] if s in region else [] for s, own in enumerate(moves))
                region = region & almost_sure(inside, marks & region)
        found |= region
    return found


def satisfaction(product, mdp, formula):
    """The four regions of a formula in the product. An unsafe state is in none of them."""
    moves, everything = mdp.moves, set(mdp.states) - mdp.unsafe
    if mdp.program.players:
        ours, theirs = (
            [almost_surely(product, side, everything, f) for f in (formula, negated(formula))]
            for side in (moves, moves.exchanged())
        )
        return {
            "pmax_one": ours[0],
            "pmax_positive": everything - theirs[1],
            "pmin_one": theirs[0],
            "pmin_positive": everything - ours[1],
        }
    against = secured(product, mdp, negated(formula))
    reached = secured(product, mdp, formula)
    return {
        "pmax_one": almost_sure(moves, reached),
        "pmax_positive": attractor(moves, reached),
        "pmin_one": everything - attractor(moves, against),
        "pmin_positive": everything - almost_sure(moves, against),
    }
