"""Least solutions of optimality equations, as exact fractions, by policy iteration; those of games by strategy iteration."""

import math
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


def smallest(actions):
    """The least solution of x = min over actions; infinite where no policy ends, or rests, almost surely. A node without
    actions has the value 0."""
    rest = set(actions)  # where some policy gains nothing more
    while True:
        left = {n for n in rest if not actions[n] or any(is_free(a) and inside(a, rest) for a in actions[n])}
        if left == rest:
            break
        rest = left
    finite = set(actions)
    while True:
        found, grows = set(rest), True
        while grows:
            options = {n: [a for a in actions[n] if inside(a, finite)] for n in finite - found}
            new = {n for n, own in options.items() if any(leaves(a) or not outside(a, found) for a in own)}
            grows, found = bool(new), found | new
        if found == finite:
            break
        finite = found
    open_nodes = {
        n: [Action(a.constant, [(p, to) for p, to in a.edges if to not in rest], leaves(a) or not outside(a, rest), a.name)
            for a in actions[n] if inside(a, finite)]
        for n in finite - rest
    }
    return {**dict.fromkeys(actions, math.inf), **dict.fromkeys(rest, ZERO), **cheapest(open_nodes)}


def is_free(action):
    return not action.constant


def inside(action, nodes):
    return all(to in nodes for _, to in action.edges)


def outside(action, nodes):
    """Whether no successor of an action is among some nodes."""
    return all(to not in nodes for _, to in action.edges)


def leaves(action):
    """Whether a path may end with an action."""
    return sum(p for p, _ in action.edges) < 1


def against(actions, theirs):
    """The least solution of x = max over our actions, min over those of the opponent; infinite where it is."""
    ours = [node for node in actions if node not in theirs and actions[node]]
    policy = {node: actions[node][0] for node in ours}
    while True:
        values = smallest({node: [policy[node]] if node in policy else own for node, own in actions.items()})
        changed = False
        for node in ours:
            best = max(actions[node], key=lambda action: action.value(values))
            if best.value(values) > values[node]:
                policy[node], changed = best, True
        if not changed:
            return values


def cheapest_against(actions, theirs):
    """The least cost that we can guarantee over strategies that end almost surely; there is one from every node."""
    policy, known, grows = {}, set(), True
    while grows:
        grows = False
        for node, options in actions.items():
            closer = [a for a in options if a.ends or not outside(a, known)]
            if node not in known and closer and (node not in theirs or len(closer) == len(options)):
                known.add(node)
                policy[node], grows = closer[0], True
    assert known == actions.keys(), "P = 1, but no strategy ends almost surely"
    while True:
        values = greatest({node: own if node in theirs else [policy[node]] for node, own in actions.items()})
        changed = False
        for node, own in actions.items():
            best = min(own, key=lambda action: action.value(values))
            if node not in theirs and best.value(values) < values[node]:
                policy[node], changed = best, True
        if not changed:
            return values
