"""Sections 2, 8 and 9: what `reach` asks of a formula, judged from each state of the scope on."""

import functools
import math
import re
from fractions import Fraction

from reference.equations import ONE, ZERO, Action, cheapest, greatest
from reference.games import LeftOut, almost_surely, conditions_in_game, leaves_of
from reference.model import almost_sure, can_stay, explore, reachability
from reference.prism import InputError
from reference.product import formulas_watched, product, satisfaction, secured
from reference.temporal import TRUE, conjunction, is_cosafe, is_safe, negated, parse, parts


class Question:
    """A formula from each state of the scope on, over the strategies that keep some requirements, in a game of some
    players."""

    def __init__(self, program, scope, text, required=(), limit=None, coalition=frozenset([0])):
        self.formula = parse(text)
        demanded = functools.reduce(conjunction, map(parse, required), TRUE)
        watched = formulas_watched([self.formula], program.players)
        watched += [demanded] if demanded not in (TRUE, *watched) else []
        self.whole = explore(program, scope, limit)
        self.product = product(program, self.whole.values, watched, limit)
        mdp, violated = self.product.mdp.played_by(coalition), set()
        if demanded != TRUE:
            violated = self.product.violated(demanded)
        self.mdp = mdp.restricted(can_stay(mdp.moves, set(mdp.states) - violated))
        self.fresh = list(self.whole.states)  # the roots of the product come first, in their order

    def regions(self):
        """The four regions, as sets of states of the scope."""
        found = satisfaction(self.product, self.mdp, self.formula)
        return {name: {s for s in self.whole.states if s in region} for name, region in found.items()}

    def contested(self, side):
        """The probability of the formula in each state of a game: the greatest ("pmax") or least ("pmin") that we can
        enforce. Only what a finite part of a path decides has one that is not 0 or 1 in all initial states."""
        found = satisfaction(self.product, self.mdp, self.formula)
        one, positive = found[f"{side}_one"], found[f"{side}_positive"]
        everything, theirs = set(self.mdp.states), set(self.mdp.theirs)
        maximising = everything - theirs if side == "pmax" else theirs
        kind = self.decided()
        if kind == "safe":
            # Who stays where nothing is decided satisfies a safe formula, so its violation is reached or not.
            least = contested(self.mdp, everything - positive, everything - one, everything - maximising)
            return {s: 1 - least[s] for s in self.whole.states}
        if kind == "co-safe":
            values = contested(self.mdp, one, positive, maximising)
            return {s: values[s] for s in self.whole.states}
        if not (set(self.whole.initial) <= one or positive.isdisjoint(self.whole.initial)):
            raise LeftOut("values of a formula that is neither safe nor co-safe")
        return {s: Fraction(s in one) for s in self.whole.states}

    def decided(self):
        """Whether all leaves of the formula are co-safe, or all others safe; None for a mixture."""
        leaves = [formula for _, formula in leaves_of(conditions_in_game(self.formula))]
        cosafe = [is_cosafe(formula) for formula in leaves]
        if all(cosafe):
            return "co-safe"
        return "safe" if not any(cosafe) and all(map(is_safe, leaves)) else None

    def unsafe(self):
        return {s for s in self.whole.states if s in self.mdp.unsafe}

    def most(self, formula=None):
        """The greatest probability of the formula in each state."""
        return into(self.mdp, secured(self.product, self.mdp, formula or self.formula), set())

    def least(self):
        """The least probability of the formula in each state."""
        return {state: 1 - p for state, p in self.most(negated(self.formula)).items()}


def deciding(whole, text):
    """The states that decide a formula, whatever comes later; None unless it is one operator over conditions on states.
    An upper bound on its steps decides nothing else."""
    formula = parse(re.sub(r"\b([FGU])<=\d+", r"\1", text))
    if formula[0] not in ("U", "W") or any(part[0] in ("X", "U", "W") for side in formula[1:] for part in parts(side)):
        return None
    left, right = (satisfying(whole, side) for side in formula[1:])
    return right | (set(whole.states) - left)


def satisfying(whole, formula):
    """The states that satisfy a formula without temporal operators."""
    kind = formula[0]
    if kind in ("true", "false"):
        return set(whole.states if kind == "true" else ())
    if kind == "is":
        found = whole.where(formula[1])
        return found if formula[2] else set(whole.states) - found
    one, other = (satisfying(whole, part) for part in formula[1:])
    return one & other if kind == "and" else one | other


def reached_until(whole, decided):
    """The states that paths reach if they do not leave those that decide a question."""
    found, open_ = set(whole.initial), list(whole.initial)
    while open_:
        state = open_.pop()
        if state not in decided:
            new = {to for choice in whole.choices[state] for to in choice.to} - found
            found |= new
            open_ += new
    return found


def chances(mdp, target):
    """The greatest and the least probability to reach a target from each state; unsafe states have none."""
    target = target - mdp.unsafe
    avoid = can_stay(mdp.moves, set(mdp.states) - mdp.unsafe - target)
    most, evade = into(mdp, target, set()), into(mdp, avoid, target)
    return most, {state: 1 - p for state, p in evade.items()}


def into(mdp, goal, lost):
    """The greatest probability to reach some states, and no others before."""
    actions = {}
    for state in set(mdp.states) - goal - lost:
        actions[state] = []
        for choice in mdp.choices[state]:
            constant = sum((p for t, p in choice.to.items() if t in goal), ZERO)
            edges = [(p, t) for t, p in choice.to.items() if t not in goal and t not in lost]
            actions[state].append(Action(constant, edges, False))
    return {**dict.fromkeys(goal, ONE), **dict.fromkeys(lost, ZERO), **greatest(actions)}


def contested(mdp, one, positive, maximising):
    """The probability to reach some states, those where it is 1, if it is as great as possible in some states, and as
    small as possible in the others. By strategies of the maximising side, changed where another choice is better: if
    none is, the values against the best answers solve all equations, and the least solution is not above them."""
    open_, zero = set(positive) - set(one), set(mdp.states) - set(positive) - set(one)
    picks = {s: 0 for s in open_ & maximising}
    while True:
        options = {s: [mdp.choices[s][picks[s]]] if s in picks else mdp.choices[s] for s in open_}
        avoid, shrinks = zero | open_, True
        while shrinks:
            lost = {s for s in avoid - zero if not any(set(c.to) <= avoid for c in options[s])}
            avoid, shrinks = avoid - lost, bool(lost)
        actions = {}
        for s in open_ - avoid:
            edges = [[(p, t) for t, p in c.to.items() if t in open_ - avoid] for c in options[s]]
            ends = [sum((p for t, p in c.to.items() if t in avoid), ZERO) for c in options[s]]
            actions[s] = [Action(end, own, False) for end, own in zip(ends, edges)]
        values = {**dict.fromkeys(one, ONE), **dict.fromkeys(avoid, ZERO)}
        values.update({s: 1 - p for s, p in greatest(actions).items()})
        changed = False
        for s in picks:
            found = [sum(p * values[t] for t, p in c.to.items()) for c in mdp.choices[s]]
            if max(found) > values[s]:
                picks[s], changed = found.index(max(found)), True
        if not changed:
            return values


def rewards(mdp, target, structure):
    """The least and the greatest expected reward until a target; infinite where it is not reached almost surely by some
    strategy, or not by every strategy."""
    regions = reachability(mdp, target)

    def within(region):
        """The choices that stay in a region, with their rewards, until the target."""
        return {
            state: [
                Action(
                    c.costs[structure],
                    [(p, t) for t, p in c.to.items() if t not in target],
                    bool(c.successors & target),
                )
                for c in mdp.choices[state]
                if c.successors <= region
            ]
            for state in region - target
        }

    least = {**dict.fromkeys(target, Fraction(0)), **cheapest(within(regions["pmax_one"]))}
    most = {**dict.fromkeys(target, Fraction(0)), **greatest(within(regions["pmin_one"]))}
    return [{s: found.get(s, math.inf) for s in mdp.states} for found in (least, most)]


def jointly(analysis, members):
    """Section 10: the states from which one strategy achieves all of some objectives in the same path almost surely;
    None in a game with several leaves that no path decides."""
    formulas = [analysis.formulas[i] for i in members]
    if analysis.program.players:
        return against_opponent(analysis, functools.reduce(conjunction, formulas))
    if analysis.play:
        reached = secured(analysis.product, analysis.mdp, *formulas)
        return almost_sure(analysis.mdp.moves, reached)
    watched = product(analysis.program, analysis.whole.values, formulas_watched(formulas))
    unsafe = {analysis.whole.values[s] for s in analysis.mdp.unsafe}
    mdp = watched.mdp.restricted({s for s in watched.mdp.states if watched.mdp.plain(s) not in unsafe})
    reached = almost_sure(mdp.moves, secured(watched, mdp, *formulas))
    return {s for s in analysis.whole.states if s in reached}  # the roots of the product come first, in their order


def against_opponent(analysis, formula):
    """The states from which we satisfy a formula almost surely; None if it has several leaves that no path decides."""
    watched, mdp = analysis.product, analysis.mdp
    try:
        needed = formulas_watched([formula], True)
    except (InputError, LeftOut):
        return None
    if not analysis.play:
        watched = product(analysis.program, analysis.whole.values, needed)
        unsafe = {analysis.whole.values[s] for s in mdp.unsafe}
        mdp = watched.mdp.played_by(analysis.ours)
        mdp = mdp.restricted({s for s in mdp.states if mdp.plain(s) not in unsafe})
    elif not {monitor.formula for monitor in watched.monitors} >= set(needed):
        return None
    found = almost_surely(watched, mdp.moves, set(mdp.states) - mdp.unsafe, formula)
    return {s for s in analysis.whole.states if s in found}  # the roots of the product come first, in their order
