"""Everything that is computed about a model and preferences: outcomes, classes, levels, under requirements."""

import functools

from reference.improvement import Levels, arenas_of, bad_states
from reference.model import almost_sure, attractor, can_stay, explore, roots_of
from reference.preferences import target_of
from reference.prism import InputError
from reference.product import formulas_watched, product, satisfaction, secured
from reference.temporal import TRUE, conjunction, is_invariant, is_safe, parse


class Analysis:
    """`whole` is the model of the scope, with monitors under `history = play`; `mdp` its restriction to what keeps the
    requirements. `classes[s]` is MP(s), None for an unsafe state. In a game, some players are we, those of the
    preferences if no others are named."""

    def __init__(self, program, preferences, scope="reachable", safety="prefix", limit=None, coalition=()):
        self.program, self.preferences, self.scope, self.safety = program, preferences, scope, safety
        self.play = preferences.history == "play"
        required = [parse(text) for text in preferences.required]
        self.required = functools.reduce(conjunction, required, TRUE)
        if not is_safe(self.required):
            raise InputError("a requirement is not safe")
        # If all have the form `G p`, nothing remembers a violation.
        self.invariants = [f[1] for f in required] if all(map(is_invariant, required)) else None
        self.formulas = [parse(text) for _, text in preferences.objectives]
        self.product = None
        if self.play:
            watched = formulas_watched(self.formulas, program.players)
            watched += [self.required] if self.invariants is None and self.required not in watched else []
            self.product = product(program, roots_of(program, scope), watched, limit)
        whole = self.product.mdp if self.play else explore(program, scope, limit)
        ours = [program.named_players(names) for names in (preferences.coalition, coalition)]
        self.ours = ours[1] if coalition else ours[0]
        self.whole = whole.played_by(self.ours)
        self.violated = self.violations()
        safe = can_stay(self.whole.moves, set(self.whole.states) - self.violated)
        self.mdp = self.whole.restricted(safe)
        self.judge(safe)

    def violations(self):
        """The states after which no path satisfies the requirements."""
        if self.invariants is not None:
            everything = set(self.whole.states)
            holds = (self.whole.where(text) if sign else everything - self.whole.where(text)
                     for _, text, sign in self.invariants)  # fmt: skip
            return everything - everything.intersection(*holds)
        if not self.play:
            raise InputError("`history = state` allows only requirements `G condition`")
        return self.product.violated(self.required)

    def judge(self, safe):
        """Section 3: targets, outcomes and classes."""
        regions = list(self.regions(safe))
        self.targets, self.sure, self.positive = ([found[part] for found in regions] for part in range(3))
        self.outcomes = [{i for i, sure in enumerate(self.sure) if s in sure} for s in self.mdp.states]
        most = self.preferences.most_preferred
        self.classes = [None if s in self.mdp.unsafe else most(self.outcomes[s]) for s in self.mdp.states]

    def regions(self, safe):
        """For each objective, its target and the states from which it is achieved surely, and possibly."""
        if self.play and self.program.players:
            for formula in self.formulas:
                found = satisfaction(self.product, self.mdp, formula)
                yield found["pmax_one"], found["pmax_one"], found["pmax_positive"]
            return
        if self.play:
            targets = [secured(self.product, self.mdp, f) for f in self.formulas]
        else:
            conditions = [target_of(text) for _, text in self.preferences.objectives]
            if None in conditions:
                raise InputError("`history = state` allows only objectives `F condition`")
            targets = [self.whole.where(condition) & safe for condition in conditions]
        for target in targets:
            yield target, almost_sure(self.mdp.moves, target), attractor(self.mdp.moves, target)

    @functools.cached_property
    def arenas(self):
        return arenas_of(self.mdp, self.classes, self.preferences, self.safety)

    @functools.cached_property
    def bad(self):
        return bad_states(self.mdp, self.classes, self.preferences)

    def exposes(self, choice):
        """Whether the opponent may weaken after a choice."""
        return self.safety == "action" and not self.bad.isdisjoint(choice.to)

    def leaves(self, state, choice):
        """Whether a choice leaves the states of the arena of a state: under `prefix` those that never weaken its
        class."""
        if self.classes[state] is None or self.safety != "prefix":
            return False
        arena = self.arenas[self.classes[state]]
        return not all(arena.moves[to] for to in choice.to)

    # Bounded: the cache keeps the objects whose methods it remembers.
    @functools.lru_cache(maxsize=16)
    def levels(self, kind):
        return Levels(self.arenas, self.classes, kind)

    def distinct(self, states):
        """The states that reports count: of those between which no path decides, one."""
        return self.product.merged(states) if self.play else set(states)

    def kept(self, state):
        """The choices that the safety mode keeps when planning starts in a state, as (choice, nodes)."""
        if self.classes[state] is None:
            return []
        arena = self.arenas[self.classes[state]]
        return arena.moves[arena.node(state)]
