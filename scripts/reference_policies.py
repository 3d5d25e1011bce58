"""Extreme probabilities and rewards by trying every memoryless policy: exact, and only for tiny models."""

import itertools
import math
from fractions import Fraction

from reference_values import Action, evaluate

MOST_POLICIES = 300


def policies(steps, target):
    """Every choice of one step per state outside the target; None if there are too many."""
    options = [[None] if s in target else choices for s, choices in enumerate(steps)]
    if math.prod(map(len, options)) > MOST_POLICIES:
        return None
    return list(itertools.product(*options))


def reaching(policy, target):
    """The probability to reach the target from each state under a policy."""
    actions = {}
    for s, step in enumerate(policy):
        if step is not None:
            constant = sum((p for t, p in step[2].items() if t in target), Fraction(0))
            actions[s] = Action(constant, [(p, t) for t, p in step[2].items() if t not in target], False)
    return {**dict.fromkeys(target, Fraction(1)), **evaluate(actions)}


def earning(policy, target):
    """The expected reward until the target under a policy; infinite where it is not reached surely."""
    sure = {s for s, p in reaching(policy, target).items() if p == 1}
    actions = {}
    for s in sure - target:
        _, cost, successors = policy[s]
        actions[s] = Action(Fraction(cost), [(p, t) for t, p in successors.items() if t not in target], False)
    values = {**dict.fromkeys(target, Fraction(0)), **evaluate(actions)}
    return {s: values.get(s, math.inf) for s in range(len(policy))}


def bounded(steps, target, bound, best):
    """The extreme probability to reach the target within a number of steps."""
    values = [Fraction(int(s in target)) for s in range(len(steps))]
    for _ in range(bound):
        values = [
            Fraction(1) if s in target else best(sum(p * values[t] for t, p in to.items()) for _, _, to in choices)
            for s, choices in enumerate(steps)
        ]
    return values


def extremes(steps, target, start):
    """The values of properties in a state, by the text of the property with T for the target; None if there are too
    many policies."""
    tried = policies(steps, target)
    if tried is None:
        return None
    reached = [reaching(policy, target)[start] for policy in tried]
    earned = [earning(policy, target)[start] for policy in tried]
    found = {
        "Pmax=? [ F T ]": max(reached),
        "Pmin=? [ F T ]": min(reached),
        "Pmax=? [ G !T ]": 1 - min(reached),
        "Pmin=? [ !T W false ]": 1 - max(reached),
        'R{"cost"}min=? [ F T ]': min(earned),
        'R{"cost"}max=? [ F T ]': max(earned),
    }
    for bound in (0, 3):
        for name, best in (("max", max), ("min", min)):
            found[f"P{name}=? [ F<={bound} T ]"] = bounded(steps, target, bound, best)[start]
            found[f"P{name}=? [ true U<={bound} T ]"] = bounded(steps, target, bound, best)[start]
    return found
