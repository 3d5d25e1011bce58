"""The planning part of the reference, straight from the definitions.

States are numbers, a move is a set of successors. The improvement MDP is built as S x {0,1}: state s
with bit m is number 2s + m. Every region is a textbook fixpoint over Python sets.
"""

from reference_lang import InputError, target_of
from reference_ltl import parse
from reference_plays import Watched, invariant, judged, satisfied


class Space:
    """The explicit MDP support: `moves[s]` lists `(name, successors)`."""

    def __init__(self, model, scope, limit=None):
        self.model, self.scope = model, scope
        self.states, self.number, self.moves, self.deadlocks = [], {}, [], 0
        self.initial = [self.add(s) for s in model.initial_states()]
        if scope == "all":
            for state in model.all_states():
                self.add(state)
        for number, state in enumerate(self.states):  # grows while we walk it
            if limit and number > limit:
                raise OverflowError
            found = [(name, frozenset(map(self.add, targets))) for name, targets in model.choices(state)]
            self.deadlocks += not found or self.is_watched() and state in self.model.stuck
            self.moves.append(found or [("deadlock", frozenset([number]))])

    def add(self, state):
        if state not in self.number:
            self.number[state] = len(self.states)
            self.states.append(state)
        return self.number[state]

    def where(self, predicate):
        return {i for i, s in enumerate(self.states) if predicate(s)}

    def counts(self):
        return {
            "states": str(len(self.states)),
            "choices": str(sum(map(len, self.moves))),
            "transitions": str(sum(len(t) for moves in self.moves for _, t in moves)),
            "deadlocks": str(self.deadlocks),
            "initial": str(len(self.initial)),
            **({"model_states": str(len({s[: self.model.width] for s in self.states}))} if self.is_watched() else {}),
        }

    def is_watched(self):
        return isinstance(self.model, Watched)

    def named(self, number):
        return dict(zip((v.name for v in self.model.variables), self.states[number]))


class Kept:
    """The part of a space in which some choices surely keep the requirements, with these choices."""

    def __init__(self, space, requirements):
        self.whole, self.model, self.scope = space, space.model, space.scope
        violated = {s for s in range(len(space.states)) if violates(space, requirements, s)}
        inside = Game([[t for _, t in moves] for moves in space.moves]).can_stay(set(range(len(space.states))) - violated)
        old = sorted(inside)
        self.new = {s: n for n, s in enumerate(old)}
        self.states = [space.states[s] for s in old]
        self.moves = [
            [(name, frozenset(self.new[t] for t in move)) for name, move in space.moves[s] if move <= inside] for s in old
        ]
        self.initial = [self.new[s] for s in space.initial if s in inside]
        self.inside = inside

    def where(self, predicate):
        return {i for i, s in enumerate(self.states) if predicate(s)}

    def counts(self):
        return {**self.whole.counts(), "unsafe": str(len(self.whole.states) - len(self.states))}


def one_formula(requirements):
    """All requirements as their conjunction, which has one monitor if some is more than `G p`."""
    if all(invariant(parse(r)) is not None for r in requirements):
        return requirements
    return [" & ".join(f"({r})" for r in requirements)]


def violates(space, requirements, number):
    """Whether a state violates a requirement `G p`, or ends a path that violates another one."""
    state, model = space.states[number], space.model
    for conditions in filter(None, map(invariant, map(parse, requirements))):
        if any(bool(model.compile(text)(state)) != sign for text, sign in conditions):
            return True
    return space.is_watched() and model.violates(state)


class Game:
    """The choices of each state as successor sets, and for each state the choices that lead to it."""

    def __init__(self, moves):
        self.moves = moves
        self.sources = [[] for _ in moves]
        for state, choices in enumerate(moves):
            for choice in choices:
                for target in choice:
                    self.sources[target].append((state, choice))

    def can_reach(self, target, within=None):
        """mu X. target | { s : a move meets X (and lies inside `within`) }"""
        reached, todo = set(target), list(target)
        while todo:
            for state, choice in self.sources[todo.pop()]:
                if state not in reached and (within is None or choice <= within):
                    reached.add(state)
                    todo.append(state)
        return reached

    def almost_surely(self, target):
        """nu Y. mu X. target | { s : a move lies inside Y and meets X }"""
        region = set(range(len(self.moves)))
        while True:
            smaller = self.can_reach(target, region)
            if smaller == region:
                return region
            region = smaller

    def can_stay(self, region):
        """nu Z. region & { s : a move lies inside Z }"""
        while True:
            smaller = {s for s in region if any(choice <= region for choice in self.moves[s])}
            if smaller == region:
                return region
            region = smaller


class Order:
    """The comparison of classes, with the value of nothing."""

    def __init__(self, strict, empty):
        self.strict, self.empty = strict, empty

    def most_preferred(self, outcomes):
        return frozenset(i for i in outcomes if not any((j, i) in self.strict for j in outcomes))

    def improves(self, old, new):
        if not old and new:
            return self.empty in ("bottom", "gain")
        return any((j, i) in self.strict for i in old for j in new)

    def weakens(self, old, new):
        if old and not new:
            return self.empty == "bottom"
        return any((i, j) in self.strict for i in old for j in new)


class ImprovementMdp:
    """`--safety action` and `transition`: V = S x {0,1}, final states those with bit 1."""

    def __init__(self, space, classes, order, safety):
        self.size, self.names = len(space.states), []
        moves = []
        for state, choices in enumerate(space.moves):
            kept = []
            for name, targets in choices:
                safe = {t for t in targets if not order.weakens(classes[state], classes[t])}
                if safe and (safety == "transition" or safe == targets):
                    move = frozenset(2 * t + order.improves(classes[state], classes[t]) for t in safe)
                    kept.append((name, move))
            self.names += [kept, kept]
            moves += [[move for _, move in kept]] * 2
        self.game = Game(moves)
        self.transitions = sum(len(move) for choices in moves for move in choices)

    def levels(self, region):
        """W_1, W_2, ... as sets of V, ending with the empty set or a repeated one."""
        goal, found = {2 * s + 1 for s in range(self.size)}, []
        while True:
            found.append(region(goal))
            lower = {v for v in found[-1] if v % 2 == 0}
            if not lower or len(found) > 1 and lower == {v for v in found[-2] if v % 2 == 0}:
                return found
            goal = {v + 1 for v in lower}

    def solve(self, kind):
        region = self.game.almost_surely if kind == "sasi" else self.game.can_reach
        found = self.levels(region)
        sets = [{v // 2 for v in w if v % 2 == 0} for w in found]
        permits = (lambda move, w: move <= w) if kind == "sasi" else (lambda move, w: move & w)
        return Levels(sets, lambda s, k: [name for name, move in self.names[2 * s] if permits(move, found[k - 1])])


class PrefixPlan:
    """`--safety prefix`: safe and improving against the class where planning started."""

    def __init__(self, space, classes, order):
        self.space, self.classes, self.order = space, classes, order
        self.safe, self.kept, self.games = {}, {}, {}
        whole = Game([[t for _, t in choices] for choices in space.moves])
        for c in set(classes):
            safe = whole.can_stay({s for s, d in enumerate(classes) if not order.weakens(c, d)})
            self.safe[c] = safe
            self.kept[c] = [[m for m in ms if s in safe and m[1] <= safe] for s, ms in enumerate(space.moves)]
            self.games[c] = Game([[t for _, t in ms] for ms in self.kept[c]])

    def solve(self, kind):
        everything = set(range(len(self.classes)))
        goals, sets, regions = everything, [], []
        while True:
            won = {c: self.region(kind, c, goals) for c in self.games}
            sets.append({s for s in everything if s in won[self.classes[s]]})
            regions.append(won)
            if not sets[-1] or len(sets) > 1 and sets[-1] == sets[-2]:
                break
            goals = sets[-1]
        permits = (lambda move, w: move <= w) if kind == "sasi" else (lambda move, w: move & w)

        def permitted(s, k):
            c = self.classes[s]
            return [name for name, move in self.kept[c][s] if permits(move, regions[k - 1][c])]

        return Levels(sets, permitted)

    def region(self, kind, c, goals):
        better = {s for s in goals & self.safe[c] if self.order.improves(c, self.classes[s])}
        game = self.games[c]
        return game.almost_surely(better) if kind == "sasi" else game.can_reach(better)


class Levels:
    """W_1 > W_2 > ... over S, the last repeated when it is a fixpoint, else empty."""

    def __init__(self, sets, permitted):
        self.permitted_at = permitted
        if sets[-1]:
            self.fixpoint, self.sets = sets[-1], sets[:-1] if len(sets) > 1 else sets
        else:
            self.fixpoint, self.sets = set(), sets[:-1]

    def rank(self, state):
        rank = sum(state in w for w in self.sets)
        return "unbounded" if state in self.fixpoint else rank

    def permitted(self, state):
        """For an unbounded state the level is the fixpoint's (the one after the last, the same set)."""
        rank = self.rank(state)
        if rank == "unbounded":
            return self.permitted_at(state, len(self.sets) + 1)
        return self.permitted_at(state, rank) if rank else []

    def json(self):
        return {"levels": [str(len(w)) for w in self.sets], "unbounded": str(len(self.fixpoint))}


def satisfied_in(space, formula):
    """The same as `satisfied`; what a path did before it came into a kept part counts too."""
    if not isinstance(space, Kept):
        return satisfied(space, formula)
    facts, sure = satisfied(space.whole, formula, space.inside)
    return facts, {space.new[s] for s in sure if s in space.inside}


def reached(space, formula):
    """Returns the report on an objective `F condition`, and the states where it is almost sure."""
    target = space.where(space.model.compile(target_of(formula)))
    return {"target": str(len(target))}, Game([[t for _, t in ms] for ms in space.moves]).almost_surely(target)


def check(model, prefs, scope, safety, empty=None, space=None):
    required = one_formula(prefs.required)
    if prefs.history == "play":
        watched = Watched(model, [formula for _, formula in prefs.objectives], required)
        space, judge = Space(watched, scope), satisfied_in
    else:
        space, judge = space or Space(model, scope), reached
    whole = space
    if prefs.required:
        space = Kept(whole, required)
    order = Order(prefs.strict, empty or prefs.empty)
    plain = Game([[t for _, t in choices] for choices in space.moves])
    facts, sure = zip(*(judge(space, formula) for _, formula in prefs.objectives))
    outcomes = [{i for i, region in enumerate(sure) if s in region} for s in range(len(space.states))]
    classes = [order.most_preferred(out) for out in outcomes]
    if safety == "prefix":
        plan, improvement = PrefixPlan(space, classes, order), None
    else:
        plan = ImprovementMdp(space, classes, order, safety)
        dropped = sum(len(t) for moves in space.moves for _, t in moves) - plan.transitions // 2
        improvement = {"states": str(2 * plan.size), "transitions": str(plan.transitions), "dropped": str(dropped)}
    sasi, spi = plan.solve("sasi"), plan.solve("spi")
    names = [name for name, _ in prefs.objectives]

    def shown(c):
        return [names[i] for i in sorted(c)]

    def initially(number):
        """The entry of an initial state; an unsafe one has neither class nor rank."""
        s = space.new.get(number) if prefs.required else number
        if s is None:
            return {"state": whole.named(number), "unsafe": {}}
        return {
            "state": whole.named(number),
            "most_preferred": shown(classes[s]),
            "sasi_rank": sasi.rank(s),
            "spi_rank": spi.rank(s),
            "sasi_actions": sasi.permitted(s),
            "spi_actions": spi.permitted(s),
        }

    return {
        "model": {"path": model.path, "constants": model.constants},
        "scope": scope,
        "safety": safety,
        "empty": order.empty,
        "counts": space.counts(),
        "objectives": [
            {"name": n, **f, "almost_sure": str(len(a)), "positive": str(len(plain.can_reach(a)))}
            for n, f, a in zip(names, facts, sure)
        ],
        "classes": [
            {"most_preferred": shown(c), "states": str(classes.count(c))} for c in sorted(set(classes), key=sorted)
        ],
        "improvement": improvement,
        "sasi": sasi.json(),
        "spi": spi.json(),
        "initial": [initially(s) for s in whole.initial[:16]],
    }


def reach(model, target, scope, space=None):
    """The four regions of a target."""
    space = space or Space(model, scope)
    game, goal = Game([[t for _, t in choices] for choices in space.moves]), space.where(model.compile(target))
    everything = set(range(len(space.states)))
    avoid = game.can_stay(everything - goal)
    around = Game([[] if s in goal else choices for s, choices in enumerate(game.moves)])
    regions = {
        "pmax_one": game.almost_surely(goal),
        "pmax_positive": game.can_reach(goal),
        "pmin_one": everything - around.can_reach(avoid),
        "pmin_positive": everything - avoid,
    }
    return {"target": str(len(goal)), **told(space, regions)}


def satisfy(model, formula, scope, space=None):
    """The four regions of a temporal formula."""
    space = space or Space(model, scope)
    return told(space, judged(space, formula))


def told(space, regions):
    def initially(region):
        held = [s in region for s in space.initial]
        return "all" if all(held) else "some" if any(held) else "none"

    return {
        "scope": space.scope,
        "counts": space.counts(),
        **{name: str(len(region)) for name, region in regions.items()},
        "initial": {name: initially(region) for name, region in regions.items()},
    }


def info(model, scope="reachable", space=None):
    return {"model": {"path": model.path, "constants": model.constants}, "counts": (space or Space(model, scope)).counts()}


__all__ = ["InputError", "Space", "check", "info", "reach", "satisfy"]
