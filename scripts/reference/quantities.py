"""Section 9: P_k, C_k, N and P_k^n as exact fractions.

A node is a state, under `prefix` a pair of the class of an arena and a state.
"""

from dataclasses import dataclass
from fractions import Fraction

from reference.equations import ONE, ZERO, Action, against, cheapest, cheapest_against, greatest


@dataclass
class Move:
    """A kept choice of a state."""

    name: str
    cost: Fraction
    edges: list  # of (probability, state, whether the step improves), without lost successors
    loses: bool


def attaining(actions, values, node):
    """The actions of a node with the best value, by their names; those of a junction by whether they count."""
    return {action.name or action.ends for action in actions[node] if action.value(values) == values[node]}


class Quantities:
    """The quantities of an analysis; a step costs what a reward structure says."""

    def __init__(self, analysis, reward="steps"):
        self.preferences, self.classes, self.reward = analysis.preferences, analysis.classes, reward
        self.prefix = analysis.safety == "prefix"
        self.moves, self.game = {}, analysis.mdp.theirs
        safe = [s for s in analysis.mdp.states if s not in analysis.mdp.unsafe]
        if self.prefix:
            for c, arena in analysis.arenas.items():
                nodes = {s: own for s, own in enumerate(arena.moves) if own}
                self.moves.update({(c, s): [self.move(choice, c) for choice, _ in own] for s, own in nodes.items()})
        else:
            self.moves = {s: [self.move(choice, self.classes[s]) for choice, _ in analysis.kept(s)] for s in safe}

    @property
    def theirs(self):
        """The nodes in which the opponent chooses; the nodes after improving steps are ours."""
        return {node for node in self.moves if (node[1] if self.prefix else node) in self.game}

    def most(self, actions):
        """The greatest values; against the opponent, if there is one."""
        return against(actions, self.theirs) if self.game else greatest(actions)

    def least(self, actions):
        return cheapest_against(actions, self.theirs) if self.game else cheapest(actions)

    def move(self, choice, reference):
        """A kept choice. Successors that weaken are lost; only `transition` keeps choices with any."""
        lost = {t for t in choice.to if self.preferences.weakens(reference, self.classes[t])}
        improves = self.preferences.improves
        edges = [(p, t, improves(reference, self.classes[t])) for t, p in choice.to.items() if t not in lost]
        return Move(choice.name, choice.costs[self.reward], edges, bool(lost))

    def own(self, state):
        """The node of a state with which planning starts; it need not exist."""
        return (self.classes[state], state) if self.prefix else state

    def actions(self, counted, is_cost=False, is_steps=False):
        """The actions of all nodes; each costs what the structure says, or 1 for steps. `counted(state)` is the value
        of an improving step, or None if the improvement cannot be counted. Under `prefix` an improving step enters a node of its own, where
        the play may also go on in the old arena."""
        actions = {}
        for node, moves in self.moves.items():
            actions[node] = []
            for move in moves:
                if is_cost and move.loses:
                    continue
                action = Action(move.cost if is_cost else ONE if is_steps else ZERO, [], move.loses, move.name)
                for p, state, improves in move.edges:
                    end = counted(state) if improves else None
                    to = (node[0], state) if self.prefix else state
                    if improves and self.prefix:
                        junction = ("junction", node[0], state)
                        actions[junction] = [Action(ZERO, [(ONE, to)], False)]
                        actions[junction] += [] if end is None else [Action(end, [], True)]
                        action.edges.append((p, junction))
                    elif end is None:
                        action.edges.append((p, to))
                    else:
                        action.constant, action.ends = action.constant + p * end, True
                actions[node].append(action)
        return actions

    def probabilities(self, levels):
        """[(P_k, its actions) for k = 1, 2, ...]"""
        found, before = [], None
        for _ in range(levels):
            below = before

            def counted(state):
                return ONE if below is None else below.get(self.own(state), ZERO)

            actions = self.actions(counted)
            before = self.most(actions)
            found.append((before, actions))
        return found

    def costs(self, probabilities):
        """[(C_k, its actions) for k = 1, 2, ...], on the nodes with P_k = 1."""
        found, before = [], None
        for values, _ in probabilities:
            below = before

            def counted(state):
                return ZERO if below is None else below.get(self.own(state))

            sure = {node for node, p in values.items() if p == 1}
            actions, others = {}, {}  # in other states, the opponent may let us be sure
            for node, options in self.actions(counted, is_cost=True).items():
                own = [a for a in options if all(to in sure for _, to in a.edges)]
                (actions if node in sure else others)[node] = own
            assert all(len(actions[node]) == len(self.moves[node]) for node in self.theirs & sure)
            before = self.least(actions)
            found.append((before, {**others, **actions}))
        return found

    def steps(self, probabilities, costs):
        """[(T_k, its actions) for k = 1, 2, ...]: the least expected number of steps until k improvements or until
        fewer are possible, by the choices that attain C_k where P_k = 1, and P_k elsewhere."""
        found, before = [], None
        for (chances, likely), (paid, cheap) in zip(probabilities, costs):
            below = before or {}
            tied = {node: attaining(likely, chances, node) for node, p in chances.items() if p}
            tied.update({node: attaining(cheap, paid, node) for node in paid})
            actions = {}
            for node, options in self.actions(lambda state: below.get(self.own(state), ZERO), is_steps=True).items():
                for action in options if node in tied else ():
                    if (action.name or action.ends) in tied[node]:
                        action.ends = action.ends or any(to not in tied for _, to in action.edges)
                        action.edges = [(p, to) for p, to in action.edges if to in tied]
                        actions.setdefault(node, []).append(action)
            before = cheapest(actions)
            found.append((before, actions))
        return found

    def numbers(self):
        """N: as P_k, with 1 + N on improving steps."""
        actions = self.actions(lambda state: None)
        for node, moves in self.moves.items():
            for move, action in zip(moves, actions[node]):
                if not self.prefix:
                    action.constant += sum(p for p, _, improves in move.edges if improves)
        for junction in [node for node in actions if self.prefix and node[0] == "junction"]:
            own = self.own(junction[2])
            actions[junction].append(Action(ONE, [(ONE, own)] if own in self.moves else [], True))
        return self.most(actions)

    def within(self, levels, steps):
        """[[P_k^0, P_k^1, ...] for k = 1, 2, ...], each a dictionary node -> fraction."""
        before, found = [None] * (steps + 1), []
        for _ in range(levels):
            curve = [dict.fromkeys(self.moves, ZERO)]
            for n in range(steps):
                curve.append({node: self.soonest(node, before[n], curve[n]) for node in self.moves})
            found.append(curve)
            before = curve
        return found

    def soonest(self, node, below, same):
        def after(state, improves):
            stay = same[(node[0], state) if self.prefix else state]
            if not improves:
                return stay
            end = ONE if below is None else below.get(self.own(state), ZERO)
            return max(end, stay) if self.prefix else end

        moves = self.moves[node]
        best = min if (node[1] if self.prefix else node) in self.game else max
        return best((sum(p * after(t, better) for p, t, better in m.edges) for m in moves), default=ZERO)
