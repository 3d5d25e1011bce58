"""What the checks of a case share: the reference's analysis, the program's answers, and found differences."""

import functools
import math
from collections.abc import KeysView
from dataclasses import dataclass
from fractions import Fraction

from reference.analysis import Analysis
from reference.leaves import cases, conditions
from reference.preferences import preferences_of
from reference.prism import program_of
from reference.quantities import Quantities
from tester.program import Named, Refused, Relation, at, key

LEVELS, WITHIN = 3, 4


@dataclass
class Difference:
    check: str
    what: str
    expected: object
    got: object
    command: list

    def __str__(self):
        return f"{self.check}: {self.what}: expected {self.expected}, got {self.got}"


def kept(value):
    """A value that another process can be told: the keys of a dictionary as a set."""
    return set(value) if isinstance(value, KeysView) else value


class Context:
    """One case under test. A check calls `same` for everything that it compares."""

    def __init__(self, case, program, source=None):
        self.case, self.program = case, program
        self.differences, self.compared, self.check = [], {}, ""
        self.preferences = preferences_of(case.preferences_text())
        self.names = self.preferences.names
        self.source = source or program_of(case.model_text(), {})
        self.is_game = case.kind == "smg"
        self.coalition = list(filter(None, case.settings["coalition"].split(",")))
        self.analysis = self.analysis_of(self.source)
        self.coalition = self.coalition or self.preferences.coalition
        self.ours = self.source.named_players(self.coalition)  # the positions of the players that we are

    def analysis_of(self, source):
        settings = self.case.settings
        return Analysis(source, self.preferences, settings["scope"], settings["safety"], 3000, self.coalition)

    def same(self, what, expected, got):
        self.compared[self.check] = self.compared.get(self.check, 0) + 1
        if expected != got:
            command = self.program.asked[-1] if self.program.asked else []
            self.differences.append(Difference(self.check, what, kept(expected), kept(got), command))
        return expected == got

    def within(self, what, value, bounds, precision=Fraction(1, 10**6)):
        """Bounds contain a value of the reference, None where there is none, and are narrow."""
        if value is None or bounds is None:
            return self.same(what, value, bounds)
        if "exact" in bounds:
            self.same(what, value, Fraction(bounds["exact"]))
        lower, upper = (math.inf if x == "inf" else Fraction(x) for x in (bounds["lower"], bounds["upper"]))
        narrow = lower == upper or value == math.inf or upper - lower <= precision * max(1, lower)
        inside = lower <= value <= upper
        return self.same(what, "" if inside and narrow else shown(value), "" if inside and narrow else bounds)

    @functools.cached_property
    def values(self):
        """`values --all`, for some cases in fractions."""
        exact = ["--exact"] if self.case.seed % 3 == 0 else []
        options = ["--all", "--levels", LEVELS, "--within", WITHIN, *self.program.settings("reward")]
        try:
            return self.program.about("values", *options, *exact)
        except Refused as refused:
            if not self.is_rare() or exact or "apart, more than the precision" not in str(refused):
                raise
            return self.program.about("values", *options, "--exact")  # as the refusal says

    # Bounded: the cache keeps the objects whose methods it remembers.
    @functools.lru_cache(maxsize=16)
    def strategy(self, *options):
        """`strategy` in every state, by state."""
        states = [text for entry in self.check_states for text in ("--at", at(entry))]
        found = self.program.about("strategy", *options, *states)["states"]
        return {key(entry["state"]): entry for entry in found}

    @functools.cached_property
    def check_states(self):
        """All states of the scope. Ranks are those of every state, whether values can be computed or not."""
        entries = [entry["state"] for entry in self.report["initial"]]
        found, todo = {key(s): s for s in entries}, list(entries)
        if self.case.settings["scope"] == "all":
            for values in self.source.all_states():
                state = {**entries[0], **self.source.named(values)}
                if key(state) not in found:
                    found[key(state)] = state
                    todo.append(state)
        while todo:
            asked = [text for state in todo for text in ("--at", at(state))]
            answer, todo = self.program.about("strategy", *asked)["states"], []
            for entry in answer:
                for successor in (s["state"] for a in entry["actions"] for s in a["successors"]):
                    if key(successor) not in found:
                        found[key(successor)] = successor
                        todo.append(successor)
        return list(found.values())

    @functools.cached_property
    def report(self):
        return self.program.about("check")

    @functools.cached_property
    def relation(self):
        if self.program.plays("strategy"):
            return Relation(self.analysis, self.strategy("--kind", "sasi"), self.report["initial"][0]["state"])
        if self.analysis.play:
            raise Refused("`strategy` of a game is not supported")
        return Named(self.analysis)

    @functools.cached_property
    def quantities(self):
        return Quantities(self.analysis, self.case.settings["reward"])

    @functools.cached_property
    def probabilities(self):
        return self.quantities.probabilities(LEVELS)

    @functools.cached_property
    def costs(self):
        return self.quantities.costs(self.probabilities)

    @functools.cached_property
    def steps(self):
        """The least expected numbers of steps with which choices by value attain it."""
        plain = Quantities(self.analysis)
        costs = {"cheap": self.costs, "likely": plain.costs(self.probabilities)}
        return {choose: plain.steps(self.probabilities, paid) for choose, paid in costs.items()}

    def features(self):
        """What the reference finds in the case."""
        analysis = self.analysis
        levels = {kind: analysis.levels(kind).sets for kind in ("sasi", "spi")}
        found = {
            "deadlock": analysis.whole.deadlocks,
            "some states unsafe": 0 < len(analysis.mdp.unsafe) < len(analysis.whole.values),
            "SASI improvements": levels["sasi"],
            "SPI improvements": len(levels["spi"]) > len(levels["sasi"]),
            "the opponent moves": analysis.whole.theirs,
            "bad states": analysis.bad,
        }
        return {name for name, holds in found.items() if holds}

    def secured(self, number):
        """The target of an objective; None if it depends on the monitors: before the marks of a leaf of the kind
        persistence cease, there may be any number of them, and formulas of no class have several normal forms."""
        leaves = [leaf for case in cases(conditions(self.analysis.formulas[number])) for leaf in case]
        is_general = "objective general" in self.case.features
        is_open = self.analysis.play and (self.is_game or is_general or any(kind == "finally" for kind, _ in leaves))
        return None if is_open else self.analysis.targets[number]

    def named(self, members):
        return [self.names[i] for i in sorted(members or ())]

    def is_rare(self):
        """Whether some branch is so rare that doubles and simulations do not see it."""
        return any("e-400" in text or "(1-(1-1e-17))" in text for _, text in self.case.commands)


def shown(value):
    return value if value == math.inf else f"{value} = {float(value)}"
