"""Whole paths in the reference: the model with monitors, and the states that satisfy formulas almost surely."""

import math

from reference_ltl import FALSE, Search, atoms, leaves, negated, observer, parse, refuted


class Watched:
    """A model together with the monitors of some formulas: each reads the states as they are left.

    A state is that of the model followed by the states of the monitors, so that conditions of the model are
    conditions on it. In every state of the scope that the model has, monitors are in their initial state.
    """

    def __init__(self, model, formulas, requirements=()):
        self.model, self.path, self.constants, self.compile = model, model.path, model.constants, model.compile
        self.variables, self.width, self.stuck = model.variables, len(model.variables), set()
        self.own = {text: [observer(leaf) for leaf in leaves(parse(text))] for text in formulas}
        self.required = [f for f in map(parse, requirements) if invariant(f) is None]
        every = [o for own in self.own.values() for o in own] + [observer(f) for f in self.required]
        self.observers = list(dict.fromkeys(every))
        self.letters = {name: model.compile(name) for names, _ in self.observers for name in names}

    def fresh(self, state):
        return state + (0,) * len(self.observers)

    def initial_states(self):
        return [self.fresh(s) for s in self.model.initial_states()]

    def all_states(self):
        return map(self.fresh, self.model.all_states())

    def read(self, state):
        """The monitors' states after they have read a state."""
        plain, seen, then = state[: self.width], state[self.width :], ()
        for at, (names, steps) in zip(seen, self.observers):
            letter = sum(bool(self.letters[n](plain)) << k for k, n in enumerate(reversed(names)))
            then += (steps[at][letter],)
        return then

    def violates(self, state):
        """Whether the path up to a state violates a requirement that has a monitor."""
        then = self.read(state)
        return any(then[self.observers.index(observer(f))] in refuted(f) for f in self.required)

    def choices(self, state):
        plain, then = state[: self.width], self.read(state)
        found = [(name, {t + then for t in targets}) for name, targets in self.model.choices(plain)]
        if not found:
            self.stuck.add(state)
        return found or [("deadlock", {plain + then})]


def invariant(f):
    """The conditions p with their signs if f is a conjunction of `G p`; None for every other formula."""
    if f[0] == "and":
        both = [invariant(f[1]), invariant(f[2])]
        return None if None in both else both[0] + both[1]
    return [f[2][1:]] if f[:2] == ("R", FALSE) and f[2][0] == "is" else None


class Play:
    """The paths of a space from some states on, each with the automaton of a formula that a strategy runs.

    The formula is satisfied almost surely from `won`. From there infinitely many breakpoints occur almost surely:
    nu Y. mu X. { n : a move inside Y meets X, or is inside Y and n is at a breakpoint }.
    A strategy stays `inside` some states, if these are given.
    """

    def __init__(self, space, starts, formula, inside=None):
        self.inside = inside
        self.search = Search(formula)
        conditions = {name: space.model.compile(name) for name in atoms(formula)}
        self.letters = [{name: bool(c(s)) for name, c in conditions.items()} for s in space.states]
        self.number, self.moves, self.marked = {}, [], []
        self.first = {s: self.node((s, self.search.start)) for s in starts}
        while len(self.moves) < len(self.number):
            for node in list(self.number)[len(self.moves) :]:
                self.expand(space, *node)
        self.sources = [[] for _ in self.moves]
        for at, own in enumerate(self.moves):
            for move in own:
                for target in move:
                    self.sources[target].append((at, move))
        self.won = self.again_and_again()

    def node(self, node):
        return self.number.setdefault(node, len(self.number))

    def expand(self, space, state, run):
        """A guess takes no step of the path."""
        own = [frozenset([self.node((state, guess))]) for guess in self.search.guesses(run)]
        read = self.search.read(run, self.letters[state])
        if read:
            for _, targets in space.moves[state]:
                move = frozenset(self.node((t, read[0])) for t in targets)
                if self.inside is None or state in self.inside and targets <= self.inside:
                    own.append(move)
        self.moves.append(own)
        self.marked.append(bool(read and read[1]))

    def reaching(self, goal, within):
        reached, todo = set(goal), list(goal)
        while todo:
            for at, move in self.sources[todo.pop()]:
                if at not in reached and (within is None or at in within and move <= within):
                    reached.add(at)
                    todo.append(at)
        return reached

    def again_and_again(self):
        region = set(range(len(self.moves)))
        while True:
            goal = {n for n in region if self.marked[n] and any(move <= region for move in self.moves[n])}
            smaller = self.reaching(goal, region)
            if smaller == region:
                return region
            region = smaller


def satisfied(space, formula, inside=None):
    """Returns the report on an objective over whole paths, and the states where it is almost sure."""
    watched = space.model
    fresh = [n for n, s in enumerate(space.states) if s == watched.fresh(s[: watched.width])]
    play = Play(space, space.initial if space.scope == "reachable" else fresh, parse(formula), inside)
    sure, missed = set(), set()
    for (state, (_, later)), number in play.number.items():
        if later is None:
            (sure if number in play.won else missed).add(state)
    if sure & missed:
        raise AssertionError("what is to come depends on more than the observers of the reference see")
    sizes = (len(steps) for _, steps in set(watched.own[formula]))
    return {"observer": math.prod(sizes)}, sure


def judged(space, formula):
    """The four regions of a formula, judged from each state of a space on."""

    def some_strategy(f):
        play = Play(space, range(len(space.states)), f)
        possibly = play.reaching(play.won, None)
        return [{s for s, n in play.first.items() if n in region} for region in (play.won, possibly)]

    everything, parsed = set(range(len(space.states))), parse(formula)
    one, positive = some_strategy(parsed)
    against_one, against_positive = some_strategy(negated(parsed))
    return {
        "pmax_one": one,
        "pmax_positive": positive,
        "pmin_one": everything - against_positive,
        "pmin_positive": everything - against_one,
    }
