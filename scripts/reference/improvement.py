"""Sections 4 to 6 and 11: the improvement MDP, its levels, and the arenas of `prefix`."""

from dataclasses import dataclass

from reference.model import Moves, almost_sure, attractor, can_stay, layers

UNBOUNDED = "unbounded"


@dataclass
class Arena:
    """What a play under one reference may do. `moves[n]` lists (choice, nodes entered) of node n."""

    moves: list
    node: object  # function: the node of a state in which no step has improved
    goals: object  # function: the nodes that an improving step into one of some states enters
    entered: object  # function: the nodes that a step into a state can enter
    theirs: frozenset  # the nodes in which the opponent chooses

    def __post_init__(self):
        self.sets = Moves(([nodes for _, nodes in own] for own in self.moves), self.theirs)


def bad_states(mdp, classes, preferences):
    """mu B. { s of the opponent : some choice has a successor that weakens s or is in B }"""

    def is_bad(state, to):
        return to in bad or preferences.weakens(classes[state], classes[to])

    bad, before = set(), None
    while bad != before:
        before = bad
        bad = {s for s in mdp.theirs if any(is_bad(s, to) for choice in mdp.choices[s] for to in choice.to)}
    return bad


def improvement_mdp(mdp, classes, preferences, safety):
    """Section 4: V = S x {0,1}; the state (s, bit) is the node 2s + bit."""
    moves, bad = [], bad_states(mdp, classes, preferences)
    for state, own in enumerate(mdp.choices):
        kept = []
        for choice in own if state not in bad else ():
            here = classes[state]
            safe = {t for t in choice.to if t not in bad and not preferences.weakens(here, classes[t])}
            if safe == choice.successors or safe and safety == "transition":
                kept.append((choice, frozenset(2 * t + preferences.improves(here, classes[t]) for t in safe)))
        moves += [kept, kept]
    theirs = frozenset(2 * s + bit for s in mdp.theirs for bit in (0, 1))
    return Arena(
        moves, lambda s: 2 * s, lambda states: {2 * s + 1 for s in states}, lambda s: {2 * s, 2 * s + 1}, theirs
    )


def prefix_arena(mdp, classes, preferences, reference):
    """Section 6: the choices that stay in Safe_c, for a class c. A node is a state."""
    others = set(mdp.states) - mdp.unsafe
    better = {s for s in others if preferences.improves(reference, classes[s])}
    safe = can_stay(mdp.moves, {s for s in others if not preferences.weakens(reference, classes[s])})
    moves = [
        [(c, frozenset(c.to)) for c in own if s in safe and c.successors <= safe] for s, own in enumerate(mdp.choices)
    ]
    return Arena(moves, lambda s: s, lambda states: states & better & safe, lambda s: {s}, mdp.theirs)


def arenas_of(mdp, classes, preferences, safety):
    """The arena in which planning starts, for each class."""
    known = {c for c in classes if c is not None}
    if safety == "prefix":
        return {c: prefix_arena(mdp, classes, preferences, c) for c in known}
    return dict.fromkeys(known, improvement_mdp(mdp, classes, preferences, safety))


@dataclass
class Game:
    """A level in one arena: its goals, the nodes that win, and their layers."""

    arena: Arena
    kind: str
    goals: set
    won: set
    layers: dict

    def permitted(self, node):
        """The choices of the permissive strategy. The opponent's are neither permitted nor forbidden."""
        if node not in self.won or node in self.arena.theirs:
            return []
        fits = self.won.issuperset if self.kind == "sasi" else lambda nodes: not self.won.isdisjoint(nodes)
        return [choice for choice, nodes in self.arena.moves[node] if fits(nodes)]

    def progress(self, node):
        """The permitted choices that come one layer closer with positive probability."""
        permitted, here = self.permitted(node), self.layers.get(node, 0)
        closer = [c for c, nodes in self.arena.moves[node] if any(self.layers.get(v, here) < here for v in nodes)]
        return [choice for choice in closer if choice in permitted]


def game(arena, kind, goals):
    moves = arena.sets
    won = almost_sure(moves, goals) if kind == "sasi" else attractor(moves, goals)
    return Game(arena, kind, goals, won, layers(moves, goals, won if kind == "sasi" else None))


class Levels:
    """Section 5: `sets[k-1]` is W_k over S, up to the first that is empty or a fixpoint."""

    def __init__(self, arenas, classes, kind):
        self.arenas, self.classes = arenas, classes
        self.sets, self.games, self.fixpoint = [], [], set()
        goals = {s for s, c in enumerate(classes) if c is not None}
        while goals:
            games = {c: game(arena, kind, arena.goals(goals)) for c, arena in arenas.items()}
            won = {s for s in goals if self.node(s) in games[classes[s]].won}
            self.games.append(games)
            if won == goals and self.sets:
                self.fixpoint = won
                break
            goals = won
            if won:
                self.sets.append(won)

    def node(self, state):
        return self.arenas[self.classes[state]].node(state)

    def rank(self, state):
        return UNBOUNDED if state in self.fixpoint else sum(state in won for won in self.sets)

    def game(self, state):
        """The game of the level of a state; of the fixpoint where the rank is unbounded; None for rank 0."""
        rank = self.rank(state)
        if rank == 0:
            return None
        return self.games[len(self.sets) if rank == UNBOUNDED else rank - 1][self.classes[state]]

    def permitted(self, state):
        found = self.game(state)
        return found.permitted(self.node(state)) if found else []

    def progress(self, state):
        found = self.game(state)
        return found.progress(self.node(state)) if found else []
