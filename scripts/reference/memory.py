"""Section 14: policies with memory. Each node is a state with the memory of the policy, and the actions it takes.

A policy is judged by its paths: pairs of a node and a state of the reference, which the same steps lead to. Nodes say
when an improvement counts, by what they compare with; how many follow, and what is achieved, is computed anew.
"""

from dataclasses import replace

from reference.model import Choice, Moves, almost_sure, attractor
from reference.product import Product, satisfaction
from reference.strategies import achieved


class Lie(Exception):
    """A policy does not keep its promise."""


def ensure(holds, what):
    if not holds:
        raise Lie(what)


class Paths(Product):
    """The product of paths of a policy: its pairs are read as their states are."""

    def read(self, state):
        return self.of.read(self.mdp.values[state][1])


class Policy:
    """The paths of a policy. `related` gives the states of the reference for a state of a file."""

    def __init__(self, file, analysis, related):
        self.analysis, self.related, self.nodes, self.promise = analysis, related, file["nodes"], file["promise"]
        self.kind, self.names = self.promise["kind"], analysis.preferences.names
        own = file["nodes"][: file["starts"]]
        ensure(len({key(node["state"]) for node in own}) == len(own), "two nodes of one start")
        self.starts = [(n, s) for n, node in enumerate(own) for s in related.get(key(node["state"]), ())]
        missing = set(analysis.whole.initial) - {s for _, s in self.starts}
        ensure(not missing, "an initial state has no node")
        self.after, todo = {}, list(self.starts)
        while todo:
            pair = todo.pop()
            if pair not in self.after:
                self.after[pair] = self.steps(*pair)
                todo += [to for own in self.after[pair] for to in own]

    def members(self, names):
        return frozenset(self.names.index(name) for name in names)

    def preferred(self, node):
        return self.members(self.nodes[node]["most_preferred"])

    def reference(self, node):
        return self.members(self.nodes[node].get("reference", self.nodes[node]["most_preferred"]))

    def steps(self, node, state):
        """The sets of pairs that follow: one of ours, or one for each choice of the opponent."""
        analysis, whole = self.analysis, self.analysis.whole
        ensure(state not in analysis.mdp.unsafe, "an unsafe state is visited")
        ensure(analysis.classes[state] == self.preferred(node), "the class of a state is another one")
        names, found = [choice.name for choice in whole.choices[state]], {}
        for taken in self.nodes[node]["actions"]:
            fits = [n for n, name in enumerate(names) if name == taken["action"]]
            fits = [n for n in fits if taken.get("position", n) == n]
            ensure(len(fits) == 1 and fits[0] not in found, "an action is not there, or not the only one")
            found[fits[0]] = [
                (to, t)
                for t in whole.choices[state][fits[0]].to
                for to in taken["next"]
                if t in self.related.get(key(self.nodes[to]["state"]), ())
            ]
            is_each = len({t for _, t in found[fits[0]]}) == len(whole.choices[state][fits[0]].to)
            ensure(is_each and len(taken["next"]) == len(found[fits[0]]), "not each successor has one node")
        if state not in whole.theirs:
            return [frozenset(to for own in found.values() for to in own)] if found else []
        ensure(len(found) in (0, len(names)), "a choice of the opponent is missing")
        return [frozenset(own) for own in found.values()]

    def judge(self):
        """Raises `Lie` unless the policy keeps its promise."""
        if self.kind != "achieve":
            for pair in self.starts:
                ensure(self.reference(pair[0]) == self.preferred(pair[0]), "a start is compared with another class")
            for pair, own in self.after.items():
                for to in set().union(*own):
                    self.compare(pair[0], to[0])
            self.improve()
        if self.kind == "achieve":
            goals = self.members(self.promise.get("objectives", ()))
            ensure(goals, "nothing is to be achieved")
            for node, _ in self.starts:
                ensure(self.pursued(node) == goals, "another objective is pursued")
            for goal in goals:
                self.achieve(goal, set(self.after))
        elif self.kind == "plan":
            self.plan()

    def compare(self, node, to):
        """A step does not weaken its reference, and only an improvement changes it."""
        preferences, commits = self.analysis.preferences, self.nodes[node].get("commits", False)
        change = preferences.change(self.reference(node), self.preferred(to))
        ensure(commits or change != "weakening", "a step weakens")
        renewed = self.reference(to) == self.preferred(to)
        if self.promise["safety"] == "action":
            ensure(renewed, "a step is not compared with the state before")
        elif self.reference(to) != self.reference(node):
            may = change == "improving" or commits or self.nodes[to].get("commits", False)
            ensure(renewed and may, "no improvement changes what steps are compared with")

    def improves(self, node, to):
        change = self.analysis.preferences.change(self.reference(node), self.preferred(to))
        return change == "improving" and self.reference(to) == self.preferred(to)

    def improve(self):
        """The starts make as many improvements as they promise."""
        wanted = {pair: self.nodes[pair[0]]["ahead"] for pair in self.starts}
        most = max((k for k in wanted.values() if k != "unbounded"), default=0)
        levels, endless = [set(self.after)], "unbounded" in wanted.values()
        while len(levels) <= most or endless and (len(levels) < 2 or levels[-1] != levels[-2]):
            levels.append(self.before(levels[-1]))
        for pair, k in wanted.items():
            ensure(pair in levels[-1 if k == "unbounded" else k], "a start does not make its improvements")

    def before(self, level):
        """The pairs that make an improvement into a level, almost surely or possibly: that reach the end of a graph in
        which such steps lead there, and, almost surely, no step that ends without one."""
        number = {pair: n for n, pair in enumerate(self.after)}
        end = len(number)
        moves = [
            [
                frozenset(end if to in level and self.improves(pair[0], to[0]) else number[to] for to in own)
                for own in self.after[pair]
            ]
            for pair in self.after
        ] + [[frozenset({end})]]
        theirs = {number[pair] for pair in self.after if pair[1] in self.analysis.whole.theirs}
        reach = attractor if self.kind == "spi" else almost_sure
        won = reach(Moves(moves, frozenset(theirs)), {end})
        return {pair for pair, n in number.items() if n in won}

    def pursued(self, node):
        return self.members(self.nodes[node].get("pursues", ()))

    def plan(self):
        """When a plan makes no improvement any more, it achieves a most preferred objective, and goes over to preferred
        ones only."""
        strict, nodes = self.analysis.preferences.strict, self.nodes
        named = self.members(self.promise.get("objectives", ()))
        begun = [(None, pair[0]) for pair in self.starts]
        begun += [(pair[0], to[0]) for pair, own in self.after.items() for to in set().union(*own)]
        for before, node in begun:
            own, last = self.pursued(node), self.pursued(before) if before is not None else frozenset()
            ensure(len(own) < 2 and (own or not last), "a plan pursues one objective to the end")
            is_over = before is not None and nodes[node]["ahead"] == 0
            ensure(own or not is_over or not self.preferred(node), "no pursuit")
            if own and own != last:
                ensure(own <= self.preferred(node), "another objective than a most preferred one is pursued")
                is_better = all((i, j) in strict for i in own for j in last)
                ensure(is_better, "a plan goes over to an objective that is not preferred")
                ensure(last or not named & self.preferred(node) or own <= named, "another objective is named")
        for goal in range(len(self.names)):
            within = {pair for pair in self.after if goal in self.pursued(pair[0])}
            if within:
                self.achieve(goal, within)

    def achieve(self, goal, within):
        """Paths that stay within some pairs achieve an objective almost surely, against every opponent."""
        analysis, pairs = self.analysis, list(self.after)
        number = {pair: n for n, pair in enumerate(pairs)}
        is_left = [pair not in within for pair in pairs]
        ends = [n for n, pair in enumerate(pairs) if pair in within and not self.after[pair]]
        theirs = frozenset(n for n, pair in enumerate(pairs) if pair[1] in analysis.whole.theirs)
        if not analysis.play:
            good = {n for n, (_, s) in enumerate(pairs) if is_left[n] or s in analysis.targets[goal]}
            after = [[frozenset(number[to] for to in own) for own in self.after[pair]] for pair in pairs]
            moves = [[frozenset({n})] if n in good else own for n, own in enumerate(after)]
            won = almost_sure(Moves(moves, theirs), good)
            started = self.starts if self.kind == "achieve" else within
            ensure(all(number[pair] in won for pair in started), "a target is not reached almost surely")
            return
        ensure(all(achieved(analysis, goal, pairs[n][1], False) for n in ends), "a policy ends early")
        choices = [
            [Choice("", {number[to]: 1 for to in own}, {}) for own in self.after[pair]] or [Choice("", {n: 1}, {})]
            for n, pair in enumerate(pairs)
        ]
        mdp = replace(analysis.whole, values=pairs, choices=choices, initial=[], theirs=theirs)
        product = Paths(mdp, analysis.product.monitors)
        product.of = analysis.product
        for known in ("marks", "accepted"):
            of = getattr(analysis.product, known)
            setattr(product, known, {f: {n for n, (_, s) in enumerate(pairs) if s in own} for f, own in of.items()})
        if any(to not in within for pair in within for own in self.after[pair] for to in own):
            return  # a plan that goes over: its last objective is judged
        won = satisfaction(product, mdp, analysis.formulas[goal])["pmax_one"] | set(ends)
        ensure(all(number[pair] in won for pair in within), "a formula is not satisfied almost surely")


def key(state):
    return tuple(state.items())


def keeps(file, analysis, related):
    """Whether a policy keeps its promise, or why not."""
    try:
        Policy(file, analysis, related).judge()
    except Lie as lie:
        return str(lie)
    except (ValueError, TypeError, IndexError, KeyError) as wrong:  # a name or a node that does not exist
        return repr(wrong)
    return ""

