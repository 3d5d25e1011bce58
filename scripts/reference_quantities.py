#!/usr/bin/env python3
"""Compares `meliora values` and `meliora reach` with exact values, on random small models.

    reference_quantities.py random [--models N] [--seed S] [--few] [--jobs J] [--binary PATH] [--keep DIR]
    reference_quantities.py compare MODEL PREFS [--safety prefix] [--reward NAME] [--levels K] [--within N]
    reference_quantities.py show MODEL PREFS ...      print the exact values

The exact values come from `reference_values.py`: policy iteration on fractions. Every interval of
`meliora values --all --json` must contain the exact value and be at most as wide as the precision. A random model
has end components, rewards of 0, and one of the three values of `empty`; it is tried with the three safety modes,
both engines, and steps or a reward structure as the cost. A model that differs is made smaller and written to DIR.
The probabilities and rewards of `meliora reach` are compared with the extremes over all memoryless policies, where
these are few.
Exit status: 0 all agree, 1 a difference.
"""

import argparse
import json
import math
import random
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from fractions import Fraction
from pathlib import Path

import harness
from reference_lang import read_model, read_preferences, target_of
from reference_plan import Order, Space, reached
from reference_policies import extremes
from reference_values import Quantities

SAFETIES = ("action", "transition", "prefix")
ENGINES = ("symbolic", "explicit")


class Exact:
    """The exact values of a model and preferences."""

    def __init__(self, model_path, prefs_path, reward="steps"):
        model, prefs = read_model(model_path, {}), read_preferences(prefs_path)
        self.space = Space(model, "reachable")
        self.order = Order(prefs.strict, prefs.empty)
        sure = [reached(self.space, formula)[1] for _, formula in prefs.objectives]
        outcomes = [{i for i, region in enumerate(sure) if s in region} for s in range(len(self.space.states))]
        self.classes = [self.order.most_preferred(out) for out in outcomes]
        self.steps = [self.steps_of(model, number, reward) for number in range(len(self.space.states))]

    def steps_of(self, model, number, reward):
        state = self.space.states[number]
        found = []
        for name, label, distribution in model.steps(state):
            cost = self.cost(model, state, label, reward)
            found.append((name, cost, {self.space.number[t]: p for t, p in distribution.items()}))
        return found or [("deadlock", self.cost(model, state, None, reward), {number: Fraction(1)})]

    def cost(self, model, state, label, reward):
        if reward == "steps":
            return Fraction(1)
        items = model.rewards[reward]
        return sum((Fraction(v(state)) for a, g, v in items if (a is None or a == label) and g(state)), Fraction(0))

    def quantities(self, safety):
        return Quantities(self.steps, self.classes, self.order, safety)


def agrees(interval, value, precision):
    """Whether an interval contains the exact value and is narrow; both may be missing."""
    if value is None or interval is None:
        return value is None and interval is None
    lower, upper = (math.inf if x == "inf" else Fraction(x) for x in (interval["lower"], interval["upper"]))
    return lower <= value <= upper and (lower == upper or upper - lower <= precision * max(1.0, lower))


def problems(exact, safety, report, levels, within, precision=1e-6):
    """What is wrong in a report of `meliora values --all --json`, as texts."""
    found, quantities = [], exact.quantities(safety)
    probabilities = quantities.probabilities(levels)
    costs, numbers = quantities.costs(probabilities), quantities.numbers()
    curves = quantities.within(levels, within)

    def compare(what, interval, value):
        if not agrees(interval, value, precision):
            found.append(f"{what}: {interval} instead of {value} = {value and float(value)}")

    if len(report["states"]) != len(exact.space.states):
        found.append(f"{len(report['states'])} states instead of {len(exact.space.states)}")
    for entry in report["states"]:
        number = exact.space.number[tuple(entry["state"].values())]
        node, at = quantities.own(number), f"{safety} {entry['state']}"
        compare(f"{at} N", entry["number"], numbers.get(node, Fraction(0)))
        for level in entry["levels"]:
            k = level["improvements"]
            values, actions = probabilities[k - 1]
            spent, spending = costs[k - 1]
            compare(f"{at} P_{k}", level["probability"], values.get(node, Fraction(0)))
            compare(f"{at} C_{k}", level["cost"], spent.get(node))
            named = {action.name: action for action in actions.get(node, [])}
            paid = {action.name: action for action in spending.get(node, [])}
            for action in level["actions"]:
                name = action["action"]
                compare(f"{at} P_{k} of {name}", action["probability"], named[name].value(values))
                cost = paid[name].value(spent) if name in paid else None
                compare(f"{at} C_{k} of {name}", action["cost"], cost)
            for n, p in enumerate(level.get("within") or []):
                value = curves[k - 1][n].get(node, Fraction(0))
                if abs(Fraction(p) - value) > Fraction(1, 10**9):
                    found.append(f"{at} P_{k}^{n}: {p} instead of {float(value)}")
    return found


def ask(binary, model, prefs, options):
    command = [binary, "values", str(model), str(prefs), "--all", "--json", "--limit", "100000", *options]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600)
    return json.loads(done.stdout) if done.stdout else {"states": [], "message": done.stderr}


ALL = [(reward, safety, engine) for reward in ("steps", "cost") for safety in SAFETIES for engine in ENGINES]


def differences(binary, model, prefs, levels=2, within=4, settings=ALL):
    """The first difference in each setting, as texts."""
    found, exact = [], {reward: Exact(model, prefs, reward) for reward in {reward for reward, _, _ in settings}}
    for reward, safety, engine in settings:
        options = ["--safety", safety, "--engine", engine, "--levels", str(levels)]
        options += ["--within", str(within), "--reward", reward]
        report = ask(binary, model, prefs, options)
        if report.get("schema") != "meliora.values/1" or report.get("error"):
            found.append(f"{safety} {engine} {reward}: {report.get('error') or report.get('message')}")
            continue
        found += [f"{engine} {reward}: {p}" for p in problems(exact[reward], safety, report, levels, within)[:1]]
    return found


def reach_differences(binary, model, prefs, engines=ENGINES, precision=1e-6):
    """Differences of `meliora reach` with the extremes over all policies, for the first objective."""
    exact = Exact(model, prefs, "cost")
    _, formula = read_preferences(prefs).objectives[0]
    target = exact.space.where(exact.space.model.compile(target_of(formula)))
    expected, found = extremes(exact.steps, target, exact.space.initial[0]), []
    if expected is None:
        return []
    texts = [text.replace("T", f"({target_of(formula)})") for text in expected]
    given = [part for text in texts for part in ("--property", text)]
    for engine in engines:
        done = subprocess.run(
            [binary, "reach", model, "--json", "--engine", engine, *given], capture_output=True, text=True, timeout=600
        )
        answers = json.loads(done.stdout).get("properties", []) if done.stdout else []
        if len(answers) != len(texts):
            return [f"{engine}: {done.stdout or done.stderr}"]
        for text, answer, value in zip(texts, answers, expected.values()):
            if not agrees(answer.get("value"), value, precision):
                found.append(f"{engine} {text}: {answer.get('value')} instead of {value} = {float(value)}")
    return found


class Draw:
    """A random model and preferences, as parts that can be left out."""

    def __init__(self, seed, few=False):
        self.random = rng = random.Random(seed)
        self.settings, self.engines = ALL, ENGINES
        if few:
            self.engines = [rng.choice(ENGINES)]
            self.settings = [(rng.choice(("steps", "cost")), safety, rng.choice(ENGINES)) for safety in SAFETIES]
        self.size = rng.randint(2, 8)
        self.forward = rng.random()
        self.commands = [self.command(x) for x in range(self.size + 1) for _ in range(rng.choice([0, 1, 2, 2, 3, 3]))]
        self.commands = self.commands or [self.command(0)]
        labels = sorted({c.split("]")[0][1:] for c in self.commands})
        self.rewards = [self.reward(labels) for _ in range(rng.randint(0, 4))]
        self.objectives = [self.objective() for _ in range(rng.randint(2, 4))]
        self.preferences = [self.preference() for _ in range(rng.randint(1, 4))]
        if rng.random() < 0.5:
            self.preferences = [f"prefer {' > '.join(f'O{i}' for i in reversed(range(len(self.objectives))))};"]
        self.empty = rng.choice(["bottom", "gain", "incomparable"])

    def condition(self):
        rng, x = self.random, self.random.randint(0, self.size)
        return rng.choice([f"x={x}", f"x={x}", f"x>={x}", f"x<{x}", "true"])

    def command(self, x):
        rng = self.random
        weights = rng.choice([[1], [1], [1, 1], [1, 2], [1, 9], [1, 999], [1, 1, 1], [3, 3, 1], [1, 99999999]])
        near = [min(self.size, x + 1), min(self.size, x + 2), x]
        targets = [rng.choice(near) if rng.random() < self.forward else rng.randint(0, self.size) for _ in weights]
        branches = [f"{w}/{sum(weights)} : (x'={t})" for w, t in zip(weights, targets)]
        guard = rng.choice([f"x={x}"] * 8 + [f"x>={x}"])
        return f"[{rng.choice(['', '', 'a', 'b', 'c'])}] {guard} -> {' + '.join(branches)};"

    def reward(self, labels):
        rng = self.random
        who = rng.choice(["", f"[{rng.choice(labels)}] "])
        return f"{who}{self.condition()} : {rng.choice(['0', '1', '0.1', '1/3', 'x', 'x/7', '1000'])};"

    def objective(self):
        states = self.random.sample(range(self.size + 1), self.random.choice([1, 1, 2]))
        return f"F ({' | '.join(f'x={x}' for x in states)})"

    def preference(self):
        a, b = self.random.sample(range(len(self.objectives)), 2)
        a, b = min(a, b), max(a, b)  # never a contradiction
        return f"prefer O{b} {self.random.choice(['>', '>', '>', '>='])} O{a};"

    def write(self, folder):
        model, prefs = Path(folder) / "m.prism", Path(folder) / "m.pref"
        lines = ["mdp", "module m", f"  x : [0..{self.size}];", *(f"  {c}" for c in self.commands)]
        lines += ["endmodule", 'rewards "cost"', *(f"  {r}" for r in self.rewards), "endrewards", ""]
        model.write_text("\n".join(lines))
        stated = [f"objective O{i} = {formula};" for i, formula in enumerate(self.objectives)]
        prefs.write_text("\n".join([*stated, *self.preferences, f"empty = {self.empty};", ""]))
        return str(model), str(prefs)

    def differs(self, binary):
        labels = {c.split("]")[0][1:] for c in self.commands}
        if any(r.startswith("[") and r[1:].split("]")[0] not in labels for r in self.rewards):
            return []
        with tempfile.TemporaryDirectory() as folder:
            model, prefs = self.write(folder)
            reach = reach_differences(binary, model, prefs, self.engines)
            return reach + differences(binary, model, prefs, settings=self.settings)

    def shrink(self, binary):
        """Leaves out what the difference does not need."""
        for part in (self.commands, self.rewards, self.preferences):
            for item in list(part):
                at = part.index(item)
                part.pop(at)
                if not (self.commands and self.differs(binary)):
                    part.insert(at, item)


def run_random(args):
    wrong = 0

    def one(seed):
        drawn = Draw(seed, args.few)
        found = drawn.differs(args.binary)
        if found:
            drawn.shrink(args.binary)
            folder = Path(args.keep) / str(seed)
            folder.mkdir(parents=True, exist_ok=True)
            drawn.write(folder)
        return seed, found

    with ThreadPoolExecutor(args.jobs) as pool:
        for count, (seed, found) in enumerate(pool.map(one, range(args.seed, args.seed + args.models)), 1):
            for text in found:
                print(f"seed {seed}: {text}", flush=True)
            wrong += bool(found)
            if count % 500 == 0:
                print(f"{count} models, {wrong} differ", file=sys.stderr, flush=True)
    print(f"{args.models} models, {wrong} differ")
    return int(wrong > 0)


def show(args):
    exact = Exact(args.model, args.prefs, args.reward)
    quantities = exact.quantities(args.safety)
    probabilities = quantities.probabilities(args.levels)
    costs, numbers = quantities.costs(probabilities), quantities.numbers()
    for number in range(len(exact.space.states)):
        node, values = quantities.own(number), []
        for k, ((p, _), (c, _)) in enumerate(zip(probabilities, costs), 1):
            values.append(f"P_{k}={p.get(node, 0)} C_{k}={c.get(node, '-')}")
        print(exact.space.named(number), *values, f"N={numbers.get(node, 0)}")
    return 0


def compare(args):
    settings = [(args.reward, args.safety, engine) for engine in ENGINES]
    found = differences(args.binary, args.model, args.prefs, args.levels, args.within, settings)
    print("\n".join(found) or "all values agree")
    return int(bool(found))


def main():
    top = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = top.add_subparsers(dest="command", required=True)
    drawn = commands.add_parser("random")
    drawn.add_argument("--models", type=int, default=5000)
    drawn.add_argument("--seed", type=int, default=0)
    drawn.add_argument("--few", action="store_true", help="each safety mode with one engine and one cost, at random")
    drawn.add_argument("--jobs", type=int, default=2)
    drawn.add_argument("--keep", default="target/differences", help="where models that differ are written")
    for name in ("compare", "show"):
        given = commands.add_parser(name)
        given.add_argument("model")
        given.add_argument("prefs")
        given.add_argument("--safety", choices=SAFETIES, default="action")
        given.add_argument("--reward", default="steps")
        given.add_argument("--levels", type=int, default=2)
        given.add_argument("--within", type=int, default=4)
    for command in commands.choices.values():
        command.add_argument("--binary", help="the command meliora")
    args = top.parse_args()
    args.binary = harness.find_meliora(args.binary)
    return {"random": run_random, "compare": compare, "show": show}[args.command](args)


if __name__ == "__main__":
    sys.exit(main())
