"""Tests of the reference: monitors of temporal formulas against the definition on ultimately periodic words."""

import itertools
import random

from reference.leaves import cases, conditions
from reference.temporal import Monitor, holds, negated

ATOMS = ("a", "b")


def random_formula(rng, size):
    if size == 0:
        return ("is", rng.choice(ATOMS), rng.random() < 0.5)
    operator = rng.choice(["X", "and", "or", "U", "W", "not"])
    if operator in ("X", "not"):
        inner = random_formula(rng, size - 1)
        return ("X", inner) if operator == "X" else negated(inner)
    left = rng.randrange(size)
    return (operator, random_formula(rng, left), random_formula(rng, size - 1 - left))


def accepts(formula, stem, loop):
    """What the monitors say about a word: their marks on the loop, once their states repeat there."""

    def recurs(leaf):
        monitor = Monitor(leaf)
        return monitor.accepts(
            monitor.start, *([monitor.letter(letter.get) for letter in part] for part in (stem, loop))
        )

    return any(all(recurs(leaf) == (kind == "again") for kind, leaf in case) for case in cases(conditions(formula)))


def compare(amount):
    """Compares random formulas on all short words. Returns 0 if all agree, else 1."""
    rng, wrong, words = random.Random(1), 0, 0
    letters = [dict(zip(ATOMS, signs)) for signs in itertools.product((False, True), repeat=len(ATOMS))]
    short = [list(itertools.product(letters, repeat=n)) for n in range(3)]
    for _ in range(amount):
        formula = random_formula(rng, rng.randrange(7))
        for stem, loop in rng.sample([(s, o) for s in sum(short, []) for o in short[1] + short[2]], 30):
            words += 1
            expected = holds(formula, [*stem, *loop], len(stem))[0]
            if accepts(formula, stem, loop) != expected:
                wrong += 1
                print(f"{formula} on {stem} and {loop} again and again: expected {expected}")
    print(f"{amount} formulas, {words} words, {wrong} differences")
    return int(wrong > 0)
