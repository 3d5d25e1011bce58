"""Section 12: properties as expressions over states, evaluated bottom-up over explicit sets and fractions.

A property is a tuple. Conditions are `("is", text)`, `("not", c)`, `("and", c, d)`, `("or", c, d)`, `("=>", c, d)`,
`("<=>", c, d)`, `("compare", sign, n, m)`, `("bound", operator, sign, fraction)`, `("A", path)`, `("E", path)` and
`("filter", function, c, states)`. Numbers are `("number", fraction)`, `("+", n, m)`, `("-", n, m)`, `("*", n, m)`,
`("value", operator)` and `("filter", function, n, states)`. An operator is `("P", ours, optimum, path)` or
`("R", ours, optimum, structure, accumulated)` with `("F", c)`, `("C", steps)` or `("I", steps)`; `ours` are the players
of a game who choose, None if all choose together. Of a `dtmc`, `("S", None, optimum, c)` is the probability of c in the
long run, and rewards are accumulated by `("S", None)` and `("C", None)`, too. A path is `("X", c)` or `(name, least, most, c)` for F and G, and
`(name, least, most, c, d)` for U, W and R; `most` is None without a bound. `("ltl", text, c, d)` is a formula with the
places {0} and {1}.
"""

import itertools
import math
from fractions import Fraction

from reference.equations import Action, evaluate, solve
from reference.questions import Question, into, rewards

ZERO, ONE = Fraction(0), Fraction(1)
SIGNS = {
    "<=": lambda a, b: a <= b,
    "<": lambda a, b: a < b,
    ">=": lambda a, b: a >= b,
    ">": lambda a, b: a > b,
    "=": lambda a, b: a == b,
    "!=": lambda a, b: a != b,
}
MOST_STRATEGIES = 200
MOST_PAIRS = 3000


class TooLarge(Exception):
    """The opponent has too many strategies to try all."""


class Nested:
    """The values of properties in all states of an explicit model."""

    def __init__(self, mdp, scope="reachable"):
        self.mdp, self.all, self.scope = mdp, set(mdp.states), scope

    def holds(self, c):
        """The states that satisfy a condition."""
        kind = c[0]
        if kind == "is":
            return self.mdp.where(c[1])
        if kind == "not":
            return self.all - self.holds(c[1])
        if kind in ("and", "or", "=>", "<=>"):
            a, b = self.holds(c[1]), self.holds(c[2])
            return {
                "and": a & b,
                "or": a | b,
                "=>": (self.all - a) | b,
                "<=>": self.all - (a ^ b),
            }[kind]
        if kind == "compare":
            a, b = self.numbers(c[2]), self.numbers(c[3])
            return {s for s in self.all if SIGNS[c[1]](a[s], b[s])}
        if kind == "bound":
            values = self.operator(c[1])
            return {s for s in self.all if SIGNS[c[2]](values[s], c[3])}
        if kind in ("A", "E"):
            return self.on_paths(kind == "A", c[1])
        states, satisfied = self.holds(c[3]), self.holds(c[2])
        truth = states <= satisfied if c[1] == "forall" else bool(states & satisfied)
        return set(self.all) if truth else set()

    def numbers(self, n):
        """The value of a number in each state."""
        kind = n[0]
        if kind == "number":
            return dict.fromkeys(self.all, n[1])
        if kind == "value":
            return self.operator(n[1])
        if kind == "filter":
            return dict.fromkeys(self.all, self.filtered(n))
        a, b = self.numbers(n[1]), self.numbers(n[2])
        join = {"+": lambda x, y: x + y, "-": lambda x, y: x - y, "*": lambda x, y: x * y}[kind]
        return {s: join(a[s], b[s]) for s in self.all}

    def filtered(self, n):
        _, function, of, states = n
        chosen = self.holds(states)
        if function == "count":
            return Fraction(len(chosen & self.holds(of)))
        values = [self.numbers(of)[s] for s in chosen]
        if function == "sum":
            return sum(values, ZERO)
        return {"min": min, "max": max, "avg": lambda all_: sum(all_, ZERO) / len(all_)}[function](values)

    def operator(self, operator):
        kind, ours, optimum, *rest = operator
        if kind == "P":
            return self.probability(ours, optimum, rest[0])
        if kind == "S":
            inside = self.holds(rest[0])
            return self.average({s: Fraction(s in inside) for s in self.all})
        structure, accumulated = rest
        if accumulated == ("S", None):
            return self.average({s: self.mdp.choices[s][0].costs[structure] for s in self.all})
        if accumulated == ("C", None):
            return self.total({s: self.mdp.choices[s][0].costs[structure] for s in self.all})
        if accumulated[0] == "F":
            least, most = rewards(self.mdp, self.holds(accumulated[1]), structure)
            return most if optimum == "max" else least
        paid = structure if accumulated[0] == "C" else None
        earned = self.mdp.program.reward
        values = {s: ZERO if paid else earned(structure, self.mdp.plain(s), [None]) for s in self.all}
        for _ in range(accumulated[1]):
            values = self.back(ours, optimum, values, paid)
        return values

    def maximises(self, ours, optimum, state):
        if ours is None:
            return optimum == "max"
        owner = self.mdp.owners[state]
        return (owner is None or owner in ours) == (optimum == "max")

    def back(self, ours, optimum, values, structure=None):
        """One step back: the best expected value over the choices of each state."""

        def after(choice):
            paid = choice.costs[structure] if structure else ZERO
            return paid + sum((p * values[t] for t, p in choice.to.items()), ZERO)

        return {
            s: (max if self.maximises(ours, optimum, s) else min)(map(after, self.mdp.choices[s])) for s in self.all
        }

    def ends(self):
        """The bottom components of a chain, and the states that each state reaches."""
        steps = {s: set(self.mdp.choices[s][0].to) for s in self.all}
        reached = {}
        for s in self.all:
            reached[s], open_ = {s}, [s]
            while open_:
                new = steps[open_.pop()] - reached[s]
                reached[s] |= new
                open_ += new
        ends = {frozenset(own) for s, own in reached.items() if all(s in reached[t] for t in own)}
        return ends, reached

    def average(self, values):
        """The average of a value per step in the long run of a chain."""
        result = dict.fromkeys(self.all, ZERO)
        for end in self.ends()[0]:
            first, *others = sorted(end)
            weight = {s: self.mdp.choices[s][0].to for s in end}
            equations = {
                t: (weight[first].get(t, ZERO), {s: weight[s][t] for s in others if t in weight[s]}) for t in others
            }
            visits = {first: ONE, **solve(equations)}
            average = sum(visits[s] * values[s] for s in end) / sum(visits.values())
            for s, p in into(self.mdp, set(end), set()).items():
                result[s] += p * average
        return result

    def total(self, costs):
        """The expected sum of the costs of all steps of a chain."""
        ends, reached = self.ends()
        recurring = {s for end in ends for s in end if costs[s] > 0}
        finite = {s for s in self.all if not reached[s] & recurring}
        policy = {s: Action(costs[s], [(p, t) for t, p in self.mdp.choices[s][0].to.items()], False) for s in finite}
        return {**dict.fromkeys(self.all, math.inf), **evaluate(policy)}

    def temporal(self, ours, optimum, text, conditions):
        """The probability of a formula of linear temporal logic, by the monitors of its leaves."""
        names = [variable.name for variable in self.mdp.program.variables]

        def written(states):
            each = ("&".join(self.equation(n, v) for n, v in zip(names, self.mdp.plain(s))) for s in sorted(states))
            return f"({' | '.join(f'({one})' for one in each) or 'false'})"

        formula = text.format(*(f"({c[1]})" if c[0] == "is" else written(self.holds(c)) for c in conditions))
        if not self.mdp.program.players:
            question = Question(self.mdp.program, self.scope, formula, limit=MOST_PAIRS)
            return question.most() if optimum == "max" else question.least()
        coalition = frozenset(range(len(self.mdp.program.players))) if ours is None else ours
        question = Question(self.mdp.program, self.scope, formula, limit=MOST_PAIRS, coalition=coalition)
        return question.contested(f"p{optimum}")

    @staticmethod
    def equation(name, value):
        return f"{'' if value else '!'}{name}" if isinstance(value, bool) else f"{name}={value}"

    def probability(self, ours, optimum, path):
        if path[0] == "ltl":
            return self.temporal(ours, optimum, path[1], path[2:])
        other = {"max": "min", "min": "max"}[optimum]
        if path[0] in ("G", "W", "R"):
            return {s: 1 - p for s, p in self.probability(ours, other, self.negated(path)).items()}
        if path[0] == "X":
            target = self.holds(path[1])
            return self.back(ours, optimum, {s: Fraction(s in target) for s in self.all})
        left, right = (self.all, self.holds(path[3])) if path[0] == "F" else map(self.holds, path[3:])
        _, least, most = path[:3]
        if most is None:
            values = self.until(ours, optimum, left, right)
        else:
            values = {s: Fraction(s in right) for s in self.all}
        for _ in range(0 if most is None else most - least):
            before = self.back(ours, optimum, values)
            values = {s: ONE if s in right else before[s] if s in left else ZERO for s in self.all}
        for _ in range(least):
            before = self.back(ours, optimum, values)
            values = {s: before[s] if s in left else ZERO for s in self.all}
        return values

    def negated(self, path):
        """The until that violates a path formula."""
        name, least, most, *sides = path
        if name == "G":
            return ("F", least, most, ("not", sides[0]))
        a, b = sides
        if name == "W":
            return ("U", least, most, ("and", a, ("not", b)), ("and", ("not", a), ("not", b)))
        return ("U", least, most, ("not", a), ("not", b))

    def until(self, ours, optimum, left, right):
        """The extreme probability of an until: against each strategy of those who minimise, what the others achieve."""
        minimisers = [s for s in self.all if s in left - right and not self.maximises(ours, optimum, s)]
        options = [range(len(self.mdp.choices[s])) for s in minimisers]
        if math.prod(map(len, options)) > MOST_STRATEGIES:
            raise TooLarge
        best = None
        for picked in itertools.product(*options):
            fixed = dict(zip(minimisers, picked))
            choices = [
                [own[fixed[s]]] if s in fixed else own for s, own in enumerate(self.mdp.choices)
            ]
            found = into(Fixed(choices), right, self.all - left - right)
            best = found if best is None else {s: min(best[s], found[s]) for s in self.all}
        return best

    def on_paths(self, all_, path):
        """The states of which every path satisfies a formula, or some path does."""
        if path[0] in ("G", "W", "R"):
            return self.all - self.on_paths(not all_, self.negated(path))
        successors = [set().union(*(c.to for c in own)) for own in self.mdp.choices]

        def before(states):
            if all_:
                return {s for s in self.all if successors[s] <= states}
            return {s for s in self.all if successors[s] & states}

        if path[0] == "X":
            return before(self.holds(path[1]))
        left, right = (self.all, self.holds(path[3])) if path[0] == "F" else map(self.holds, path[3:])
        _, least, most = path[:3]
        found = set(right)
        for _ in range(len(self.all) if most is None else most - least):
            found = right | (left & before(found))
        for _ in range(least):
            found = left & before(found)
        return found


class Fixed:
    """A model in which some states have one choice left."""

    def __init__(self, choices):
        self.choices, self.states = choices, range(len(choices))
