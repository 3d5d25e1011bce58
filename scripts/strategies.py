#!/usr/bin/env python3
"""Strategies of properties in random models, by an evaluator of its own.

Draws small models, asks `reach --policy` for properties of all kinds, and computes the value of each strategy from its
file in fractions. It must be the answer; `verify` must accept the file, and refuse it after changes that make it worse.

    python3 scripts/strategies.py --seeds 0:300 target/release/meliora
"""
import argparse
import copy
import json
import random
import subprocess
import sys
import tempfile
from collections import Counter
from fractions import Fraction
from pathlib import Path

INFINITE = float("inf")


class Model:
    """A random mdp or game: choices of states, with rewards, and two sets of states."""

    def __init__(self, seed):
        draw = random.Random(seed)
        self.is_game = seed % 4 == 3
        self.count = draw.randint(3, 7)
        self.choices, self.owner = [], []
        denominators = draw.choice([(2, 4), (3, 6), (10,)])
        for _ in range(self.count):
            self.owner.append(draw.randint(0, 1) if self.is_game else 0)
            own = []
            for number in range(draw.randint(1, 3)):
                bottom = draw.choice(denominators)
                targets = draw.sample(range(self.count), min(draw.randint(1, 3), self.count))
                parts = [1] * len(targets)
                for _ in range(bottom - len(parts)):
                    parts[draw.randrange(len(parts))] += 1
                sums = Counter()
                total = sum(parts)
                for target, part in zip(targets, parts):
                    sums[target] += Fraction(part, total)
                own.append((f"a{number}", dict(sums), draw.choice([0, 0, 1, 2])))
            self.choices.append(own)
        if draw.random() < 0.7:
            last = self.count - 1
            self.choices[last] = [("a0", {last: Fraction(1)}, 0)]
        self.earned = [draw.choice([0, 0, 0, 1]) for _ in range(self.count)]
        if draw.random() < 0.7:
            self.earned[self.count - 1] = 0
        self.a = {s for s in range(self.count) if draw.random() < 0.4}
        self.b = {s for s in range(1, self.count) if draw.random() < 0.35} or {self.count - 1}
        self.steps = draw.randint(1, 5)

    def text(self):
        lines = ["smg" if self.is_game else "mdp"]
        if self.is_game:
            lines += ["player p1 m1 endplayer", "player p2 m2 endplayer", f"global s : [0..{self.count - 1}] init 0;"]
        for module in (1, 2) if self.is_game else (1,):
            lines.append(f"module m{module}")
            if not self.is_game:
                lines.append(f"s : [0..{self.count - 1}] init 0;")
            for state, own in enumerate(self.choices):
                for name, to, _ in own if self.owner[state] == module - 1 else []:
                    branches = " + ".join(f"{p} : (s'={t})" for t, p in to.items())
                    # A global variable is written by commands without a label, in modules of both players.
                    label = "" if self.is_game else name
                    lines.append(f"[{label}] s={state} -> {branches};")
            lines.append("endmodule")
        lines.append('rewards "r"')
        for state, own in enumerate(self.choices):
            if self.earned[state]:
                lines.append(f"s={state} : {self.earned[state]};")
            for name, _, reward in own if not self.is_game else []:
                if reward:
                    lines.append(f"[{name}] s={state} : {reward};")
        lines.append("endrewards")
        for name, states in (("a", self.a), ("b", self.b)):
            lines.append(f'label "{name}" = {" | ".join(f"s={s}" for s in sorted(states)) or "false"};')
        return "\n".join(lines) + "\n"

    def reward(self, state, position):
        return self.earned[state] + (0 if self.is_game else self.choices[state][position][2])


# Kinds: the text, and how the value is computed. `F`, `G`, `GF`, `FG` are leaves of Boolean formulas over labels.
def kinds(model):
    k = model.steps
    all_kinds = [
        ("P", "F {b}", ("until", None, "b", 0, None, False)),
        ("P", "{a} U {b}", ("until", "a", "b", 0, None, False)),
        ("P", "G {a}", ("until", None, "!a", 0, None, True)),
        ("P", f"F<={k} {{b}}", ("until", None, "b", 0, k, False)),
        ("P", f"G[{k - 1},{k + 1}] {{a}}", ("until", None, "!a", k - 1, k + 1, True)),
        ("P", "X {b}", ("until", None, "b", 1, 1, False)),
        ("P", "(F {a}) & (F {b})", ("leaves", [("F", "a"), ("F", "b")], all)),
        ("P", "(F {a}) | (G {b})", ("leaves", [("F", "a"), ("G", "b")], any)),
        ("P", "(G F {a}) & (G F {b})", ("leaves", [("GF", "a"), ("GF", "b")], all)),
        ("P", "(F G {a}) | (G F {b})", ("leaves", [("FG", "a"), ("GF", "b")], any)),
        ("R", "F {b}", ("reward", "b", None)),
        ("R", f"C<={k}", ("reward", None, k)),
        ("R", "C", ("reward", None, None)),
        ("R", f"I={k}", ("at", k)),
        ("R", "S", ("average",)),
    ]
    if model.is_game:
        supported = (0, 1, 2, 3, 4, 5, 10, 11, 13)
        return [all_kinds[i] for i in supported]
    return all_kinds


def property_of(model, letter, formula, extreme):
    reward = '{"r"}' if letter == "R" else ""
    coalition = "<<p1>> " if model.is_game else ""
    return f'{coalition}{letter}{reward}{extreme}=? [ {formula.format(a=chr(34) + "a" + chr(34), b=chr(34) + "b" + chr(34))} ]'


class Chain:
    """What the nodes of a file leave: one choice of each node, or those of the opponent."""

    def __init__(self, model, file, side="ours"):
        strategy = file["strategies"][0]
        self.model, self.nodes = model, strategy["nodes"]
        self.moves, self.states = [], []
        for node in self.nodes:
            state = node["state"]["s"]
            self.states.append(state)
            options = []
            for action in node["actions"]:
                to = {}
                for successor in action["successors"]:
                    p = Fraction(successor["probability"]).limit_denominator(1000)
                    to[successor["node"]] = to.get(successor["node"], 0) + p
                options.append((to, model.reward(state, action["position"])))
            if not options:
                options = [({len(self.states) - 1: Fraction(1)}, 0)]
            if len(options) > 1 and not node.get("other"):
                share = Fraction(1, len(options))
                merged = Counter()
                for to, _ in options:
                    for target, p in to.items():
                        merged[target] += p * share
                options = [(dict(merged), sum(r for _, r in options) * share)]
            self.moves.append(options)

    def holds(self, node, name):
        if name is None:
            return True
        if name[0] == "!":
            return not self.holds(node, name[1:])
        return self.states[node] in (self.model.a if name == "a" else self.model.b)


def solve(rows, constants):
    """Solves x = rows x + constants by elimination in fractions."""
    n = len(rows)
    table = [[Fraction(int(i == j)) - rows[i].get(j, 0) for j in range(n)] + [constants[i]] for i in range(n)]
    for i in range(n):
        pivot = next(r for r in range(i, n) if table[r][i] != 0)
        table[i], table[pivot] = table[pivot], table[i]
        head = table[i][i]
        table[i] = [x / head for x in table[i]]
        for r in range(n):
            if r != i and table[r][i] != 0:
                factor = table[r][i]
                table[r] = [x - factor * y for x, y in zip(table[r], table[i])]
    return [table[i][n] for i in range(n)]


def reaching(moves, target, allowed):
    """The probability to reach nodes in a chain, by exact elimination."""
    n = len(moves)
    near = set(target)
    while True:
        more = {i for i in range(n) if i not in near and i in allowed and any(t in near for t in moves[i])}
        if not more:
            break
        near |= more
    open_nodes = [i for i in range(n) if i in near and i not in target]
    index = {node: at for at, node in enumerate(open_nodes)}
    rows = [{index[t]: p for t, p in moves[i].items() if t in index} for i in open_nodes]
    constants = [sum((p for t, p in moves[i].items() if t in target), Fraction(0)) for i in open_nodes]
    found = solve(rows, constants)
    return [Fraction(1) if i in target else found[index[i]] if i in index else Fraction(0) for i in range(n)]


def components(moves):
    """The components that are never left."""
    n = len(moves)
    reach = []
    for i in range(n):
        seen, stack = {i}, [i]
        while stack:
            for t in moves[stack.pop()]:
                if t not in seen:
                    seen.add(t)
                    stack.append(t)
        reach.append(seen)
    return [reach[i] for i in range(n) if all(i in reach[j] for j in reach[i]) and i == min(reach[i])]


def of_chain(chain, kind):
    """The value of a chain."""
    moves = [options[0][0] for options in chain.moves]
    gains = [options[0][1] for options in chain.moves]
    n = len(moves)
    name = kind[0]
    if name == "until":
        return until(chain, moves, kind)
    if name == "at":
        x = [Fraction(chain.model.earned[chain.states[i]]) for i in range(n)]
        for _ in range(kind[1]):
            x = [sum((p * x[t] for t, p in moves[i].items()), Fraction(0)) for i in range(n)]
        return x[0]
    if name == "leaves":
        return leaves(chain, moves, kind)
    if name == "average":
        value = Fraction(0)
        for component in components(moves):
            members = sorted(component)
            share = stationary(moves, members)
            probability = reaching(moves, set(component), set(range(n)))[0]
            value += probability * sum(share[i] * gains[i] for i in members)
        return value
    _, target, steps = kind
    if steps is not None:
        x = [Fraction(0)] * n
        for _ in range(steps):
            x = [gains[i] + sum((p * x[t] for t, p in moves[i].items()), Fraction(0)) for i in range(n)]
        return x[0]
    if target is None:
        bad = set()
        for component in components(moves):
            if any(gains[i] for i in component):
                bad |= component
        done = set().union(*components(moves)) - bad
        return summed(moves, gains, done, bad)
    done = {i for i in range(n) if chain.holds(i, target)}
    sure = reaching(moves, done, set(range(n)))
    return INFINITE if sure[0] != 1 else summed(moves, gains, done, set())


def summed(moves, gains, done, bad):
    n = len(moves)
    if bad and reaching(moves, bad, set(range(n)))[0] != 0:
        return INFINITE
    seen, stack = {0}, [0]
    while stack:
        node = stack.pop()
        for t in moves[node] if node not in done else []:
            if t not in seen:
                seen.add(t)
                stack.append(t)
    open_nodes = sorted(seen - done)
    index = {node: at for at, node in enumerate(open_nodes)}
    rows = [{index[t]: p for t, p in moves[i].items() if t in index} for i in open_nodes]
    found = solve(rows, [Fraction(gains[i]) for i in open_nodes])
    return found[index[0]] if 0 in index else Fraction(0)


def stationary(moves, members):
    index = {node: at for at, node in enumerate(members)}
    n = len(members)
    # Leaves out the balance of the first member, in whose place stands the sum.
    rows, constants = [], []
    for at in range(n):
        if at == 0:
            rows.append({j: Fraction(-1) if j else Fraction(0) for j in range(n)})
            constants.append(Fraction(1))
        else:
            rows.append({index[i]: moves[i][members[at]] for i in members if members[at] in moves[i]})
            constants.append(Fraction(0))
    found = solve(rows, constants)
    return {node: found[index[node]] for node in members}


def until(chain, moves, kind):
    _, left, right, least, most, negated = kind
    n = len(moves)
    in_right = {i for i in range(n) if chain.holds(i, right)}
    in_left = {i for i in range(n) if chain.holds(i, left)}
    if most is None:
        x = reaching(moves, in_right, in_left)
        last = least
    else:
        x = [Fraction(int(i in in_right)) for i in range(n)]
        last = most
    for passed in range(last - 1, -1, -1):
        new = []
        for i in range(n):
            if passed >= least and i in in_right:
                new.append(Fraction(1))
            elif i in in_left:
                new.append(sum((p * x[t] for t, p in moves[i].items()), Fraction(0)))
            else:
                new.append(Fraction(0))
        x = new
    return 1 - x[0] if negated else x[0]


def leaves(chain, moves, kind):
    """Follows which labels have held, and failed, so far; the rest is decided in the last component."""
    _, parts, join = kind
    names = [name for how, name in parts]
    first = (0, tuple((chain.holds(0, name), chain.holds(0, name)) for name in names))
    keys, index, product = [first], {first: 0}, []
    while len(product) < len(keys):
        node, bits = keys[len(product)]
        row = {}
        for t, p in moves[node].items():
            new = tuple((seen or chain.holds(t, name), kept and chain.holds(t, name)) for (seen, kept), name in zip(bits, names))
            key = (t, new)
            if key not in index:
                index[key] = len(keys)
                keys.append(key)
            row[index[key]] = row.get(index[key], 0) + p
        product.append(row)
    good = set()
    for component in components(product):
        one = keys[next(iter(component))]
        truths = []
        for at, (how, name) in enumerate(parts):
            hits = [chain.holds(keys[i][0], name) for i in component]
            truths.append({"F": one[1][at][0], "G": one[1][at][1], "GF": any(hits), "FG": all(hits)}[how])
        if join(truths):
            good |= component
    return reaching(product, good, set(range(len(product))))[0]


def value_of(model, file, kind, is_max):
    """The value of a file against every answer without memory of the opponent."""
    chain = Chain(model, file)
    if kind[0] == "until" and (kind[3] or kind[4] is not None) or kind[0] in ("at",) or kind[:1] == ("reward",) and kind[2]:
        return bounded_game(chain, kind, is_max)
    sizes = [len(options) for options in chain.moves]
    total = 1
    for size in sizes:
        total *= size
    if total > 3000:
        return None
    worst = None
    for number in range(total):
        moves = []
        for options in chain.moves:
            number, at = divmod(number, len(options))
            moves.append([options[at]])
        one = copy.copy(chain)
        one.moves = moves
        found = of_chain(one, kind)
        worst = found if worst is None else (min if is_max else max)(worst, found)
    return worst


def bounded_game(chain, kind, is_max):
    best = min if is_max else max
    n = len(chain.moves)

    def mean(option, x):
        return sum((p * x[t] for t, p in option[0].items()), Fraction(0))

    if kind[0] == "until":
        _, left, right, least, most, negated = kind
        best = (max if is_max else min) if negated else best
        x = [Fraction(int(chain.holds(i, right))) for i in range(n)]
        for passed in range(most - 1, -1, -1):
            new = []
            for i in range(n):
                if passed >= least and chain.holds(i, right):
                    new.append(Fraction(1))
                elif chain.holds(i, left):
                    new.append(best(mean(option, x) for option in chain.moves[i]))
                else:
                    new.append(Fraction(0))
            x = new
        return 1 - x[0] if negated else x[0]
    steps = kind[1] if kind[0] == "at" else kind[2]
    x = [Fraction(chain.model.earned[s]) if kind[0] == "at" else Fraction(0) for s in chain.states]
    for _ in range(steps):
        gain = (lambda option: 0) if kind[0] == "at" else (lambda option: option[1])
        x = [best(gain(option) + mean(option, x) for option in chain.moves[i]) for i in range(n)]
    return x[0]


def mutations(draw, model, file, is_max):
    """Files that claim too much, or do not follow the model."""
    better = 1 if is_max else -1

    def changed(change):
        new = copy.deepcopy(file)
        return new if change(new["strategies"][0]) is not False else None

    def claims(strategy):
        value = strategy["values"][0]
        if value == "infinity":
            return False
        strategy["values"][0] = f'{Fraction(str(value)) + better * Fraction(1, 1000)}'

    def node_with_actions(strategy):
        nodes = [node for node in strategy["nodes"] if node["actions"]]
        return draw.choice(nodes) if nodes else None

    def on_node(change):
        def run(strategy):
            node = node_with_actions(strategy)
            return False if node is None else change(strategy, node)
        return run

    def other_position(_, node):
        node["actions"][0]["position"] += 1

    def other_name(_, node):
        node["actions"][0]["action"] += "x"

    def other_probability(_, node):
        node["actions"][0]["successors"][0]["probability"] *= 0.5

    def fewer(_, node):
        node["actions"][0]["successors"].pop()

    def twice(_, node):
        node["actions"].append(copy.deepcopy(node["actions"][0]))

    def other_state(_, node):
        node["state"]["s"] = (node["state"]["s"] + 1) % model.count

    def cut(strategy):
        strategy["nodes"].pop()

    def unvisited(strategy):
        strategy["nodes"].append(copy.deepcopy(strategy["nodes"][0]))

    def other_start(strategy):
        others = [i for i, node in enumerate(strategy["nodes"]) if node["state"]["s"] != 0]
        if not others:
            return False
        nodes, at = strategy["nodes"], others[0]
        nodes[0], nodes[at] = nodes[at], nodes[0]

    changes = [claims, on_node(other_position), on_node(other_name), on_node(other_probability), on_node(fewer),
               on_node(twice), on_node(other_state), cut, unvisited, other_start]
    return [(change.__name__, made) for change in changes if (made := changed(change))]


def worse(draw, model, file, kind, is_max, value):
    """The file with other choices that make it worse; the successors are those of the model."""
    for _ in range(6):
        new = copy.deepcopy(file)
        nodes = new["strategies"][0]["nodes"]
        memory = lambda node: json.dumps([node.get("memory"), node.get("steps", 0), node.get("round", 0)])
        at = draw.randrange(len(nodes))
        node = nodes[at]
        if not node["actions"] or node.get("other") or node.get("memory") or node.get("steps"):
            continue
        state = node["state"]["s"]
        position = draw.randrange(len(model.choices[state]))
        name, to, _ = model.choices[state][position]
        place = {n["state"]["s"]: i for i, n in enumerate(nodes) if memory(n) == memory(node)}
        if model.is_game or not all(t in place for t in to):
            continue
        successors = [{"node": place[t], "probability": float(p)} for t, p in to.items()]
        node["actions"] = [{"action": name, "position": position, "successors": successors}]
        found = value_of(model, new, kind, is_max)
        if found is not None and (found < value if is_max else found > value):
            return new
    return None


def run(arguments):
    return subprocess.run(arguments, capture_output=True, text=True, check=False)


def check(binary, seed, folder, counts):
    model, draw = Model(seed), random.Random(seed)
    path = folder / "model.prism"
    path.write_text(model.text())
    for letter, formula, kind in kinds(model):
        for extreme in ("max", "min"):
            counts["properties"] += 1
            text = property_of(model, letter, formula, extreme)
            out = folder / "policy.json"
            out.unlink(missing_ok=True)
            found = run([binary, "reach", str(path), "--property", text, "--policy", str(out), "--json"])
            where = f"seed {seed}: {text}"
            if found.returncode not in (0, 1):
                print(f"{where}: status {found.returncode}: {found.stderr.strip()[:300]}")
                counts["failed"] += 1
                continue
            answer = json.loads(found.stdout)["properties"][0]["value"]
            low, high = float(answer["lower"]), float(answer["upper"])
            if not out.exists():
                if extreme == "min" and low == INFINITE:
                    counts["infinite"] += 1
                else:
                    print(f"{where}: no file")
                    counts["failed"] += 1
                continue
            file = json.loads(out.read_text())
            is_max = extreme == "max"
            value = value_of(model, file, kind, is_max)
            if value is None:
                counts["too large"] += 1
            elif value != INFINITE and low != INFINITE and abs(value - low) > 2e-6 * max(1, abs(low)) or (value == INFINITE) != (low == INFINITE):
                print(f"{where}: the strategy has {value}, the answer is {low}..{high}")
                counts["failed"] += 1
                continue
            counts["equal"] += 1
            accepted = run([binary, "verify", str(out), str(path)])
            if accepted.returncode != 0:
                print(f"{where}: refused: {(accepted.stdout + accepted.stderr).strip()[:300]}")
                counts["failed"] += 1
                continue
            changed = mutations(draw, model, file, is_max)
            if value is not None and (bad := worse(draw, model, file, kind, is_max, value)):
                changed.append(("worse", bad))
            for name, made in changed if seed % 5 == 0 else changed[:1] + changed[-1:]:
                out.write_text(json.dumps(made))
                refused = run([binary, "verify", str(out), str(path)])
                counts["mutations"] += 1
                if refused.returncode == 0:
                    (folder / f"accepted-{seed}-{name}.json").write_text(json.dumps(made))
                    print(f"{where}: accepted after {name}")
                    counts["failed"] += 1


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("binary")
    parser.add_argument("--seeds", default="0:300")
    parser.add_argument("--keep", help="the folder of the files, which is kept")
    arguments = parser.parse_args()
    begin, end = map(int, arguments.seeds.split(":"))
    counts = Counter()
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(arguments.keep or temporary)
        for seed in range(begin, end):
            check(arguments.binary, seed, folder, counts)
    print(dict(counts))
    sys.exit(1 if counts["failed"] else 0)


if __name__ == "__main__":
    main()
