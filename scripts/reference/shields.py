"""What a shield permits in every state with memory: the labels of choices, and whether the promise holds."""

import math
from dataclasses import dataclass

from reference.improvement import UNBOUNDED


@dataclass(frozen=True)
class Memory:
    level: object  # the number of improvements ahead
    reference: object  # the class that steps are compared with; None for the class of the state before


@dataclass(frozen=True)
class Label:
    """The choices of a node with one label."""

    permitted: bool  # whether the strategy permits all of them
    progress: bool  # whether each of them makes progress
    keeps: bool  # whether no successor is unsafe
    to: frozenset  # their successors


class Shield:
    """The strategy of SASI or SPI as a machine with memory. At level 0 it permits what the safety mode keeps."""

    def __init__(self, analysis, kind):
        self.analysis, self.levels, self.classes = analysis, analysis.levels(kind), analysis.classes
        safe = {}  # Safe_c, for the classes with a state there
        if analysis.safety == "prefix":
            for c, arena in analysis.arenas.items():
                states = {s for s in analysis.mdp.states if arena.moves[s]}
                if any(self.classes[s] == c for s in states):
                    safe[c] = states
        self.safe = safe

    def start(self, state):
        here = self.classes[state]
        return Memory(self.levels.rank(state) if here is not None else 0, here if here in self.safe else None)

    def reference(self, state, memory):
        return self.classes[state] if memory.reference is None else memory.reference

    def after(self, state, memory, to):
        """The memory after a step."""
        compared, improves, game = self.compared(state, memory, to)
        reference = self.reference(state, memory)
        if game is None:
            keeps = compared and not improves and to in self.safe.get(memory.reference, ())
            return self.resumed(reference, to) if keeps else self.start(to)
        if self.counts(state, memory, to):
            return self.start(to)
        stays = game.arena.node(to) in game.won
        return memory if stays else self.resumed(reference, to) if compared else self.start(to)

    def compared(self, state, memory, to):
        """Whether a step is compared at all, whether it improves, and the game of the level. Steps from and to unsafe
        states are compared with nothing."""
        compared = self.classes[state] is not None and self.classes[to] is not None
        change = compared and self.analysis.preferences.change(self.reference(state, memory), self.classes[to])
        return compared, change == "improving", self.game(state, memory)

    def counts(self, state, memory, to):
        """Whether a step is an improvement of the path: into the goal of the level, or out of what wins it."""
        _, improves, game = self.compared(state, memory, to)
        stays = game and game.arena.node(to) in game.won
        return bool(game and improves and (not stays or not game.goals.isdisjoint(game.arena.goals({to}))))

    def resumed(self, reference, state):
        """The greatest level that still contains a state, with the old reference."""
        won = [games[reference].arena.node(state) in games[reference].won for games in self.levels.games]
        depth = len(self.levels.sets)
        level = UNBOUNDED if self.levels.fixpoint and won[depth] else sum(won[:depth])
        return Memory(level, reference if reference in self.safe else None)

    def game(self, state, memory):
        if memory.level == 0 or self.classes[state] is None:
            return None
        place = len(self.levels.sets) if memory.level == UNBOUNDED else memory.level - 1
        return self.levels.games[place][self.reference(state, memory)]

    def labels(self, state, memory):
        """The labels of a node by name. In a state of the opponent all are permitted, and none makes progress."""
        found = {}
        for name, facts in self.facts(state, memory).items():
            found.setdefault(name.split("(")[0], []).append(facts)
        return {
            name: Label(*(all(facts[n] for facts in own) for n in range(3)), frozenset().union(*(f[3] for f in own)))
            for name, own in found.items()
        }

    def facts(self, state, memory):
        """The facts about each choice: permitted, makes progress, keeps the requirements; and its successors."""
        permitted, progress = self.permitted(state, memory)
        if state in self.analysis.whole.theirs:
            permitted, progress = {choice.name for choice in self.analysis.whole.choices[state]}, set()
        return {
            c.name: (c.name in permitted, c.name in progress, all(self.classes[t] is not None for t in c.to), set(c.to))
            for c in self.analysis.whole.choices[state]
        }

    def is_told_apart(self, state, memory):
        """Whether labels suffice: where some choice is permitted, makes progress or, if none is permitted in a safe
        state, keeps the requirements, all choices of some label do."""
        if state in self.analysis.whole.theirs:
            return True
        choices, labels = self.facts(state, memory).values(), self.labels(state, memory).values()
        needed = [0, 1] + [2] * (self.classes[state] is not None and not any(facts[0] for facts in choices))
        fits = [label.permitted for label in labels], [label.progress for label in labels], [l.keeps for l in labels]
        return all(any(fits[n]) or not any(facts[n] for facts in choices) for n in needed)

    def is_separable(self):
        """Whether labels suffice in every state with memory that some path reaches."""
        todo = [(state, self.start(state)) for state in self.analysis.mdp.states]
        known = set(todo)
        for state, memory in todo:  # grows while we walk it
            if not self.is_told_apart(state, memory):
                return False
            after = {(to, self.after(state, memory, to)) for c in self.analysis.whole.choices[state] for to in c.to}
            todo += after - known
            known |= after
        return True

    def permitted(self, state, memory):
        """The names of the permitted choices, and of those that make progress."""
        if self.classes[state] is None:
            return set(), set()
        game, arena = self.game(state, memory), self.analysis.arenas[self.reference(state, memory)]
        node = arena.node(state)
        if game is None:
            return {choice.name for choice, _ in arena.moves[node]}, set()
        return ({c.name for c in found} for found in (game.permitted(node), game.progress(node)))

    def answers(self, state, memory, worst):
        """The names of the choices of the opponent: all, or the first of those whose nearest successor is the farthest
        from the goal of the level."""
        choices, game = self.analysis.whole.choices[state], self.game(state, memory)
        if game is None or not worst:
            return {choice.name for choice in choices}
        improves = self.analysis.preferences.improves
        reference = self.reference(state, memory)

        def distance(choice):
            arena = game.arena
            nodes = set()
            for to in choice.to:
                counted = arena.goals({to}) if improves(reference, self.classes[to]) else set()
                nodes |= counted or {arena.node(to)}
            return min(game.layers.get(node, math.inf) for node in nodes)

        return {max(choices, key=distance).name}

    def keeps(self, state, memory, to, then):
        """Whether a step keeps the promise: it weakens nothing, and changes the reference of `prefix` by an improvement
        only."""
        if self.classes[to] is None or self.classes[state] is None:
            return False
        change = self.analysis.preferences.change(self.reference(state, memory), self.classes[to])
        same = self.analysis.safety == "action" or self.reference(to, then) == self.reference(state, memory)
        return change == "improving" or change == "lateral" and same
