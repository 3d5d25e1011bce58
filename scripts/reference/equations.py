"""Least solutions of optimality equations, as exact fractions, by policy iteration."""

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
