"""Section 1 and 2: explicit models, and the regions of qualitative reachability.

States are numbers. A choice knows its name, what it costs and its successors with exact probabilities. Every region is
the textbook fixpoint over Python sets.
"""

import functools
from dataclasses import dataclass, replace
from fractions import Fraction


@dataclass(frozen=True)
class Choice:
    name: str
    to: dict  # successor -> probability
    costs: dict  # reward structure -> cost of a step

    @property
    def successors(self):
        return self.to.keys()


@dataclass(eq=False)
class Mdp:
    """`values[s]` is what tells s from other states, `choices[s]` its enabled choices."""

    program: object
    values: list
    choices: list
    initial: list
    deadlocks: set
    unsafe: frozenset = frozenset()  # where no strategy keeps the requirements: no choice is left

    @property
    def states(self):
        return range(len(self.values))

    @functools.cached_property
    def moves(self):
        return Moves([frozenset(choice.to) for choice in own] for own in self.choices)

    def where(self, condition):
        """The states that satisfy a condition, a text in the names of the program."""
        holds = self.program.compile(condition)
        return {s for s in self.states if holds(self.plain(s))}

    def plain(self, state):
        """The values of the variables of the program."""
        return self.values[state][: len(self.program.variables)]

    def restricted(self, safe):
        """Section 10: in the safe states the choices with all successors there, elsewhere none."""
        choices = [[c for c in own if s in safe and c.successors <= safe] for s, own in enumerate(self.choices)]
        return replace(self, choices=choices, unsafe=frozenset(self.states) - safe)


def roots_of(program, scope):
    """Where a scope is explored from: the initial states, or every valuation."""
    return [*program.initial_states(), *(program.all_states() if scope == "all" else ())]


@functools.lru_cache(maxsize=4)
def explore(program, scope="reachable", limit=None):
    """The MDP of a program."""
    costs = ["steps", *program.rewards]
    return explored(program, roots_of(program, scope), program.initial_states(), steps_of(program, costs), limit)


def steps_of(program, costs):
    """Returns the function of a state that lists `(name, costs, distribution)`; nothing for a deadlock."""

    def steps(values):
        return [
            (name, {cost: program.reward(cost, values, labels) for cost in costs}, to)
            for name, labels, to in program.choices(values)
        ]

    def steps_or_loop(values):
        found = steps(values)
        loop = ("deadlock", {cost: program.reward(cost, values, [None]) for cost in costs}, {values: Fraction(1)})
        return found or [loop], not found

    return steps_or_loop


def explored(program, roots, starts, steps, limit=None):
    """The MDP of everything that is reached from the roots."""
    number, values, choices, deadlocks = {}, [], [], set()

    def numbered(state):
        if state not in number:
            number[state] = len(values)
            values.append(state)
        return number[state]

    for root in roots:
        numbered(root)
    for state in values:  # grows while we walk it
        if limit and len(values) > limit:
            raise OverflowError(f"more than {limit} states")
        found, is_deadlock = steps(state)
        if is_deadlock:
            deadlocks.add(number[state])
        choices.append([Choice(name, {numbered(t): p for t, p in to.items()}, costs) for name, costs, to in found])
    return Mdp(program, values, choices, [number[s] for s in starts], deadlocks)


class Moves(list):
    """For each state the sets of successors of its choices, and the choices that enter it."""

    def __init__(self, moves):
        super().__init__(moves)
        self.sources = [[] for _ in self]
        for state, own in enumerate(self):
            for move in own:
                for successor in move:
                    self.sources[successor].append((state, move))


def layers(moves, target, within=None):
    """mu X. target | { s : a move meets X, and lies inside `within` }, with the round in which a state is found."""
    found, frontier = dict.fromkeys(target, 0), list(target)
    for state in frontier:  # grows while we walk it, round by round
        for source, move in moves.sources[state]:
            if source not in found and (within is None or move <= within):
                found[source] = found[state] + 1
                frontier.append(source)
    return found


def attractor(moves, target, within=None):
    return set(layers(moves, target, within))


def almost_sure(moves, target):
    """nu Y. mu X. target | { s : a move lies inside Y and meets X }"""
    region = set(range(len(moves)))
    while True:
        smaller = attractor(moves, target, region)
        if smaller == region:
            return region
        region = smaller


def can_stay(moves, region):
    """nu Z. region & { s : a move lies inside Z }"""
    while True:
        smaller = {s for s in region if any(move <= region for move in moves[s])}
        if smaller == region:
            return region
        region = smaller


def reachability(mdp, target):
    """Section 2: the four regions of a target. An unsafe state is in none of them."""
    everything, moves = set(mdp.states) - mdp.unsafe, mdp.moves
    target = target & everything
    avoid = can_stay(moves, everything - target)
    around = Moves([] if s in target else own for s, own in enumerate(moves))
    return {
        "pmax_one": almost_sure(moves, target),
        "pmax_positive": attractor(moves, target),
        "pmin_one": everything - attractor(around, avoid),
        "pmin_positive": everything - avoid,
    }
