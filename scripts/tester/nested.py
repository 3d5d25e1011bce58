"""Properties as expressions over states: random ones with nested operators, filters and arithmetic, on every kind of
model, under both engines."""

import math
import random
from fractions import Fraction

from reference.model import explore
from reference.games import LeftOut
from reference.nested import Nested, TooLarge

MOST_STATES = 40
AMOUNT = 4
TEMPORAL = ("X", "F", "F", "G", "U", "U", "W", "R")
# Formulas that a finite part of a path decides; only these have values other than 0 and 1 in games.
DECIDED = (
    "(F {0}) & (F {1})", "F ({0} & X {1})", "X X {0}", "(F<=2 {0}) & (F {1})", "(F {0}) | (X {1})", "{0} U (X {1})",
    "G ({0} | X {1})", "(G {0}) | (G {1})",
)  # fmt: skip
RECURRING = (
    "G F {0}", "F G {0}", "(G F {0}) & (F {1})", "(G F {0}) | (F G {1})", "G ({0} => F {1})", "(F G {0}) & (G F {1})",
    "(F {0}) & (G {1})", "(G F {0}) & (G F {1})", "(G {0}) & (X {1})",
)  # fmt: skip


class Draw:
    """Draws properties for one model, as tuples of `reference.nested`."""

    def __init__(self, context, rng):
        self.context, self.rng = context, rng
        self.game = context.source.players or None
        self.structures = list(context.source.rewards)
        self.is_chain = context.case.kind == "dtmc"

    def condition(self, depth):
        rng = self.rng
        if depth == 0 or rng.random() < 0.2:
            return self.atom()
        kinds = ["not", "and", "or", "=>", "<=>", "bound", "bound", "bound", "A", "E", "filter", "compare"]
        kind = rng.choice(kinds)
        if kind == "not":
            return (kind, self.condition(depth - 1))
        if kind in ("and", "or", "=>", "<=>"):
            return (kind, self.condition(depth - 1), self.condition(depth - 1))
        if kind == "bound":
            bounds = [Fraction(0), Fraction(1), Fraction(1, 2), Fraction(rng.randint(1, 9), 10)]
            sign = rng.choice(["<=", "<", ">=", ">"])
            if self.structures and rng.random() < 0.2:
                return (kind, self.reward(depth, True), sign, rng.choice([*bounds, Fraction(3), Fraction(7, 2)]))
            return (kind, self.likely(depth), sign, rng.choice(bounds))
        if kind in ("A", "E"):
            return (kind, self.path(depth - 1))
        if kind == "filter":
            return (kind, rng.choice(["forall", "exists"]), self.condition(depth - 1), self.condition(depth - 1))
        return (kind, rng.choice(["<=", "<", ">=", ">"]), self.number(depth - 1), self.number(depth - 1))

    def atom(self):
        variable = self.rng.choice(self.context.source.variables)
        if variable.kind == "bool":
            return ("is", variable.name)
        value = self.rng.randint(variable.low, variable.high)
        return ("is", f"{variable.name} {self.rng.choice(['=', '<=', '!='])} {value}")

    def number(self, depth):
        rng = self.rng
        if depth == 0 or rng.random() < 0.2:
            return ("number", Fraction(rng.randint(0, 8), 4))
        kind = rng.choice(["+", "-", "*", "value", "value", "filter"])
        if kind == "value":
            earns = self.structures and rng.random() < 0.4
            return (kind, self.reward(depth, False) if earns else self.likely(depth))
        if kind == "filter":
            function = rng.choice(["min", "max", "sum", "avg", "count"])
            of = self.condition(depth - 1) if function == "count" else self.number(depth - 1)
            return (kind, function, of, self.condition(depth - 1) if function in ("sum", "count") else ("is", "true"))
        return (kind, self.number(depth - 1), self.number(depth - 1))

    def players(self):
        if not self.game or self.rng.random() < 0.15:
            return None
        return frozenset(at for at, _ in enumerate(self.game) if self.rng.random() < 0.6)

    def likely(self, depth):
        """A probability: of a path, or of a chain in the long run."""
        if self.is_chain and self.rng.random() < 0.25:
            return ("S", None, "max", self.condition(depth - 1))
        path = self.formula(depth - 1) if self.rng.random() < 0.3 else self.path(depth - 1)
        return ("P", self.players(), self.rng.choice(["max", "min"]), path)

    def reward(self, depth, infinite):
        """Rewards of a number of steps, of the last state, and of the long run; those of all steps, and until a target,
        may be infinite."""
        rng, name = self.rng, self.rng.choice(self.structures)
        kinds = ["C", "I"] + ["average"] * self.is_chain + ["total"] * (self.is_chain and infinite)
        kind = rng.choice(kinds + ["until"] * (infinite and not self.game))
        accumulated = {"average": ("S", None), "total": ("C", None)}.get(kind) or (kind, rng.randint(0, 4))
        if kind == "until":
            accumulated = ("F", self.condition(depth - 1))
        return ("R", self.players(), rng.choice(["max", "min"]), name, accumulated)

    def formula(self, depth):
        """A formula with several temporal operators."""
        text = self.rng.choice(DECIDED if self.game else DECIDED + RECURRING)
        return ("ltl", text, *(self.condition(min(depth, 1)) for _ in range(text.count("{"))))

    def path(self, depth):
        name = self.rng.choice(TEMPORAL)
        if name == "X":
            return (name, self.condition(depth))
        least = self.rng.choice([0, 0, 0, 1, 2])
        most = self.rng.choice([None, None, least, least + 1, least + 3])
        sides = [self.condition(depth) for _ in range(1 if name in ("F", "G") else 2)]
        return (name, least, most, *sides)


class Text:
    """Writes properties in the syntax of PRISM."""

    def __init__(self, context):
        self.program, self.game = context.program, list(context.source.players or ())
        self.is_chain = context.case.kind == "dtmc"

    def condition(self, c):
        kind = c[0]
        if kind == "is":
            return f"({c[1]})"
        if kind == "not":
            return f"!{self.condition(c[1])}"
        if kind in ("and", "or", "=>", "<=>"):
            return f"({self.condition(c[1])} { {'and': '&', 'or': '|'}.get(kind, kind)} {self.condition(c[2])})"
        if kind == "compare":
            return f"({self.number(c[2])} {c[1]} {self.number(c[3])})"
        if kind == "bound":
            return f"({self.operator(c[1], c[2], c[3])})"
        if kind in ("A", "E"):
            return f"({kind} [ {self.path(c[1])} ])"
        return f"filter({c[1]}, {self.condition(c[2])}, {self.condition(c[3])})"

    def number(self, n):
        kind = n[0]
        if kind == "number":
            return str(float(n[1]))
        if kind == "value":
            return self.operator(n[1])
        if kind == "filter":
            of = self.condition(n[2]) if n[1] == "count" else self.number(n[2])
            return f"filter({n[1]}, {of}, {self.condition(n[3])})"
        return f"({self.number(n[1])} {kind} {self.number(n[2])})"

    def operator(self, operator, sign="=", bound="?"):
        kind, ours, optimum, *rest = operator
        lower = sign in (">", ">=")
        named = "" if self.is_chain else optimum
        before = ""
        if ours is not None:
            before = f"<<{','.join(self.game[at] for at in sorted(ours))}>> "
            named = named if sign == "=" else ""
        end = f"{sign}{bound if bound == '?' else float(bound)}"
        assert ours is None or sign == "=" or lower == (optimum == "max")
        if kind == "P":
            return f"{before}P{named}{end} [ {self.path(rest[0])} ]"
        if kind == "S":
            return f"S{end} [ {self.condition(rest[0])} ]"
        structure, (what, steps) = rest
        if what == "F" or steps is None:
            inside = f"F {self.condition(steps)}" if what == "F" else what
            return f'{before}R{{"{structure}"}}{named}{end} [ {inside} ]'
        return f'{before}R{{"{structure}"}}{named}{end} [ {what}{"<=" if what == "C" else "="}{steps} ]'

    def path(self, path):
        name = path[0]
        if name == "ltl":
            return path[1].format(*map(self.condition, path[2:]))
        if name == "X":
            return f"X {self.condition(path[1])}"
        _, least, most, *sides = path
        steps = f">={least}" if most is None and least else "" if most is None else f"[{least},{most}]"
        if name in ("F", "G"):
            return f"{name}{steps} {self.condition(sides[0])}"
        return f"{self.condition(sides[0])} {name}{steps} {self.condition(sides[1])}"


def decided(c, game):
    """The same property, in which the players of a game look for what a bound asks of them."""
    if not isinstance(c, tuple) or not game:
        return c
    parts = tuple(decided(part, game) for part in c)
    if parts[0] == "bound" and parts[1][1] is not None:
        operator = list(parts[1])
        operator[2] = "max" if parts[2] in (">", ">=") else "min"
        return ("bound", tuple(operator), *parts[2:])
    return parts


def drawn(context):
    """A file of random properties, each with its answer, and a condition with the number of states that satisfy it."""
    if context.is_rare():
        return None, [], None
    mdp = explore(context.source, context.case.settings["scope"], 3000)
    if len(mdp.values) > MOST_STATES:
        return None, [], None
    rng = random.Random(context.case.seed)
    draw, text, known = Draw(context, rng), Text(context), Nested(mdp, context.case.settings["scope"])
    file, expected, satisfied = context.program.folder / "nested.props", [], None
    for at in range(AMOUNT):
        try:
            is_number = at % 2 == 1
            drawn = draw.number(2) if is_number else draw.condition(3)
            drawn = decided(drawn, draw.game)
            if is_number:
                values = known.numbers(drawn)
                expected.append((text.number(drawn), [values[s] for s in mdp.initial]))
            else:
                holds = known.holds(drawn)
                written = text.condition(drawn)
                expected.append((written, set(mdp.initial) <= holds))
                # `true & P>1 [ a ]` is one operator, whose regions have other names.
                is_joint = drawn[0] in ("and", "or", "=>", "<=>") and written.count("[") > 1
                if is_joint or drawn[0] == "compare":
                    satisfied = (written, len(holds))
        except (TooLarge, OverflowError, LeftOut):
            continue
    file.write_text("".join(f"{written};\n" for written, _ in expected))
    return file, expected, satisfied


def nested(context):
    """Verdicts and numbers of random properties are those of the definition."""
    file, expected, satisfied = drawn(context)
    if not expected:
        return
    context.case.features.add("nested properties")
    for what, answer, entry in answered(context, file, expected):
        compare(context, what, answer, entry)
    if satisfied:
        written_as(context, *satisfied)


def answered(context, file, expected, allowed=(0, 1)):
    """The answers to a file of properties under both engines, each with the expected answer."""
    for engine in ("explicit", "symbolic"):
        options = ["--properties", file, "--engine", engine, *context.program.settings("scope", "threads")]
        report = context.program.ask("reach", context.program.model, *options, allowed=allowed)
        for (written, answer), entry in zip(expected, report["properties"]):
            yield f"{written} ({engine})", answer, entry


def asked(context):
    """The same of `Model.ask` in Python: of a file, and of one property alone."""
    import meliora

    file, expected, _ = drawn(context)
    if not expected:
        return
    model = meliora.Model.from_file(context.program.model)
    scope = context.case.settings["scope"]
    for (written, answer), entry in zip(expected, model.ask(file=file, scope=scope)):
        compare(context, f"{written} (in a file)", answer, entry)
    written, answer = random.Random(context.case.seed).choice(expected)
    try:
        entry = model.ask(written, scope=scope)
    except (meliora.InputError, meliora.UsageError) as error:
        entry = {"holds": None, "reason": str(error)}
    compare(context, f"{written} (alone)", answer, entry)


def written_as(context, written, count):
    """`--out` writes the states that satisfy a condition."""
    dump = context.program.folder / "satisfied"
    options = ["--out", dump, *context.program.settings("scope", "threads")]
    context.program.ask("reach", context.program.model, "--property", written, *options, allowed=(0, 1))
    found = context.program.ask("query", dump, "satisfied")
    context.same(f"states that satisfy {written}", str(count), found["count"])


def compare(context, what, answer, entry):
    if isinstance(answer, bool):
        context.same(what, answer, entry["holds"] if entry["holds"] is not None else entry.get("reason"))
        return
    found = entry.get("value")
    if not found:
        context.same(what, [str(value) for value in answer], entry.get("reason"))
        return
    lower, upper = (math.inf if x == "inf" else Fraction(x) for x in (found["lower"], found["upper"]))
    slack = Fraction(1, 10**5)
    inside = lower <= min(answer) and max(answer) <= upper
    narrow = lower == upper or upper - lower <= max(answer) - min(answer) + slack * max(1, abs(lower))
    context.same(what, "", "" if inside and narrow else f"{found}, not {[str(value) for value in answer]}")


ALL = {"nested": nested, "asked": asked}
