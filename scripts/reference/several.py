"""Section 12: two objectives at once, over all pure strategies that remember which targets were visited.

An objective is `(kind, optimum, of, bound)`. Of the kind `F` it is the probability to visit the states `of`, of the kind
`G` that of staying in them, of the kind `R` the reward `(structure, target)` until the target, which may be None for all
steps. Strategies with chance attain the means of the points of pure ones. Best means under one bound consist of two.
"""

import itertools
import math
from fractions import Fraction

from reference.equations import Action, evaluate

ZERO, ONE = Fraction(0), Fraction(1)
MOST_STRATEGIES = 200


class TooLarge(Exception):
    """There are too many strategies to try all."""


class Infinite(Exception):
    """Some strategy has an infinite reward that is to be great."""


class Several:
    """Two objectives from one state of an mdp."""

    def __init__(self, mdp, objectives, start):
        self.mdp, self.objectives = mdp, objectives
        self.targets = [self.target(objective) for objective in objectives]
        self.start = (start, self.visited(start))
        self.choices = self.explored()
        if math.prod(map(len, self.choices.values())) > MOST_STRATEGIES:
            raise TooLarge
        self.points = [self.point(dict(zip(self.choices, picked))) for picked in itertools.product(*self.choices.values())]

    def target(self, objective):
        kind, _, of, _ = objective
        if kind == "R":
            return set() if of[1] is None else of[1]
        return of if kind == "F" else set(self.mdp.states) - of

    def visited(self, state, before=(False, False)):
        return tuple(known or state in target for known, target in zip(before, self.targets))

    def explored(self):
        """The choices of each state with the visited targets: the costs in each structure, and the successors."""
        found, open_ = {}, [self.start]
        while open_:
            pair = state, memory = open_.pop()
            if pair not in found:
                found[pair] = [
                    (choice.costs, {(to, self.visited(to, memory)): p for to, p in choice.to.items()})
                    for choice in self.mdp.choices[state]
                ]
                open_ += [to for _, after in found[pair] for to in after]
        return found

    def followed(self, nodes):
        """The values of both objectives if a strategy with memory is followed: each node is a state with actions, of which
        one is drawn; an action is a choice with the probabilities of the nodes after it."""
        start = (0, self.visited(nodes[0][0]))
        chain, open_ = {}, [start]
        while open_:
            pair = node, memory = open_.pop()
            if pair in chain:
                continue
            actions, costs, after = nodes[node][1], {}, {}
            for choice, to in actions:
                for structure, cost in choice.costs.items():
                    costs[structure] = costs.get(structure, ZERO) + cost / len(actions)
                for next_, p in to.items():
                    follower = (next_, self.visited(nodes[next_][0], memory))
                    after[follower] = after.get(follower, ZERO) + p / len(actions)
            chain[pair] = (costs, after)
            open_ += after
        return self.point(chain, start)

    def point(self, chain, start=None):
        """The values of both objectives in a chain, `math.inf` for infinite rewards."""
        start = self.start if start is None else start
        reached = {pair: self.reach(chain, pair) for pair in chain}
        ends = {pair for pair in chain if all(pair in reached[to] for to in reached[pair])}
        return [self.value(at, chain, start, reached, ends) for at in range(2)]

    @staticmethod
    def reach(chain, pair):
        found, open_ = {pair}, [pair]
        while open_:
            new = chain[open_.pop()][1].keys() - found
            found |= new
            open_ += new
        return found

    def value(self, at, chain, start, reached, ends):
        kind, _, of, _ = self.objectives[at]
        done = {pair for pair in chain if pair[1][at]}
        if kind != "R":
            likely = self.sums(chain, reached, done, {pair: ZERO for pair in chain}, ends)[start]
            return likely if kind == "F" else ONE - likely
        structure, target = of
        costs = {pair: ZERO if pair in done else chain[pair][0][structure] for pair in chain}
        unending = {pair for pair in ends if costs[pair] > 0 or (target is not None and pair not in done)}
        if reached[start] & unending:
            return math.inf
        return self.sums(chain, reached, set(), costs, ends)[start]

    def sums(self, chain, reached, counted, costs, ends):
        """The expected costs, and 1 for the first pair that is counted."""
        actions = {}
        for pair, (_, after) in chain.items():
            if pair in counted:
                actions[pair] = Action(ONE, [], False)
            elif pair in ends and not reached[pair] & counted:
                actions[pair] = Action(ZERO, [], False)
            else:
                actions[pair] = Action(costs[pair], [(p, to) for to, p in after.items()], False)
        return evaluate(actions)

    def sign(self, at):
        return 1 if self.objectives[at][1] == "max" else -1

    def finite(self, coordinates):
        """The points with finite costs, in which great values are good."""
        costs = [at for at in coordinates if self.sign(at) < 0]
        points = [point for point in self.points if all(point[at] < math.inf for at in costs)]
        if any(point[at] == math.inf for point in points for at in coordinates):
            raise Infinite
        return [[self.sign(at) * point[at] for at in coordinates] for point in points]

    def best(self):
        """The best value of the first objective under the bound of the second one; None if none satisfies it."""
        bound = self.sign(1) * self.objectives[1][3]
        points, found = self.finite((0, 1)), []
        for a, b in itertools.product(points, repeat=2):
            if a[1] >= bound:
                found.append(a[0])
                if b[1] < bound:
                    share = (bound - b[1]) / (a[1] - b[1])
                    found.append(share * a[0] + (1 - share) * b[0])
        if found:
            return self.sign(0) * max(found)
        is_cost = self.objectives[0][0] == "R" and self.sign(0) < 0
        return math.inf if is_cost and any(second >= bound for (second,) in self.finite((1,))) else None

    def achievable(self):
        """Whether one strategy satisfies both bounds."""
        best = self.best()
        if best is None or best == math.inf:
            return False
        return self.sign(0) * best >= self.sign(0) * self.objectives[0][3]
