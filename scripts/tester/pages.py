"""Report pages: the diagram that their script reads, in every state; the cells of their maps; and the run."""

import functools
import itertools
import json
import math
import re

from reference.shields import Shield as Machine
from tester.program import Refused, key
from tester.promises import opponent_of, options_of
from tester.shields import label

CELL = re.compile(r'<g class="(cell[^"]*)"[^>]* data-row="(-?\d+)" data-col="(-?\d+)" data-value="([^"]*)"')


def pages(context):
    """A page, and for some cases a separate picture."""
    program, case = context.program, context.case
    if not context.is_game and case.seed % 3:
        return
    kind, objective, variant = options_of(context)
    options = ["--kind", kind, "--scheduler", variant, "--seed", case.seed]
    options += ["--objective", objective] if objective else []
    options += ["--opponent", opponent_of(context)] if context.is_game else []
    # By value, our actions are permitted ones and the worst answers are those for the values.
    by_value = context.is_game and case.seed % 4 > 1
    options += ["--choose", "first"] if context.is_game and not by_value else []
    page = Page(context, written(context, "page.html", *options))
    page.everywhere()
    page.maps()
    page.run(kind, "permissive" if by_value else variant, None if by_value else opponent_of(context))
    page.heat()
    if case.seed % 2:
        page.cells("spi", written(context, "map.svg", "--format", "svg", "--picture", "spi"))
    else:
        order(context, written(context, "order.dot", "--format", "dot"))


def written(context, name, *options):
    """The text of the file that `report` writes; it draws diagrams, so it has one engine."""
    program, settings = context.program, ("scope", "safety", "threads", "coalition", "order")
    out = program.folder / name
    program.ask("report", program.model, program.prefs, *program.settings(*settings), *options, "--out", out)
    return out.read_text(encoding="utf-8")


def order(context, text):
    """The preference order: paths of the graph are strict preferences, its nodes are objectives that are equivalent."""
    groups = {group: re.findall(r"O\d+", label) for group, label in re.findall(r'(g\d+) \[label="([^"]*)"\]', text)}
    arcs = set(re.findall(r"(g\d+) -> (g\d+)", text))
    for middle, high, low in itertools.product(groups, repeat=3):
        if (high, middle) in arcs and (middle, low) in arcs:
            arcs.add((high, low))
    context.same(
        "objectives in the order", sorted(context.names), sorted(name for own in groups.values() for name in own)
    )
    got = {(a, b) for high, low in arcs for a in groups[high] for b in groups[low]}
    strict = {(context.names[i], context.names[j]) for i, j in context.preferences.strict}
    context.same("preferences in the order", strict, got)


class Page:
    """The data of a page; an edge of its diagram is a set of states."""

    def __init__(self, context, text):
        self.context, self.text = context, text
        self.data = json.loads(re.search(r'<script id="data"[^>]*>(.*?)</script>', text, re.DOTALL)[1])
        self.variables, self.nodes = self.data["variables"], self.data["nodes"]
        self.of = {self.numbers(name): name for name in context.relation.of}

    def numbers(self, name):
        """The values of a state as numbers, in the order of the variables."""
        values = dict(name)
        return tuple(
            v["low"] + v["names"].index(values[v["name"]]) if v["names"] else int(values[v["name"]])
            for v in self.variables
        )

    def holds(self, edge, state):
        """Whether an edge has a state, given as numbers."""
        bits = {
            level: (value - v["low"]) >> k & 1
            for v, value in zip(self.variables, state)
            for k, level in enumerate(v["levels"])
        }
        while abs(edge) != 1:
            level, yes, no = self.nodes[3 * (abs(edge) - 2) :][:3]
            edge = (yes if bits[level] else no) * (1 if edge > 0 else -1)
        return edge > 0

    def one(self, state):
        return self.context.relation.one(self.of[state])

    def is_safe(self, state):
        return state in self.of and self.one(state) not in self.context.analysis.mdp.unsafe

    def everywhere(self):
        """The sets of the page in every state, and the scope in all other valuations of a model without monitors."""
        same, data, analysis = self.context.same, self.data, self.context.analysis
        valuations = [range(v["low"], v["high"] + 1) for v in self.variables]
        everything = itertools.product(*valuations) if not analysis.play else self.of
        unsafe = data["unsafe"]["edge"] if data["unsafe"] else -1
        for state in everything:
            safe = self.is_safe(state)
            got = self.holds(data["scope"], state), self.holds(unsafe, state)
            same(f"scope and unsafe at {state}", (safe, state in self.of and not safe), got)
        for state in filter(self.is_safe, self.of):
            self.outcomes(state)
            self.levels(state)
        if self.context.is_game:
            for state in self.of:
                self.mover(state)
        same("a page has a game", self.context.is_game, data["game"] is not None)

    def outcomes(self, state):
        context, data, one = self.context, self.data, self.one(state)
        names = context.named(context.analysis.classes[one])
        shown = f"{', '.join(names[:-1])} or {names[-1]}" if len(names) > 1 else names[0] if names else "nothing"
        got = [c["name"] for c in data["classes"] if self.holds(c["edge"], state)]
        context.same(f"class of a page at {state}", [shown], got)
        for number, edge in enumerate(data["targets"]):
            if context.secured(number) is not None:
                inside = self.happens(context.analysis.targets[number], state)
                context.same(f"target {number} of a page at {state}", inside, self.holds(edge, state))

    def happens(self, target, state):
        """Whether a state has the mark of an objective: it is in its target; for a temporal one, some step from outside
        enters it there, or it is an initial state."""
        analysis = self.context.analysis
        own = [s for s in self.context.relation.of[self.of[state]] if s in target]
        if not analysis.play or not own:
            return bool(own)
        return not self.entered(frozenset(target)).isdisjoint(own)

    @functools.lru_cache(maxsize=64)
    def entered(self, target):
        """The states of a target that are initial, or that some step from outside enters."""
        mdp = self.context.analysis.mdp
        outside = (choice.successors for s in mdp.states if s not in target for choice in mdp.choices[s])
        return target & set().union(mdp.initial, *outside)

    def levels(self, state):
        for kind in ("sasi", "spi"):
            ladder, found = self.data[kind], self.context.analysis.levels(kind)
            got = sum(self.holds(edge, state) for edge in ladder["levels"])
            if ladder["unbounded"] is not None and self.holds(ladder["unbounded"], state):
                got = "unbounded"
            self.context.same(f"{kind} rank of a page at {state}", found.rank(self.one(state)), got)
            edges = zip(self.data["choices"], ladder["permitted"])
            got = sorted(self.name(choice, state) for choice, edge in edges if self.holds(edge, state))
            permitted = sorted(self.called(choice, got) for choice in found.permitted(self.one(state)))
            self.context.same(f"{kind} permits at {state} of a page", permitted, got)

    def mover(self, state):
        """Who moves in a state and, if the opponent does, what its moves lead to."""
        context, game = self.context, self.data["game"]
        whole, one = context.analysis.whole, self.one(state)
        players = [
            (name, at in context.ours, at == whole.owners[one]) for at, name in enumerate(context.source.players)
        ]
        got = [(player["name"], player["ours"], self.holds(player["edge"], state)) for player in game["players"]]
        context.same(f"players of a page at {state}", players, got)
        if not self.is_safe(state):
            return
        theirs = whole.choices[one] if one in whole.theirs else ()
        got = [
            (
                self.name(self.data["choices"][move["choice"]], state),
                *([self.holds(edge, state) for edge in move[what]] for what in MOVE),
            )
            for move in game["moves"]
            if self.holds(move["enabled"], state)
        ]
        names = [name for name, *_ in got]
        context.same(
            f"moves of a page at {state}", sorted((self.called(c, names), *self.move(one, c)) for c in theirs), sorted(got)
        )

    def name(self, choice, state):
        """The name that the page gives to a choice in a state."""
        several = choice["several"] is not None and self.holds(choice["several"], state)
        return choice["own"] if several else choice["name"]

    def called(self, choice, here=()):
        """The name of a choice in the page: its label; where others have the label, too, or without one, the names of
        all commands that have its number, among those `here` if it is one of them; or in a dtmc `uniform`, the only
        choice."""
        is_full = choice.name != label(choice.name)
        names = [*here, *(c["own" if is_full else "name"] for c in self.data["choices"])]
        found = (name for name in names if stands_for(name, choice.name))
        return next(found, "uniform" if self.context.case.kind == "dtmc" else choice.name)

    def move(self, state, choice):
        """What a move leads to: whether all of its successors, and some, improve and weaken; and their ranks."""
        analysis, old = self.context.analysis, self.context.analysis.classes[state]
        found = []
        changes = [analysis.preferences.change(old, analysis.classes[to]) for to in choice.to]
        for change in ("improving", "weakening"):
            each = [one == change for one in changes]
            found.append([all(each), any(each)])
        for kind in ("sasi", "spi"):
            levels, most = analysis.levels(kind), len(self.data[kind]["levels"])
            ranks = {levels.rank(to) for to in choice.to}
            ranks = {most if rank == "unbounded" else rank for rank in ranks}
            found.append([rank in ranks for rank in range(most + 1)])
        return found

    def maps(self):
        """The maps of ranks and classes."""
        for figure in self.text.split('<figure class="map" id="map-')[1:]:
            name = figure[: figure.index('"')]
            if name in ("sasi", "spi", "classes"):
                self.cells(name, figure.partition("</figure>")[0])

    def matching(self, view):
        """The states with the values of a view."""
        return [s for s in self.of if all(wanted in (None, value) for wanted, value in zip(view, s))]

    def view(self, others, place):
        """A view with the values of a cell."""
        view = list(others)
        for variable, value in zip((self.data["row"], self.data["column"]), place):
            if variable is not None:
                view[variable] = value
        return view

    def opening(self):
        """The view that a page opens with: the values of the start. If they leave most cells without a state, the first
        variable is open that changes this, or all are."""
        start, inside = self.data["at"], [self.data["row"], self.data["column"]]
        places = {tuple(0 if v is None else state[v] for v in inside) for state in self.of}
        views = [start] + [[None if v == at else x for v, x in enumerate(start)] for at in range(len(start))]
        for view in views:
            if 2 * sum(not self.matching(self.view(view, place)) for place in places) <= len(places):
                return view
        return [None] * len(start)

    def cells(self, name, text):
        """The cells of a map show the best of the states with the values of the opening view."""
        context, data = self.context, self.data
        found = CELL.findall(text)
        context.same(f"opening of {name}", self.opening(), data["opening"])
        context.same(f"cells of {name}", len(data["rows"]) * len(data["columns"]), len(found))
        for kind, row, column, value in found:
            place = int(row), int(column)
            here = self.matching(self.view(data["opening"], place))
            others = here or self.matching(self.view([None] * len(self.variables), place))
            owned = [s for s in others if self.owned(s)]
            theirs = bool(owned) and all(self.one(s) in context.analysis.whole.theirs for s in owned)
            expected = self.shown(name, here), bool(others) and not here, theirs
            got = value, "elsewhere" in kind.split(), "theirs" in kind.split()
            context.same(f"cell {row},{column} of {name}", expected, got)
        self.marks(name, text)

    def marks(self, name, text):
        """The marks of the opening view: those of the states that a cell shows, none that most cells have."""
        data, places, found = self.data, {}, {}
        inside = [v for v in (data["row"], data["column"]) if v is not None]
        for state in self.of:
            places.setdefault(tuple(state[v] for v in inside), []).append(state)
        for part in text.split('<g class="cell')[1:]:
            row, column = re.search(r'data-row="(-?\d+)" data-col="(-?\d+)"', part).groups()
            group = part.partition('<g class="marks">')[2].partition("</g>")[0]
            place = (int(row), int(column)) if data["row"] is not None else (int(column),)
            glyphs = re.findall(r"<tspan([^>]*)>([^<]*)</tspan>", group)
            found[place] = [(glyph, "pale" in attributes) for attributes, glyph in glyphs]
        expected = {place: [] for place in found}
        for mark in data["marks"]:
            held = {place: self.has(mark, inside, place, states) for place, states in places.items()}
            own, pale = ([place for place in held if held[place] == what] for what in ("own", "pale"))
            for place in own if 2 * len(own) <= len(places) else []:
                expected[place].append((mark["glyph"], False))
            for place in pale if 2 * len(own + pale) <= len(places) else []:
                expected[place].append((mark["glyph"], True))
        for place, glyphs in expected.items():
            shown = glyphs if len(glyphs) <= 4 else glyphs[:3] + [("+", False)]
            self.context.same(f"marks of {place} in {name}", shown, found[place])

    def has(self, mark, inside, place, states):
        """Whether the state of a cell with the values of the opening view has a mark, or a state with other values."""
        here = list(self.data["opening"])
        for variable, value in zip(inside, place):
            here[variable] = value
        exact = self.matching(here)
        if any(self.holds(mark["edge"], state) for state in exact):
            return "own"
        if mark["wide"] or not any(self.holds(mark["edge"], state) for state in states):
            return None
        return "pale" if exact else "own"

    def owned(self, state):
        return bool(self.context.is_game) and self.context.analysis.whole.owners[self.one(state)] is not None

    def shown(self, name, states):
        """The text of a cell: the best of its states, or a square for each of their classes; × if all are unsafe."""
        safe = list(filter(self.is_safe, states))
        if not safe:
            return "×" if states else ""
        if name == "classes":
            marks = [c["mark"] for c in self.data["classes"] if any(self.holds(c["edge"], state) for state in safe)]
            several = "■" * len(marks) if len(marks) <= 4 else "■■■+"
            return marks[0] if len(marks) == 1 else several
        ranks = [self.context.analysis.levels(name).rank(self.one(state)) for state in safe]
        return "∞" if "unbounded" in ranks else str(max(ranks))

    def run(self, kind, variant, opponent):
        """The run is a path of the model from the opening state; one that improves follows its strategy."""
        context, path = self.context, [tuple(state) for state in self.data["play"]]
        if not path:
            return
        context.same("start of the run", tuple(self.data["at"]), path[0])
        machine = Machine(context.analysis, kind) if kind in ("sasi", "spi") else None
        memory = machine and machine.start(self.one(path[0]))
        for old, new in zip(path, path[1:]):
            if not context.same(f"a state of the run after {old}", True, new in self.of):
                return
            state, to = self.one(old), self.one(new)
            taken = context.relation.steps(self.of[old], self.of[new])
            context.same(f"a step of the run from {old} to {new}", True, bool(taken))
            if machine:
                permitted, progress = machine.permitted(state, memory)
                may = permitted if variant == "permissive" else progress
                if state in context.analysis.whole.theirs:
                    may = machine.answers(state, memory, opponent == "worst")
                context.same(f"the run follows its strategy from {old}", True, any(c.name in may for c in taken))
                memory = machine.after(state, memory, to)

    def heat(self):
        """The values of all states."""
        context, heat = self.context, self.data["heat"]
        if heat is None or context.case.settings["reward"] != "steps":
            return
        try:
            values = {self.numbers(key(entry["state"])): entry for entry in context.values["states"]}
        except Refused:
            return
        for measure in heat["measures"]:
            what, k = measure["id"][0], int(measure["id"][1:])
            for state, look in zip(map(tuple, heat["states"]), measure["all"]):
                levels = values[state]["levels"][k - 1 : k]
                bounds = levels[0][{"p": "probability", "c": "cost"}[what]] if levels else None
                text = measure["looks"][look]["text"]
                if bounds is not None or text == "–":
                    fits = stands_between(text, bounds, what == "p")
                    self.context.same(f"{measure['id']} of a page at {state}", True, fits)


def stands_between(text, bounds, is_probability):
    """Whether a value of a few digits lies between bounds, up to its last digit; `–` stands for none."""
    if text == "–" or bounds is None:
        return text == "–" and bounds is None
    lower, upper = (math.inf if x == "inf" else x for x in (bounds["lower"], bounds["upper"]))
    if text == ">0.99":
        return upper > 0.995 and lower < 1
    value = float(text)
    error = 0.005 if value < 1 else 0.05 if value < 100 else 0.5
    if "e" in text:
        error = 0.5 * 10 ** int(text.partition("e")[2])
    elif is_probability and text in ("0", "1"):
        error = 0
    return lower - error - 1e-5 <= value <= upper + error + 1e-5


MOVE = ("improves", "weakens", "sasi", "spi")
ALL = {"pages": pages}


def stands_for(name, choice):
    """Whether the name of a number, such as `a(m#1|m#2,n#1)`, stands for a choice, such as `a(m#2,n#1)`."""
    ours, theirs = (text.removesuffix(")").rpartition("(") for text in (name, choice))
    factors = list(zip(ours[2].split(","), theirs[2].split(",")))
    same = ours[0] == theirs[0] and ours[2].count(",") == theirs[2].count(",")
    return same and all(own in alternatives.split("|") for alternatives, own in factors)
