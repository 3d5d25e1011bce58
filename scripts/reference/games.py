"""Section 11: temporal objectives against an opponent.

What co-safe and safe parts of a formula say is settled sooner or later on each path. So with at most one other leaf, a
formula is a Büchi or a co-Büchi condition on states of the product. Several leaves of one kind are joined: a combination
of Pi2 formulas is one.
"""

import functools

from reference.leaves import conditions
from reference.model import Moves, almost_sure, attractor, can_stay
from reference.prism import InputError
from reference.temporal import conjunction, disjunction, is_cosafe, is_safe, negated


class LeftOut(Exception):
    """The program may answer a question that this reference does not."""


@functools.lru_cache(maxsize=1024)
def conditions_in_game(formula):
    """The same as `conditions`, with at most one leaf that is neither safe nor co-safe."""
    found = conditions(formula)
    others = {leaf for leaf in leaves_of(found) if not is_settled(leaf)}
    if len(others) < 2:
        return found
    if len({formula for _, formula in others}) < 2:
        raise LeftOut("marks of one monitor that are to recur, and to cease")
    kinds = {kind for kind, _ in others}
    if len(kinds) > 1:
        raise InputError("recurrence and persistence are combined")
    (kind,), whole = kinds, formula_of(found)
    return (kind, whole if kind == "again" else negated(whole))


def formula_of(condition):
    first, *rest = condition
    if first in ("and", "or"):
        return (conjunction if first == "and" else disjunction)(*map(formula_of, rest))
    return rest[0] if first == "again" else negated(rest[0])


def almost_surely(product, moves, region, formula):
    """The states of a region, which the opponent cannot leave, from which we satisfy a formula almost surely against
    every strategy."""
    kind, marks = limit(product, conditions_in_game(formula))
    if kind == "again":
        return recurring(moves, region, marks)
    # Where the opponent lets marks recur almost surely from nowhere, they cease almost surely everywhere.
    while True:
        against = inside(moves, region).exchanged()
        lost = recurring(against, region, marks)
        if not lost:
            return region
        region = region - attractor(against, lost)


def inside(moves, region):
    """The moves of a region that stay there."""
    return Moves(([m for m in own if m <= region] if s in region else [] for s, own in enumerate(moves)), moves.theirs)


def recurring(moves, region, marks):
    """nu Z. the states that almost surely reach marks from which Z is not left, without leaving Z."""
    while True:
        staying = can_stay(moves, region)
        smaller = almost_sure(moves, marks & staying, staying)
        if smaller == region:
            return region
        region = smaller


def limit(product, condition):
    """The condition ("again", X) or ("finally", X) that a combination of leaves is: X is visited again and again, or
    from some point on never."""
    others = {leaf for leaf in leaves_of(condition) if not is_settled(leaf)}
    without, with_it = (satisfying(product, condition, known) for known in (False, True))
    if not others:
        return "again", with_it
    ((kind, formula),) = others
    marks = product.marks[formula]
    if kind == "again":
        return "again", without | with_it & marks
    return "finally", (set(product.mdp.states) - with_it) | (marks - without)


def leaves_of(condition):
    if condition[0] in ("and", "or"):
        return leaves_of(condition[1]) | leaves_of(condition[2])
    return {condition}


def is_settled(leaf):
    return is_cosafe(leaf[1]) or is_safe(leaf[1])


def satisfying(product, condition, known):
    """The states where a combination of leaves is true, if those that are not settled have a given value."""
    if condition[0] in ("and", "or"):
        first, second = (satisfying(product, part, known) for part in condition[1:])
        return first & second if condition[0] == "and" else first | second
    kind, formula = condition
    everything = set(product.mdp.states)
    if not is_settled(condition):
        return everything if known else set()
    holds = product.accepted[formula] if is_cosafe(formula) else everything - product.violated(formula)
    return holds if kind == "again" else everything - holds
