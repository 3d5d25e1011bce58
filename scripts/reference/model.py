"""Sections 1, 2 and 11: explicit models and games, and the regions of qualitative reachability.

States are numbers. A choice knows its name, what it costs and its successors with exact probabilities. Every region is
the textbook fixpoint over Python sets.
"""

import functools
import math
from dataclasses import dataclass, field, replace
from fractions import Fraction

from reference.prism import InputError


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
    owners: list = field(default_factory=list)  # of a game: the player of each state; None for deadlocks
    theirs: frozenset = frozenset()  # where the opponent chooses

    @property
    def states(self):
        return range(len(self.values))

    @functools.cached_property
    def moves(self):
        return Moves(([frozenset(choice.to) for choice in own] for own in self.choices), self.theirs)

    def played_by(self, coalition):
        """The same game, in which we are the players at some positions."""
        theirs = (s for s, owner in enumerate(self.owners) if owner is not None and owner not in coalition)
        return replace(self, theirs=frozenset(theirs))

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
    number, values, choices, owners, deadlocks = {}, [], [], [], set()

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
        if program.players:
            owners.append(owner_of(program, state))
    return Mdp(program, values, choices, [number[s] for s in starts], deadlocks, owners=owners)


def owner_of(program, state):
    """The player that chooses in a state; None in a deadlock."""
    plain = state[: len(program.variables)]
    movers = program.movers(plain)
    if len(movers) > 1:
        raise InputError(f"two players may move in {program.show(plain)}")
    if None in movers:
        raise InputError(f"several choices belong to no player in {program.show(plain)}")
    return next(iter(movers), None)


class Moves(list):
    """For each state the sets of successors of its choices, and the choices that enter it. In some states the opponent
    chooses among them."""

    def __init__(self, moves, theirs=frozenset()):
        super().__init__(moves)
        self.theirs = theirs
        self.sources = [[] for _ in self]
        for state, own in enumerate(self):
            for move in own:
                for successor in move:
                    self.sources[successor].append((state, move))

    def exchanged(self):
        """The moves of the opponent's game: who chose does not, and who did not chooses."""
        return Moves(self, frozenset(range(len(self))) - self.theirs)

    def enforced(self, state, is_good):
        """Whether a state of ours has a good move, or one of the opponent only good ones."""
        own = self[state]
        return bool(own) and all(map(is_good, own)) if state in self.theirs else any(map(is_good, own))


def layers(moves, target, within=None):
    """mu X. target | { s : a move meets X, and lies inside `within` }, with the round in which a state is found. In a
    state of the opponent every move must."""
    found, frontier = dict.fromkeys(target, 0), list(target)

    def is_good(move):
        return (within is None or move <= within) and any(found.get(t, math.inf) <= number for t in move)

    for state in frontier:  # grows while we walk it, round by round
        number = found[state]
        for source, move in moves.sources[state]:
            ours = source not in moves.theirs
            if source not in found and (is_good(move) if ours else moves.enforced(source, is_good)):
                found[source] = number + 1
                frontier.append(source)
    return found


def attractor(moves, target, within=None):
    return set(layers(moves, target, within))


def almost_sure(moves, target, within=None):
    """nu Y. mu X. target | { s : a move lies inside Y and meets X }; in a state of the opponent every move must."""
    region = set(range(len(moves))) if within is None else within
    while True:
        smaller = attractor(moves, target, region)
        if smaller == region:
            return region
        region = smaller


def can_stay(moves, region):
    """nu Z. region & { s : a move lies inside Z }; in a state of the opponent every move must."""
    while True:
        smaller = {s for s in region if moves.enforced(s, lambda move: move <= region)}
        if smaller == region:
            return region
        region = smaller


def reachability(mdp, target):
    """Sections 2 and 11: the four regions of a target, those of "every strategy" by the opponent, who chooses where we do
    not. An unsafe state is in none of them."""
    target, against = target - mdp.unsafe, mdp.moves.exchanged()
    return {
        "pmax_one": almost_sure(mdp.moves, target),
        "pmax_positive": attractor(mdp.moves, target),
        "pmin_one": almost_sure(against, target),
        "pmin_positive": attractor(against, target),
    }
