"""Section 3: preference files, the preorder of objectives, and the comparison of classes."""

import itertools
import re
from dataclasses import dataclass, field

from reference.prism import InputError, tokens_of
from reference.temporal import is_temporal


@dataclass
class Preferences:
    objectives: list  # of (name, text of the formula)
    strict: set  # pairs (i, j): i is strictly preferred to j
    empty: str = "bottom"
    history: str = "state"
    required: list = field(default_factory=list)  # texts of formulas
    coalition: list = field(default_factory=list)  # the players that we are; empty for the first one

    @property
    def names(self):
        return [name for name, _ in self.objectives]

    def most_preferred(self, outcomes):
        """MP: the outcomes to which no outcome is strictly preferred."""
        return frozenset(i for i in outcomes if not any((j, i) in self.strict for j in outcomes))

    def improves(self, old, new):
        if not old and new:
            return self.empty in ("bottom", "gain")
        return any((j, i) in self.strict for i in old for j in new)

    def weakens(self, old, new):
        if old and not new:
            return self.empty == "bottom"
        return any((i, j) in self.strict for i in old for j in new)

    def change(self, old, new):
        """One step can do both; then it counts as a weakening."""
        return "weakening" if self.weakens(old, new) else "improving" if self.improves(old, new) else "lateral"


def target_of(formula):
    """The condition of `F condition`; None for every other formula."""
    first, *condition = tokens_of(formula)
    if first != "F" or is_temporal(condition) or condition[:1] and condition[0] in ("<", "<=", ">", ">=", "=", "["):
        return None
    return " ".join(condition)


def read_preferences(path):
    with open(path, encoding="utf-8") as file:
        return preferences_of(file.read())


def preferences_of(text):
    found, names, pairs, stated, history = Preferences([], set()), {}, set(), set(), None
    text = re.sub(r"//[^\n]*", "", text)
    for statement in filter(None, map(str.strip, text.split(";"))):
        word, rest = re.match(r"(\w+)\s*(.*)", statement, re.DOTALL).groups()
        setting = re.fullmatch(r"(empty|history)\s*=\s*(\w+)", statement)
        if word == "objective":
            name, _, formula = (x.strip() for x in rest.partition("="))
            names[name] = len(found.objectives)
            found.objectives.append((name, formula))
        elif word == "prefer":
            weak, strict = statement_of(rest, names)
            pairs, stated = pairs | weak, stated | strict
        elif word == "require":
            found.required.append(rest)
        elif word == "coalition":
            found.coalition = [name.strip() for name in rest.split(",")]
        elif setting and setting[2] in ("bottom", "gain", "incomparable"):
            found.empty = setting[2]
        elif setting and setting[2] in ("state", "play"):
            history = setting[2]
        else:
            raise InputError(f"`{statement}` is not understood in a preference file")
    found.strict = strict_part(pairs, len(found.objectives))
    if not stated <= found.strict:
        raise InputError("the preferences contradict each other")
    found.history = history or ("state" if all(target_of(f) for _, f in found.objectives) else "play")
    return found


def statement_of(text, names):
    """The pairs x >= y and the pairs x > y that a statement `prefer` states; `x ~ y` is x >= y and y >= x."""
    groups, pairs, strict = re.split(r"(>=|>|~)", text), set(), set()
    for left, operator, right in zip(groups[::2], groups[1::2], groups[2::2]):
        for a, b in itertools.product(left.split(","), right.split(",")):
            i, j = names[a.strip()], names[b.strip()]
            pairs |= {(i, j), (j, i)} if operator == "~" else {(i, j)}
            strict |= {(i, j)} if operator == ">" else set()
    return pairs, strict


def strict_part(pairs, size):
    """The strict part of the transitive closure."""
    closure = set(pairs)
    for k, i, j in itertools.product(range(size), repeat=3):
        if (i, k) in closure and (k, j) in closure:
            closure.add((i, j))
    return {(i, j) for i, j in closure if (j, i) not in closure}
