"""The quantities of the reference: P_k, C_k, N and P_k^n as exact fractions, by policy iteration.

A node is a state, under `prefix` a pair of a class and a state.
"""

from dataclasses import dataclass
from fractions import Fraction

ZERO, ONE = Fraction(0), Fraction(1)


@dataclass
class Action:
    """An action of a node; what follows a successor with a known value is part of the constant."""

    constant: Fraction
    edges: list  # of (probability, node)
    ends: bool  # whether an improvement is counted with positive probability
    name: str = ""

    def value(self, values):
        return self.constant + sum(p * values[to] for p, to in self.edges)


@dataclass
class Move:
    """A kept choice of a state."""

    name: str
    cost: Fraction
    edges: list  # of (probability, state, whether the step improves), without what is lost
    loses: bool


def solve(equations):
    """The solution of x = constant + sum of p * x: a dictionary node -> (constant, {node: p})."""
    rows = {node: (constant, dict(edges)) for node, (constant, edges) in equations.items()}
    order = list(rows)
    for node in order:  # eliminate one node after the other
        constant, edges = rows[node]
        stay = ONE - edges.pop(node, 0)
        rows[node] = (constant / stay, {t: p / stay for t, p in edges.items()})
        for other in order:
            if other != node and node in rows[other][1]:
                theirs, weights = rows[other]
                weight = weights.pop(node)
                for target, p in rows[node][1].items():
                    weights[target] = weights.get(target, 0) + weight * p
                rows[other] = (theirs + weight * rows[node][0], weights)
    return {node: constant for node, (constant, _) in rows.items()}


def evaluate(policy):
    """The least solution of the equations of one policy; constants are at least 0."""
    earning, sources = [node for node, action in policy.items() if action.constant], {}
    for node, action in policy.items():
        for _, to in action.edges:
            sources.setdefault(to, []).append(node)
    found = set(earning)
    while earning:
        for node in sources.get(earning.pop(), []):
            if node not in found:
                found.add(node)
                earning.append(node)
    equations = {}
    for node in found:
        weights = {}
        for p, to in policy[node].edges:
            if to in found:
                weights[to] = weights.get(to, 0) + p
        equations[node] = (policy[node].constant, weights)
    return {**dict.fromkeys(policy, ZERO), **solve(equations)}


def improve(actions, policy, better):
    """Policy iteration: takes another action only where it is strictly better."""
    while True:
        values, changed = evaluate(policy), False
        for node, options in actions.items():
            best = values[node]
            for action in options:
                if better(action.value(values), best):
                    best, policy[node], changed = action.value(values), action, True
        if not changed:
            return values


def greatest(actions):
    """The least solution of x = max over actions; 0 for a node without actions."""
    policy = {node: (options or [Action(ZERO, [], False)])[0] for node, options in actions.items()}
    return improve(actions, policy, lambda a, b: a > b)


def cheapest(actions):
    """The least cost over the policies that end almost surely; there is one from every node."""
    policy, grows = {}, True
    while grows:
        grows = False
        for node, options in actions.items():
            for action in options:
                if node not in policy and (action.ends or any(to in policy for _, to in action.edges)):
                    policy[node], grows = action, True
    assert policy.keys() == actions.keys(), "P = 1, but no policy ends almost surely"
    return improve(actions, policy, lambda a, b: a < b)


class Quantities:
    """The quantities of one model under one safety mode, from SEMANTICS, section 9.

    `steps[s]` lists `(name, cost, {successor: probability})`; `classes[s]` is MP(s).
    """

    def __init__(self, steps, classes, order, safety):
        self.steps, self.classes, self.order, self.safety = steps, classes, order, safety
        self.prefix = safety == "prefix"
        self.moves = self.in_arenas() if self.prefix else {s: self.kept(s) for s in range(len(steps))}

    def kept(self, s):
        moves = []
        for name, cost, successors in self.steps[s]:
            lost = {t for t in successors if self.order.weakens(self.classes[s], self.classes[t])}
            if not lost or self.safety == "transition" and len(lost) < len(successors):
                left = {t: p for t, p in successors.items() if t not in lost}
                moves.append(self.move(name, cost, self.classes[s], left, bool(lost)))
        return moves

    def in_arenas(self):
        moves = {}
        for c in set(self.classes):
            safe, before = {s for s, d in enumerate(self.classes) if not self.order.weakens(c, d)}, None
            while safe != before:
                before, safe = safe, {s for s in safe if any(set(to) <= safe for _, _, to in self.steps[s])}
            for s in safe:
                staying = [step for step in self.steps[s] if set(step[2]) <= safe]
                moves[c, s] = [self.move(name, cost, c, to, False) for name, cost, to in staying]
        return moves

    def move(self, name, cost, reference, successors, loses):
        improves = self.order.improves
        edges = [(p, t, improves(reference, self.classes[t])) for t, p in successors.items()]
        return Move(name, Fraction(cost), edges, loses)

    def own(self, state):
        """The node of a state with which planning starts; it need not exist."""
        return (self.classes[state], state) if self.prefix else state

    def actions(self, counted, is_cost=False):
        """The actions of all nodes. `counted(state)` is the value of an improving step, or None if the
        improvement cannot be counted. Under `prefix` an improving step enters a node of its own, where
        the play may also go on in the old arena."""
        actions = {}
        for node, moves in self.moves.items():
            actions[node] = []
            for move in moves:
                if is_cost and move.loses:
                    continue
                action = Action(move.cost if is_cost else ZERO, [], False, move.name)
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
            before = greatest(actions)
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
            actions = {}
            for node, options in self.actions(counted, is_cost=True).items():
                if node in sure:
                    actions[node] = [a for a in options if all(to in sure for _, to in a.edges)]
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
        return greatest(actions)

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
        return max((sum(p * after(t, better) for p, t, better in m.edges) for m in moves), default=ZERO)
