"""Section 8: formulas of linear temporal logic, and the deterministic monitors of their leaves.

Formulas are tuples in negation normal form: ("true",), ("false",), ("is", condition, sign), ("and", f, g),
("or", f, g), ("X", f), ("U", f, g) and ("W", f, g). A condition is a text in the names of the program.
"""

import itertools
import re

from reference.prism import InputError, tokens_of

PREFIX, INFIX = {"X", "F", "G"}, {"U", "W", "R", "M"}
TRUE, FALSE = ("true",), ("false",)


def is_temporal(tokens):
    return any(t in PREFIX | INFIX for t in tokens)


def parse(text):
    return read(tokens_of(text))


def read(tokens):
    """F, G and X apply to all that follows; operators bind as in PRISM."""
    if not is_temporal(tokens):
        return literal(tokens)
    depth, places = 0, []
    for place, token in enumerate(tokens):
        depth += (token in "([") - (token in ")]")
        if depth == 0 and token in PREFIX:
            break
        if depth == 0:
            places.append(place)
    for operator in ["U", "W", "R", "M", "=>", "<=>", "|", "&"]:
        for place in places:
            if tokens[place] == operator:
                bound, rest = bound_of(tokens[place + 1 :]) if operator in INFIX else (None, tokens[place + 1 :])
                return joined(operator, read(tokens[:place]), read(rest), bound)
    if tokens[0] == "!":
        return negated(read(tokens[1:]))
    if tokens[0] in PREFIX:
        bound, rest = bound_of(tokens[1:])
        inner = read(rest)
        if tokens[0] == "X":
            return ("X", inner)
        return (
            joined("U", TRUE, inner, bound) if tokens[0] == "F" else negated(joined("U", TRUE, negated(inner), bound))
        )
    if (tokens[0], tokens[-1]) == ("(", ")"):
        return read(tokens[1:-1])
    raise InputError(f"`{' '.join(tokens)}` is not understood")


def literal(tokens):
    text = " ".join(tokens)
    if text in ("true", "false"):
        return (text,)
    return ("is", text, True)


def bound_of(tokens):
    """`<=k`, `<k`, `>=k`, `>k`, `=k` or `[a,b]` at the head of some tokens, as (least, most or None), and the rest."""
    text = " ".join(tokens)
    found = re.match(r"(<=|<|>=|>|=) (\d+) ", text)
    if found:
        k = int(found[2])
        return {"<=": (0, k), "<": (0, k - 1), ">=": (k, None), ">": (k + 1, None), "=": (k, k)}[found[1]], tokens[2:]
    found = re.match(r"\[ (\d+) , (\d+) \] ", text)
    return ((int(found[1]), int(found[2])), tokens[5:]) if found else (None, tokens)


def conjunction(a, b):
    return FALSE if FALSE in (a, b) else a if b == TRUE else b if a == TRUE else ("and", a, b)


def disjunction(a, b):
    return TRUE if TRUE in (a, b) else a if b == FALSE else b if a == FALSE else ("or", a, b)


def joined(operator, a, b, bound=None):
    if bound is not None:
        return bounded(operator, a, b, *bound)
    return {
        "=>": lambda: disjunction(negated(a), b),
        "<=>": lambda: disjunction(conjunction(a, b), conjunction(negated(a), negated(b))),
        "R": lambda: ("W", b, conjunction(a, b)),
        "M": lambda: ("U", b, conjunction(a, b)),
        "&": lambda: conjunction(a, b),
        "|": lambda: disjunction(a, b),
        "U": lambda: ("U", a, b),
        "W": lambda: ("W", a, b),
    }[operator]()


def bounded(operator, a, b, least, most):
    """An operator with a bound on the number of steps, written out with X."""
    if operator == "R":
        return negated(bounded("U", negated(a), negated(b), least, most))
    if operator != "U":
        raise InputError(f"bounds of {operator} are not understood")
    if least > 0:
        return conjunction(a, ("X", bounded("U", a, b, least - 1, None if most is None else most - 1)))
    if most is None:
        return ("U", a, b)
    if most < 0:
        return FALSE
    return b if most == 0 else disjunction(b, conjunction(a, ("X", bounded("U", a, b, 0, most - 1))))


def negated(f):
    """The negation in normal form: !(a U b) = !b W (!a & !b), !(a W b) = !b U (!a & !b)."""
    kind = f[0]
    if kind in ("true", "false"):
        return FALSE if kind == "true" else TRUE
    if kind == "is":
        return ("is", f[1], not f[2])
    if kind == "X":
        return ("X", negated(f[1]))
    a, b = negated(f[1]), negated(f[2])
    if kind in ("and", "or"):
        return disjunction(a, b) if kind == "and" else conjunction(a, b)
    return ("W" if kind == "U" else "U", b, conjunction(a, b))


def parts(f):
    return {f}.union(*map(parts, () if f[0] == "is" else f[1:]))


def atoms(f):
    return sorted({g[1] for g in parts(f) if g[0] == "is"})


def nests(f, outer, inner):
    """Whether an operator stands below another one."""
    return any(g[0] == outer and any(h[0] == inner for h in parts(g)) for g in parts(f))


def is_pi2(f):
    return not nests(f, "U", "W")


def is_sigma2(f):
    return not nests(f, "W", "U")


# A formula up to propositional equivalence: the set of its minimal disjuncts, each a set of formulas that are not
# conjunctions or disjunctions. Formulas in negation normal form are monotone, so this form is canonical.

YES, NO = frozenset([frozenset()]), frozenset()


def absorbed(disjuncts):
    disjuncts = set(disjuncts)
    return frozenset(d for d in disjuncts if not any(e < d for e in disjuncts))


def either(a, b):
    return absorbed(a | b)


def both(a, b):
    return absorbed(d | e for d in a for e in b)


def canonical(f, leaf=lambda g: frozenset([frozenset([g])])):
    """The canonical form of f, in which each leaf stands for what a function says."""
    if f[0] in ("true", "false"):
        return YES if f[0] == "true" else NO
    if f[0] == "and":
        return both(canonical(f[1], leaf), canonical(f[2], leaf))
    if f[0] == "or":
        return either(canonical(f[1], leaf), canonical(f[2], leaf))
    return leaf(f)


def replaced(form, leaf):
    """A form in which each member of a disjunct is replaced by a form."""
    found = NO
    for disjunct in form:
        every = YES
        for member in disjunct:
            every = both(every, leaf(member))
        found = either(found, every)
    return found


def progressed(f, letter):
    """Progression: the form that must hold after a letter, so that this one holds before it."""

    def after(g):
        if g[0] == "is":
            return YES if letter[g[1]] == g[2] else NO
        if g[0] == "X":
            return canonical(g[1])
        again, now = frozenset([frozenset([g])]), canonical(g[2], after)
        return either(now, both(canonical(g[1], after), again))

    return replaced(f, after)


def owed(form):
    """A form in which every W is replaced by true."""

    def without(g):
        if g[0] == "W":
            return YES
        if g[0] == "X":
            inner = canonical(g[1], without)
            return YES if inner == YES else frozenset([frozenset([("X", formula_of(inner))])])
        return frozenset([frozenset([g])])  # a U has no W below it

    return replaced(form, without)


def formula_of(form):
    found = FALSE
    for disjunct in sorted(map(sorted, form), key=repr):
        every = TRUE
        for member in disjunct:
            every = conjunction(every, member)
        found = disjunction(found, every)
    return found


class Monitor:
    """The deterministic monitor of a Pi2 formula: the formula holds iff marks occur again and again.

    A state is a pair of what must hold from here on, and what of it is owed since the last mark.
    """

    def __init__(self, formula):
        if not is_pi2(formula):
            raise InputError("a U stands above a W")
        self.formula, self.atoms = formula, atoms(formula)
        self.start = (canonical(formula), owed(canonical(formula)))
        self.known = {}

    def letter(self, holds):
        return tuple(bool(holds(name)) for name in self.atoms)

    def read(self, state, letter):
        """The next state, and whether this step is marked."""
        if (state, letter) not in self.known:
            signs = dict(zip(self.atoms, letter))
            must, due = (progressed(form, signs) for form in state)
            marked = due == YES
            self.known[state, letter] = ((must, owed(must) if marked else due), marked)
        return self.known[state, letter]

    def steps(self):
        """The states that some word leads to, each with its successors."""
        letters = list(itertools.product((False, True), repeat=len(self.atoms)))
        steps, todo = {}, [self.start]
        while todo:
            state = todo.pop()
            if state not in steps:
                steps[state] = {self.read(state, letter)[0] for letter in letters}
                todo += steps[state]
        return steps

    def accepts(self, state, stem, loop):
        """Whether marks occur again and again on a word that is read from a state on."""
        for letter in stem:
            state, _ = self.read(state, letter)
        seen, marks = {}, []
        while state not in seen:
            seen[state] = len(marks)
            marks.append(False)
            for letter in loop:
                state, marked = self.read(state, letter)
                marks[-1] |= marked
        return any(marks[seen[state] :])

    def residuals(self):
        """For each state, what tells it from the others: which of many words may follow."""
        if not hasattr(self, "told"):
            letters = list(itertools.product((False, True), repeat=len(self.atoms)))
            words = [list(itertools.product(letters, repeat=n)) for n in range(3)]
            endings = [(stem, loop) for stem in sum(words, []) for loop in words[1] + words[2]]
            self.told = {s: tuple(self.accepts(s, *ending) for ending in endings) for s in self.steps()}
        return self.told

    def refuted(self):
        """The states after which no word satisfies the formula, if it is safe."""
        steps = self.steps()
        hopeful = {s for s in steps if s[0] != NO}
        while True:
            fewer = {s for s in hopeful if steps[s] & hopeful}
            if fewer == hopeful:
                return steps.keys() - hopeful
            hopeful = fewer


def is_safe(f):
    return all(g[0] != "U" for g in parts(f))


def is_cosafe(f):
    return all(g[0] != "W" for g in parts(f))


def is_invariant(f):
    """Whether a formula is `G p` with a condition p."""
    return f[0] == "W" and f[2] == FALSE and f[1][0] == "is"


def holds(f, word, back):
    """The definition: for each letter of a word whether f holds there; after its last letter it continues at `back`."""
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
    found = [kind == "W"] * size
    for _ in range(2):  # once round the loop, and once more
        for i in reversed(range(size)):
            found[i] = inner[1][i] or inner[0][i] and found[after[i]]
    return found
