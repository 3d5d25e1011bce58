"""Temporal formulas for the reference: two readings of them, neither by the monitors of the Rust program.

`holds` is the definition of linear temporal logic on ultimately periodic words. `observer` learns from it alone
how many beginnings of a word must be told apart: a beginning is known by which of many endings satisfy the formula.
`Search` is a nondeterministic automaton, a tableau in the manner of Couvreur, that a strategy may run beside a play:
first all its runs at once, then those from one state that was guessed, with breakpoints (Courcoubetis and Yannakakis).

Formulas are tuples in negation normal form: ("true",), ("false",), ("is", atom, sign), ("and", f, g), ("or", f, g),
("X", f), ("U", f, g) and ("R", f, g); an atom is the text of a condition on a state.
"""

import itertools

from reference_lang import InputError, tokens_of

PREFIX, INFIX = {"X", "F", "G"}, {"U", "W", "R"}
TRUE, FALSE = ("true",), ("false",)
DUAL = {"and": "or", "or": "and", "U": "R", "R": "U", "X": "X", "true": "false", "false": "true"}


def is_temporal(tokens):
    return any(t in PREFIX | INFIX for t in tokens)


def parse(text):
    return read(tokens_of(text))


def read(tokens):
    """F, G and X apply to all that follows; operators bind as in PRISM."""
    if not is_temporal(tokens):
        return ("is", " ".join(tokens), True)
    depth, places = 0, []
    for place, token in enumerate(tokens):
        depth += (token in "([") - (token in ")]")
        if depth == 0 and token in PREFIX:
            break
        if depth == 0:
            places.append(place)
    for operator in ["U", "W", "R", "=>", "<=>", "|", "&"]:
        for place in places:
            if tokens[place] == operator:
                return joined(operator, read(tokens[:place]), read(tokens[place + 1 :]))
    if tokens[0] == "!":
        return negated(read(tokens[1:]))
    if tokens[0] in PREFIX:
        if tokens[1] in ("<", "<=", ">", ">=", "=", "["):
            raise InputError("bounds on the number of steps are not understood")
        inner = read(tokens[1:])
        return {"X": ("X", inner), "F": ("U", TRUE, inner), "G": ("R", FALSE, inner)}[tokens[0]]
    if (tokens[0], tokens[-1]) == ("(", ")"):
        return read(tokens[1:-1])
    raise InputError(f"`{' '.join(tokens)}` is not understood")


def joined(operator, a, b):
    if operator == "=>":
        return ("or", negated(a), b)
    if operator == "<=>":
        return ("or", ("and", a, b), ("and", negated(a), negated(b)))
    if operator == "W":
        return ("R", b, ("or", a, b))
    return ({"&": "and", "|": "or"}.get(operator, operator), a, b)


def negated(f):
    if f[0] == "is":
        return ("is", f[1], not f[2])
    return (DUAL[f[0]], *map(negated, f[1:]))


def parts(f):
    return {f}.union(*map(parts, () if f[0] == "is" else f[1:]))


def atoms(f):
    return sorted({g[1] for g in parts(f) if g[0] == "is"})


def leaves(f):
    """Splits f at `&` and `|`, one monitor per part; a safe conjunction or co-safe disjunction stays whole."""
    lost = {"and": "U", "or": "R"}.get(f[0])  # a conjunction without U is safe, a disjunction without R is co-safe
    if lost is None or all(g[0] != lost for g in parts(f)):
        return [f]
    return [leaf for g in operands(f[0], f) for leaf in leaves(g)]


def operands(kind, f):
    return operands(kind, f[1]) + operands(kind, f[2]) if f[0] == kind else [f]


def holds(f, word, back):
    """Returns for each letter whether f holds there; after its last letter the word continues at `back`."""
    kind, size = f[0], len(word)
    if kind in ("true", "false"):
        return [kind == "true"] * size
    if kind == "is":
        return [letter[f[1]] == f[2] for letter in word]
    inner = [holds(g, word, back) for g in f[1:]]
    if kind == "and":
        return [x and y for x, y in zip(*inner)]
    if kind == "or":
        return [x or y for x, y in zip(*inner)]
    after = [*range(1, size), back]
    if kind == "X":
        return [inner[0][i] for i in after]
    found = [kind == "R"] * size
    for _ in range(2):  # once round the loop, and once more
        for i in reversed(range(size)):
            x, y, then = inner[0][i], inner[1][i], found[after[i]]
            found[i] = y or x and then if kind == "U" else y and (x or then)
    return found


def observer(f):
    """Returns `(atoms, steps)`: for each state, initial state first, the successor by each letter."""
    return learned(f)[:2]


def refuted(f):
    """The states of the observer after which no word satisfies the formula."""
    return learned(f)[2]


def learned(f):
    """The observer, and its states without a satisfying word."""
    names = atoms(f)
    if len(names) > 3:
        raise InputError(f"{len(names)} conditions in one leaf are too many to learn from all short words")
    letters = [dict(zip(names, signs)) for signs in itertools.product((False, True), repeat=len(names))]
    pairs = [list(itertools.product(letters, repeat=n)) for n in range(3)]
    endings = [(stem, loop) for stem in sum(pairs, []) for loop in pairs[1] + pairs[2]]

    def known_by(beginning):
        return tuple(holds(f, [*beginning, *s, *o], len(beginning) + len(s))[0] for s, o in endings)

    number, beginnings, steps = {known_by([]): 0}, [[]], []
    for beginning in beginnings:  # grows while we walk it
        row = []
        for letter in letters:
            key = known_by([*beginning, letter])
            if key not in number:
                number[key] = len(number)
                beginnings.append([*beginning, letter])
            row.append(number[key])
        steps.append(tuple(row))
    return tuple(names), tuple(steps), {state for key, state in number.items() if not any(key)}


class Search:
    """The automaton of a formula. Its states are `(runs, None)`, all runs at once, and `(runs, (seen, due))`: all runs
    from one state, those of them that did not postpone the until `due` since the last breakpoint."""

    def __init__(self, f):
        self.start = (frozenset([frozenset([f])]), None)
        self.names, self.known = atoms(f), {}
        self.untils = sorted(g for g in parts(f) if g[0] == "U") or [None]

    def guesses(self, state):
        runs, later = state
        return [(frozenset([run]), (frozenset(), 0)) for run in runs] if later is None else []

    def read(self, state, letter):
        """The next state, and whether a breakpoint is reached; None where every run ends."""
        runs, later = state
        moves = {run: self.moves(run, letter) for run in runs}
        after = frozenset(then for run in runs for then, _ in moves[run])
        if not after:
            return None
        if later is None:
            return (after, None), False
        seen, due = later
        kept = {then for run in seen for then, _ in moves[run]}
        kept |= {then for run in runs for then, put_off in moves[run] if self.untils[due] not in put_off}
        if kept == after:
            return (after, (frozenset(), (due + 1) % len(self.untils))), True
        return (after, (frozenset(kept), due)), False

    def moves(self, run, letter):
        """The possible obligations of a set of formulas on the next state, with the postponed untils."""
        key = (run, tuple(letter[name] for name in self.names))
        if key not in self.known:
            self.known[key] = both(*(expanded(f, letter) for f in run))
        return self.known[key]


def both(*choices):
    found = {(frozenset(), frozenset())}
    for options in choices:
        found = {(a | c, b | d) for a, b in found for c, d in options}
    return found


def expanded(f, letter):
    nothing, again = frozenset(), frozenset([f])
    if f[0] in ("true", "false"):
        return {(nothing, nothing)} if f[0] == "true" else set()
    if f[0] == "is":
        return {(nothing, nothing)} if letter[f[1]] == f[2] else set()
    if f[0] == "X":
        return {(frozenset([f[1]]), nothing)}
    left, right = expanded(f[1], letter), expanded(f[2], letter)
    if f[0] == "and":
        return both(left, right)
    if f[0] == "or":
        return left | right
    if f[0] == "U":
        return right | both(left, {(again, again)})
    return both(right, left | {(again, nothing)})
