"""Planning problems in PDDL by their definitions: states are sets of facts, actions are instantiated in each state."""

import itertools
import math
import re
from fractions import Fraction


def nodes_of(text):
    """Parses S-expressions into lists and words in small letters."""
    words = re.findall(r"[()]|[^\s()]+", re.sub(r";[^\n]*", "", text).lower())
    stack = [[]]
    for word in words:
        if word == "(":
            stack.append([])
        elif word == ")":
            done = stack.pop()
            stack[-1].append(done)
        else:
            stack[-1].append(word)
    return stack[0]


def typed(words):
    """Splits `a b - t c` into pairs of a name and its types."""
    pairs, open_names, rest = [], [], list(words)
    while rest:
        word = rest.pop(0)
        if word == "-":
            of = rest.pop(0)
            pairs += [(name, of[1:] if isinstance(of, list) else [of]) for name in open_names]
            open_names = []
        else:
            open_names.append(word)
    return pairs + [(name, ["object"]) for name in open_names]


class Problem:
    """A domain and a problem. A fact is a tuple of a predicate and objects."""

    def __init__(self, text):
        sections = [part for define in nodes_of(text) for part in define[2:]]
        self.sections = {}
        for name, *parts in sections:
            self.sections.setdefault(name, []).append(parts)
        joined = lambda *names: [word for name in names for parts in self.sections.get(name, []) for word in parts]
        self.above = {name: upper for name, upper in typed(joined(":types"))}
        self.objects = typed(joined(":constants", ":objects"))
        self.initial = frozenset(tuple(fact) for fact in joined(":init"))
        self.rules = self.sections.get(":derived", [])
        goal = self.sections[":goal"][0][0]
        parts = goal[1:] if goal and goal[0] == "and" else [goal]
        self.preferences = {part[1]: part[2] for part in parts if part and part[0] == "preference"}
        self.goal = ["and", *(part for part in parts if not part or part[0] != "preference")]
        self.actions = [self.action(parts) for parts in self.sections.get(":action", [])]

    def action(self, parts):
        keys = dict(zip(parts[1::2], parts[2::2]))
        return parts[0], typed(keys.get(":parameters", [])), keys.get(":precondition", ["and"]), keys[":effect"]

    def members(self, types):
        """The objects that have one of some types."""

        def below(own):
            return "object" in types or any(t in types or below(self.above.get(t, [])) for t in own)

        return [name for name, own in self.objects if below(own)]

    def bindings(self, variables):
        names = [name for name, _ in variables]
        for values in itertools.product(*(self.members(types) for _, types in variables)):
            yield dict(zip(names, values))

    def holds(self, condition, state, values):
        if not condition:
            return True
        head, *parts = condition
        if head == "and":
            return all(self.holds(part, state, values) for part in parts)
        if head == "or":
            return any(self.holds(part, state, values) for part in parts)
        if head == "not":
            return not self.holds(parts[0], state, values)
        if head == "imply":
            return not self.holds(parts[0], state, values) or self.holds(parts[1], state, values)
        if head in ("forall", "exists"):
            every = (self.holds(parts[1], state, {**values, **more}) for more in self.bindings(typed(parts[0])))
            return all(every) if head == "forall" else any(every)
        fact = ground(condition, values)
        return fact[1] == fact[2] if head == "=" else fact in state

    def derived(self, state):
        """The state with its derived facts: the least fixpoint of the rules."""
        while True:
            new = {
                ground([head[0], *(name for name, _ in typed(head[1:]))], values)
                for head, body in self.rules
                for values in self.bindings(typed(head[1:]))
                if self.holds(body, state, values)
            }
            if new <= state:
                return state
            state = state | new

    def outcomes(self, effect, values, conditions=()):
        """All combinations of alternatives: lists of (conditions, added, fact)."""
        if not effect:
            return [[]]
        head, *parts = effect
        if head == "and":
            return product([self.outcomes(part, values, conditions) for part in parts])
        if head == "oneof":
            return [outcome for part in parts for outcome in self.outcomes(part, values, conditions)]
        if head == "when":
            return self.outcomes(parts[1], values, (*conditions, (parts[0], values)))
        if head == "forall":
            every = self.bindings(typed(parts[0]))
            return product([self.outcomes(parts[1], {**values, **more}, conditions) for more in every])
        if head == "probabilistic":
            sure = sum(Fraction(p) for p in parts[::2]) == 1
            some = [o for p, part in zip(parts[::2], parts[1::2]) if Fraction(p) for o in self.outcomes(part, values, conditions)]
            return some if sure else [*some, []]
        added = head != "not"
        return [[(conditions, added, ground(effect if added else parts[0], values))]]

    def breadth(self, effect=None):
        """At least the number of combinations of alternatives of an effect; by default, of any action."""
        if effect is None:
            return max(self.breadth(effect) for *_, effect in self.actions)
        head, *parts = effect or ["and"]
        if head == "and":
            return math.prod(self.breadth(part) for part in parts)
        if head == "oneof":
            return sum(self.breadth(part) for part in parts)
        if head == "when":
            return self.breadth(parts[1])
        if head == "forall":
            return self.breadth(parts[1]) ** sum(1 for _ in self.bindings(typed(parts[0])))
        return 1 + sum(self.breadth(part) for part in parts[1::2]) if head == "probabilistic" else 1

    def steps(self, state):
        """The applicable actions by name, each with its set of successors."""
        full = self.derived(state)
        for name, parameters, condition, effect in self.actions:
            for values in self.bindings(parameters):
                if self.holds(condition, full, values):
                    shown = f"{name}({','.join(values.values())})" if values else name
                    yield shown, {self.after(state, full, outcome) for outcome in self.outcomes(effect, values)}

    def after(self, state, full, outcome):
        applied = [(added, fact) for when, added, fact in outcome if all(self.holds(c, full, v) for c, v in when)]
        return (state - {fact for added, fact in applied if not added}) | {fact for added, fact in applied if added}

    def explored(self, most):
        """All reachable states with their steps; None if there are more than `most`."""
        known, todo = {}, [self.initial]
        while todo:
            state = todo.pop()
            if state in known:
                continue
            if len(known) == most:
                return None
            known[state] = dict(self.steps(state))
            todo += [to for successors in known[state].values() for to in successors]
        return known

    def is_goal(self, state):
        return self.holds(self.goal, self.derived(state), {})

    def satisfies(self, state, name):
        """Whether a plan may end in a state, and a preference holds there."""
        return self.is_goal(state) and self.holds(self.preferences[name], self.derived(state), {})


def ground(atom, values):
    return tuple(values.get(word, word) for word in atom)


def product(parts):
    return [[change for outcome in combined for change in outcome] for combined in itertools.product(*parts)]


def strong_cyclic(known, goal):
    """The states from which some strategy reaches the goal almost surely."""
    inside = set(known)
    while True:
        reach, more = set(goal), True
        while more:
            more = {s for s in inside - reach if any(to <= inside and to & reach for to in known[s].values())}
            reach |= more
        if reach == inside:
            return inside
        inside = reach


def possible(known, goal):
    """The states from which some path reaches the goal."""
    inside = set(goal)
    while more := {s for s in set(known) - inside if any(to & inside for to in known[s].values())}:
        inside |= more
    return inside


def strong(known, goal):
    """The states from which every path of some strategy reaches the goal within a bound."""
    inside = set(goal)
    while more := {s for s in set(known) - inside if any(to <= inside for to in known[s].values())}:
        inside |= more
    return inside


def is_plan(problem, entries):
    """Whether a policy, a list of (facts, action), surely reaches the goal: it is closed, and the goal stays
    reachable. `facts` are those that change."""
    changing = {fact for _, fact in entries_facts(entries)}
    chosen = {frozenset(facts): action for facts, action in entries}
    seen, todo = {}, [problem.initial]
    while todo:
        state = todo.pop()
        if state in seen or problem.is_goal(state):
            continue
        action = chosen.get(frozenset(show(fact) for fact in state if show(fact) in changing))
        steps = dict(problem.steps(state))
        if action not in steps:
            return False
        seen[state] = steps[action]
        todo += steps[action]
    near = {state for state, to in seen.items() if any(problem.is_goal(s) for s in to)}
    while more := {s for s, to in seen.items() if s not in near and to & near}:
        near |= more
    return near == set(seen)


def entries_facts(entries):
    return [(action, fact) for facts, action in entries for fact in facts]


def show(fact):
    return f"{fact[0]}({','.join(fact[1:])})" if fact[1:] else fact[0]
