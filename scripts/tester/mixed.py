"""Files of strategies for two objectives with changed shares, claims, bounds, memories and states: what `verify` says of
them is what an evaluator in fractions says."""

import json
import math
import random
import re
from fractions import Fraction

CHANGED = 4
TINY = Fraction(1, 10**9)


def read(text):
    """The document of a file, in which numbers are fractions."""
    return json.loads(text, parse_float=Fraction)


def number(x):
    """A fraction in JSON: a number if its shortest decimal is exact."""
    return float(x) if Fraction(repr(float(x))) == x else str(x)


def changed(context, known, file, strategies, is_bounded):
    """Compares the verdicts about changes of a file. `strategies` has the values of each strategy and the states of its
    nodes, `is_bounded` says that both objectives have bounds."""
    draw, values = random.Random(f"mixed {context.case.seed}"), [values for values, _ in strategies]
    file_of_change = file.with_name("changed.json")
    for _ in range(CHANGED):
        document = read(file.read_text())
        bounds = [o[3] if at or is_bounded else None for at, o in enumerate(known.objectives)]
        names = draw.sample(sorted(CHANGES), draw.choice((0, 1, 1, 2)))
        if len(document["strategies"]) > 1 or "shift" not in names:
            for name in names:
                CHANGES[name](draw, known, document, values, bounds)
        is_doubled = document.pop("doubled", False)
        expected = not is_doubled and is_true(known, document, strategies, bounds)
        text = json.dumps(document, default=number)
        file_of_change.write_text(doubled(text) if is_doubled else text)
        context.case.features.add("an accepted mix" if expected else "a refused mix")
        status, out, errors = context.program.run("verify", file_of_change, context.program.model, "--json")
        found = {0: True, 1: False, 3: False}.get(status, (out + errors)[-500:])
        context.same(f"verdict of {'+'.join(names) or 'no change'} in {text}", expected, found)


def is_true(known, document, strategies, bounds):
    """Whether shares are fractions that sum to one, memories those of the paths, and claims and bounds true."""
    shares, values = [own["share"] for own in document["strategies"]], [values for values, _ in strategies]
    if None in shares:
        return False
    shares = list(map(Fraction, shares))
    if sum(shares) != 1 or min(shares) < 0:
        return False
    for own, (found, states) in zip(document["strategies"], strategies):
        if not remembers(known, own["nodes"], states):
            return False
        if any(known.sign(at) * found[at] < known.sign(at) * Fraction(own["values"][at]) for at in range(2)):
            return False
    return all(
        bound is None or known.sign(at) * mean(shares, values, at) >= known.sign(at) * bound
        for at, bound in enumerate(bounds)
    )


def mean(shares, values, at):
    drawn = [(share, own[at]) for share, own in zip(shares, values) if share]
    return math.inf if any(x == math.inf for _, x in drawn) else sum(share * x for share, x in drawn)


def remembers(known, nodes, states):
    """Whether each node says which objectives the paths to it have decided. No objective counts steps."""
    open_, seen = [(0, known.visited(states[0]))], {}
    while open_:
        at, memory = open_.pop()
        if at in seen:
            if seen[at] != memory:
                return False
            continue
        seen[at] = memory
        after = [s["node"] for action in nodes[at]["actions"] for s in action["successors"]]
        open_ += [(to, known.visited(states[to], memory)) for to in after]
    return all(
        node["steps"] == 0 and at in seen and node["decided"] == [i for i in range(2) if seen[at][i]]
        for at, node in enumerate(nodes)
    )


def slack(draw):
    return draw.choice((-1, 1)) * draw.choice((TINY, Fraction(1, 10**6), Fraction(1, 10**17), Fraction(1, 3)))


def shares(draw, known, document, values, bounds):
    own = draw.choice(document["strategies"])
    own["share"] = None if own["share"] is None else str(Fraction(own["share"]) + slack(draw))


def shift(draw, known, document, values, bounds):
    (one, other), by = draw.sample(document["strategies"], 2), slack(draw)
    if None not in (one["share"], other["share"]):
        one["share"], other["share"] = str(Fraction(one["share"]) + by), str(Fraction(other["share"]) - by)


def nothing(draw, known, document, values, bounds):
    for own in document["strategies"][: draw.randint(1, 2)]:
        own["share"] = None


def claim(draw, known, document, values, bounds):
    number, at = draw.randrange(len(values)), draw.randrange(2)
    if values[number][at] < math.inf:
        by = draw.choice((0, slack(draw)))
        document["strategies"][number]["values"][at] = str(max(0, values[number][at] + by))


def bound(draw, known, document, values, bounds):
    """Moves the bound of the second objective to about the mean."""
    drawn = [Fraction(own["share"] or 0) for own in document["strategies"]]
    found = mean(drawn, values, 1)
    if found == math.inf:
        return
    new = max(Fraction(0), found + draw.choice((0, slack(draw))))
    if known.objectives[1][0] != "R":
        new = min(new, Fraction(1))
    if max(new.numerator, new.denominator) >= 2**63:  # longer numbers are not read
        new = Fraction(round(new * 10**6), 10**6)
    head, second, rest = re.fullmatch(r"(multi\(.*\], .*?)(?:>=|<=)([^\[]*)( \[.*)", document["property"]).groups()
    sign = ">=" if known.sign(1) > 0 else "<="
    document["property"], bounds[1] = f"{head}{sign}{new}{rest}", new


def memory(draw, known, document, values, bounds):
    node = draw.choice(draw.choice(document["strategies"])["nodes"])
    kind = draw.randrange(3)
    if kind == 0:
        node["steps"] += 1
    else:
        node["decided"] = draw.choice(([], [0], [1], [0, 1], [1, 0], [31], [40]))


def double(draw, known, document, values, bounds):
    """A variable of a state has two values: the text is changed."""
    document["doubled"] = True


def doubled(text):
    return re.sub(r'"state": \{("[^"]*": [^,}]*)', r'"state": {\1, \1', text, count=1)


CHANGES = {own.__name__: own for own in (shares, shift, nothing, claim, bound, memory, double)}
