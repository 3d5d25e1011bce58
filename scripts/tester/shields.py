"""Shields of the Python package: every node of the table, against the machine of the reference, and along paths."""

import json
import math
import tempfile
from pathlib import Path

from reference.shields import Shield
from reference.strategies import pursued, pursuit
from tester.program import key

MOST_WALKED = 120  # nodes of a shield that are reached step by step


def shields(context, meliora, strategy):
    """A shield, read back from disk, permits in every node what its definition says."""
    made, shield, nodes = saved(context, meliora, strategy)
    separable = Shield(context.analysis, strategy.kind).is_separable()
    if not context.same(f"labels suffice for a shield of {strategy.kind}", separable, made is not None) or not made:
        return
    table = Table(context, nodes, strategy.kind)
    table.compare()
    answers(context, table, meliora, shield)
    Walk(context, table, strategy, (made, shield)).everywhere()


def saved(context, meliora, strategy):
    """A shield, the same one read back from disk, and its table; nothing if choices of one label have to differ.
    Reading checks that the promises follow from the table."""
    try:
        made = strategy.shield()
    except meliora.UsageError as error:
        if "choices with one label together" not in str(error):
            raise
        context.same("some choices share a label", True, shares_labels(context))
        return None, None, None
    with tempfile.TemporaryDirectory() as folder:
        folders = [Path(folder) / name for name in ("made", "loaded")]
        made.save(folders[0])
        shield = meliora.Shield.load(folders[0])
        shield.save(folders[1])
        tables = [(f / "nodes.json").read_text(encoding="utf-8") for f in folders]
    context.same(f"table of the loaded shield of {strategy.kind}", *tables)
    return made, shield, json.loads(tables[0])


def shares_labels(context):
    """Whether choices of some state share a label."""
    return any(len({label(c.name) for c in own}) < len(own) for own in context.analysis.whole.choices)


def shield_of_pursuit(context, meliora, strategy, objective):
    """A shield of a plan or of `achieve`: the permitted labels and the objectives where episodes may start."""
    nodes, analysis = saved(context, meliora, strategy)[2], context.analysis
    if nodes is None or analysis.play:
        return
    table, number = Table(context, nodes, strategy.kind), context.names.index(objective) if objective else None
    for v in range(table.starts):
        state, where = context.relation.one(key(table.state(v))), f"start {v} of {strategy.kind} {objective}"
        taken, may = aimed(analysis, strategy.kind, number, state)
        node = table.nodes[v]
        context.same(f"pursues of {where}", [context.names[i] for i in taken], node.get("pursues", []))
        done = any(state in analysis.targets[i] for i in taken)
        context.same(f"achieved of {where}", done, node.get("achieved", False))
        if state in analysis.whole.theirs:
            context.same(f"permitted of {where}", sorted(table.labels(v)), table.permitted(v))
        elif may is not None and not done:
            of = {}
            for choice in analysis.whole.choices[state]:
                of.setdefault(label(choice.name), set()).add(choice.name)
            if all(own <= may or own.isdisjoint(may) for own in of.values()):
                context.same(f"permitted of {where}", sorted(n for n in of if of[n] <= may), table.permitted(v))


def aimed(analysis, kind, number, state):
    """The objectives that are pursued from a state on, and the names of the choices that may be taken; None where
    nothing is aimed at."""
    if analysis.classes[state] is None:
        return [], None
    levels = analysis.levels("sasi")
    if kind == "plan" and levels.rank(state) != 0:
        return [], {choice.name for choice in levels.permitted(state)}
    if kind == "plan":
        found = pursued(analysis, state, number)
        objective, commits = found or (None, False)
        reference = None if commits else analysis.classes[state]
    else:
        objective, reference = number if state in analysis.sure[number] else None, None
    if objective is None:
        return [], None
    return [objective], {choice.name for choice in pursuit(analysis, objective, reference).staying(state)}


def label(action):
    """Choices with the same label are permitted together."""
    return action.split("(")[0]


class Table:
    """The nodes of a shield. `at[v]` are the states with memory of the reference that the same paths reach."""

    def __init__(self, context, table, kind):
        self.context, self.nodes, self.starts = context, table["nodes"], table["starts"]
        self.variables, self.actions, self.classes = table["variables"], table["actions"], table["classes"]
        self.kind, self.width = kind, context.relation.width
        self.machine = Shield(context.analysis, kind)
        self.at = {v: [] for v in range(len(self.nodes))}

    def state(self, v):
        """The state of a node, with the names of values."""
        pairs = zip(self.variables, self.nodes[v]["state"])
        return {x["name"]: bool(n) if x["boolean"] else (x["values"] or {n: n})[n] for x, n in pairs}

    def plain(self, v):
        return key(self.state(v))[: self.width]

    def labels(self, v):
        """The actions of a node by their labels."""
        return {self.actions[a["action"]]: a for a in self.nodes[v]["actions"]}

    def permitted(self, v):
        return sorted(name for name, action in self.labels(v).items() if action["permitted"])

    def compare(self):
        """Goes through all nodes, breadth first, from the states of the scope."""
        context, relation = self.context, self.context.relation
        names = {key(self.state(v)): v for v in range(self.starts)}
        context.same(f"states where the shield of {self.kind} starts", relation.of.keys(), names.keys())
        todo = [(v, s, self.machine.start(s)) for n, v in names.items() for s in relation.of[n]]
        for v, state, memory in todo:  # grows while we walk it
            if (state, memory) not in self.at[v]:
                self.at[v].append((state, memory))
                todo += self.node(v, state, memory)
        missed = [self.state(v) for v, found in self.at.items() if not found]
        context.same(f"nodes of the shield of {self.kind} that no path reaches", [], missed)
        secure = self.secure()
        for v, found in self.at.items():
            for state, memory in found:
                self.permits(v, state, memory, secure)
        self.promises(secure)

    def node(self, v, state, memory):
        """Compares what a node says of itself. Returns the nodes that follow, with those of the reference."""
        context, node, classes = self.context, self.nodes[v], self.context.analysis.classes
        where = f"node {v} of {self.kind}, {self.state(v)}, {memory}"
        ahead = math.inf if node["ahead"] is None else node["ahead"]
        context.same(f"ahead of {where}", math.inf if memory.level == "unbounded" else memory.level, ahead)
        own = None if node["class"] is None else self.classes[node["class"]]
        context.same(f"class of {where}", None if classes[state] is None else context.named(classes[state]), own)
        context.same(f"theirs of {where}", state in context.analysis.whole.theirs, node.get("theirs", False))
        reference = context.named(self.machine.reference(state, memory))
        context.same(f"reference of {where}", reference, self.classes[node["reference"]])
        labels, actions = self.machine.labels(state, memory), self.labels(v)
        if not context.same(f"labels of {where}", labels.keys(), actions.keys()):
            return []
        plain = {
            key(context.source.named(context.analysis.whole.plain(t))): t for own in labels.values() for t in own.to
        }
        found = []
        for name, action in actions.items():
            successors = {self.plain(to): to for to in action["next"]}
            expected = {at for at, t in plain.items() if t in labels[name].to}
            if context.same(f"successors by {name} of {where}", expected, set(successors)):
                entered = [(to, plain[at]) for at, to in successors.items()]
                found += [(to, t, self.machine.after(state, memory, t)) for to, t in entered]
        return found

    def enters(self, v, action, secure):
        """Whether an action enters secure nodes only, weakens nothing, and keeps the reference or improves on it."""
        return all(to in secure and self.machine.keeps(*self.at[v][0], *self.at[to][0]) for to in action["next"])

    def secure(self):
        """nu Z: the nodes that permit an action, each of which enters Z only and keeps the promise; at level 0 a shield
        permits those that do."""
        known = [v for v, found in self.at.items() if found]
        secure, before = set(known), None
        while secure != before:
            before = secure
            secure = {v for v in before if self.stays(v, before)}
        for v in known:
            where = f"node {v} of {self.kind}, {self.state(v)}"
            self.context.same(f"secure of {where}", v in secure, self.nodes[v]["secure"])
        return secure

    def stays(self, v, secure):
        labels, actions = self.machine.labels(*self.at[v][0]), self.labels(v)
        if self.is_at_rest(v):
            kept = [name for name, own in labels.items() if own.permitted]
            return any(self.enters(v, actions[name], secure) for name in kept)
        taken = [action for action in actions.values() if action["permitted"]]
        return bool(taken) and all(self.enters(v, action, secure) for action in taken)

    def is_at_rest(self, v):
        """Whether we choose in a node, and no improvement is ahead."""
        state, memory = self.at[v][0]
        return memory.level == 0 and state not in self.context.analysis.whole.theirs

    def permits(self, v, state, memory, secure):
        """The permitted labels of a node."""
        labels, actions = self.machine.labels(state, memory), self.labels(v)
        where = f"node {v} of {self.kind}, {self.state(v)}, {memory}"
        wanted = [name for name, own in labels.items() if own.permitted]
        if v in secure and self.is_at_rest(v):
            wanted = [name for name in wanted if self.enters(v, actions[name], secure)]
        keeping = [name for name, own in labels.items() if own.keeps]
        self.context.same(f"permitted of {where}", sorted(wanted or keeping or labels), self.permitted(v))

    def promises(self, secure):
        """What the nodes promise holds whatever choices of the permitted labels, and of the opponent, are taken."""
        context, steps = self.context, {v: self.steps(v) for v, found in self.at.items() if found}
        for v in secure:
            entered = {to for choices in steps[v].values() for nodes in choices for to in nodes}
            kept = all(self.machine.keeps(*self.at[v][0], *self.at[to][0]) for to in entered)
            where = f"node {v} of {self.kind}, {self.state(v)}"
            context.same(f"every permitted choice is secure in {where}", True, kept and entered <= secure)
        ahead = {v for v in steps if self.nodes[v]["ahead"] != 0}
        context.same(f"nodes of {self.kind} whose improvements every choice makes", ahead, self.improving(steps, ahead))

    def steps(self, v):
        """The nodes that each choice of each permitted label may enter."""
        state, _ = self.at[v][0]
        places = {name: {self.plain(to): to for to in a["next"]} for name, a in self.labels(v).items()}
        found, whole = {name: [] for name in self.permitted(v)}, self.context.analysis.whole
        for choice in whole.choices[state]:
            if label(choice.name) in found:
                plain = [key(self.context.source.named(whole.plain(t))) for t in choice.to]
                found[label(choice.name)].append({places[label(choice.name)][name] for name in plain})
        return found

    def improving(self, steps, ahead):
        """The nodes from which permitted labels, taken at random, make the next improvement almost surely (SASI) or
        possibly (SPI), whoever chooses among the choices of a label."""

        def leads(v, nodes, ends):
            return any(to in ends or self.improves(v, to) for to in nodes)

        def stays(v, nodes):
            return self.kind == "spi" or all(to in won or self.improves(v, to) for to in nodes)

        won, before = set(ahead), None
        while won != before:
            before, won = won, {v for v in won if all(stays(v, nodes) for own in steps[v].values() for nodes in own)}
            near, last = set(), None
            while near != last:
                last = set(near)
                for v in won - last:
                    every = all if self.at[v][0][0] in self.context.analysis.whole.theirs else any
                    if every(all(leads(v, nodes, near) for nodes in own) for own in steps[v].values()):
                        near.add(v)
            won = near
        return won

    def improves(self, v, to):
        """Whether a step is an improvement after which the others are still ahead."""
        left = [math.inf if self.nodes[w]["ahead"] is None else self.nodes[w]["ahead"] for w in (v, to)]
        return self.machine.counts(*self.at[v][0], self.at[to][0][0]) and left[1] >= left[0] - 1


def answers(context, table, meliora, shield):
    """`masks` of all nodes, and of the states whose permitted actions do not depend on the memory."""
    rows = [[name in table.permitted(v) for name in table.actions] for v in table.at]
    states = [dict(table.plain(v)) for v in table.at]
    found = shield.masks(states, memory=list(table.at)).tolist()
    context.same(f"masks of {table.kind}", rows, found)
    of = {}
    for state, row in zip(states, rows):
        of.setdefault(key(state), []).append(row)
    for state, known in of.items():
        try:
            got = shield.masks([dict(state)]).tolist()
        except meliora.UsageError:
            got = None
        alike = all(row == known[0] for row in known)
        context.same(f"mask of {dict(state)} without memory", known[:1] if alike else None, got)


class Walk:
    """Episodes of a shield, and plays of its strategy, that lead to every node."""

    def __init__(self, context, table, strategy, shields):
        self.context, self.table, self.strategy, self.shields = context, table, strategy, shields
        fresh = {context.analysis.whole.plain(s) for s in context.relation.fresh()}
        fresh = {key(context.source.named(values)) for values in fresh}
        # The first state with the values of a start has its fresh monitors.
        place = {name: v for v, name in reversed([(v, key(table.state(v))) for v in range(table.starts)])}
        starts = {}
        for name in context.relation.of:
            starts.setdefault(name[: table.width], place[name])
        self.starts = [v for plain, v in starts.items() if plain in fresh]

    def everywhere(self):
        paths, order = {v: [v] for v in self.starts}, list(self.starts)
        for v in order:  # grows while we walk it
            for action in self.table.nodes[v]["actions"]:
                for to in action["next"] if action["permitted"] else ():
                    if len(paths) < MOST_WALKED and to not in paths:
                        paths[to] = [*paths[v], to]
                        order.append(to)
            self.visit(v, paths[v])

    def visit(self, v, path):
        """Follows a path, and asks everything about its last node."""
        table, context = self.table, self.context
        states = [table.state(to) for to in path]
        play, now = self.strategy.play(states[0]), dict(table.plain(v))
        for state in states[1:]:
            play.step(state)
        where, node = f"{table.kind} after {states}", table.nodes[v]
        ahead = math.inf if node["ahead"] is None else node["ahead"]
        context.same(f"play ahead of {where}", ahead, play.ahead)
        for state, memory in table.at[v]:
            expected = [sorted(names) for names in table.machine.permitted(state, memory)]
            if state in context.analysis.whole.theirs:
                expected = [[], []]  # a strategy neither permits nor forbids what the opponent does
            which, actions = ("permitted", "progress") if ahead else ("kept",), play.explain().actions
            found = [sorted(action.name for action in actions if getattr(action, name)) for name in which]
            context.same(f"play of {where}", expected[: len(which)], found)
            first = next(([action.name] for action in actions if action.progress), [])
            context.same(f"chosen by play of {where}", [first] * 2, [play.actions(w) for w in ("progress", "chosen")])
        for shield in self.shields:
            shield.reset(dict(table.plain(path[0])))
            for to in path[1:]:
                shield.step(dict(table.plain(to)))
            got = (shield.memory(now), shield.ahead(now), shield.secure(now), sorted(shield.allowed(now)))
            context.same(f"shield of {where}", (v, ahead, node["secure"], table.permitted(v)), got)
            self.corrected(shield, v, where, now)

    def corrected(self, shield, v, where, now):
        """An action that is not permitted is replaced by one that is, which makes progress where one does."""
        table, permitted = self.table, self.table.permitted(v)
        helpful = {name for at in table.at[v] for name, own in table.machine.labels(*at).items() if own.progress}
        for name in table.actions:
            taken = shield.copy().correct(now, name)
            if name in permitted:
                self.context.same(f"correct of {name}, {where}", name, taken)
            else:
                best = helpful.intersection(permitted) or permitted
                self.context.same(f"correct of {name}, {where}", True, taken in best)
