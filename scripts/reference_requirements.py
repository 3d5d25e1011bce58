#!/usr/bin/env python3
"""Requirements of random models, against two second opinions.

- The same model without the forbidden choices, written out state by state, has the same classes, levels, ranks and
  values as the model with `require`.
- `reference.py` computes the same report, also for requirements that need a monitor.
- `meliora reach --require` finds an objective sure in the same initial states as `reference.py`.

The dumps of some models must be accepted by `meliora verify`.

    reference_requirements.py [--models 5000] [--seed 0] [--jobs 2] [--binary meliora]
"""

import argparse
import json
import random
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import harness
from reference_lang import read_model, read_preferences, target_of
from reference_plan import Kept, Space, check
from reference_quantities import Draw

SAFETIES = ("action", "transition", "prefix")
COUNTED = ("almost_sure", "positive")


def run(binary, *arguments):
    done = subprocess.run([binary, *map(str, arguments)], capture_output=True, text=True, timeout=600)
    return done.returncode, done.stdout, done.stderr


def report(binary, *arguments):
    status, out, errors = run(binary, *arguments, "--json")
    if status != 0:
        raise AssertionError(f"{' '.join(map(str, arguments))}: status {status}: {out}{errors}")
    return json.loads(out)


class Case(Draw):
    """A random model with requirements, under random settings."""

    def __init__(self, seed):
        super().__init__(seed)
        rng = self.random = random.Random(seed + 1_000_003)
        self.safety, self.engine = rng.choice(SAFETIES), rng.choice(("symbolic", "explicit"))
        self.scope = rng.choice(("reachable", "all"))
        self.play = rng.random() < 0.3
        self.required = [self.requirement() for _ in range(rng.choice([1, 1, 1, 2]))]

    def requirement(self):
        rng, x, y = self.random, *self.random.sample(range(self.size + 1), 2)
        # Neither is a constant, so that monitors have as many states as the formula says.
        p, q = rng.choice([f"x={x}", f"x<={x}"]), rng.choice([f"x={y}", f"x>={y}"])
        always = [f"G !({p})", f"G ({p} | {q})", f"(G !({p})) & (G !({q}))"]
        others = [f"({p}) W ({q})", f"G (({p}) => (X ({q})))", f"X (X !({p}))", f"({q}) R ({p})"]
        return rng.choice(always + others if self.play else always)

    def write(self, folder):
        model, prefs = super().write(folder)
        lines = [*(f"require {r};" for r in self.required), *(["history = play;"] if self.play else [])]
        with open(prefs, "a", encoding="utf-8") as file:
            file.write("\n".join([*lines, ""]))
        return model, prefs

    def write_kept(self, folder, model, prefs):
        """Writes the model without what is forbidden; None if no state is left."""
        kept = Kept(Space(model, self.scope), prefs.required)
        if not kept.states:
            return None
        lines = ["mdp", "module m", f"  s : [0..{max(1, len(kept.states) - 1)}];"]
        for number, state in enumerate(kept.states):
            for name, _, distribution in model.steps(state):
                targets = [(kept.new.get(kept.whole.number[t]), p) for t, p in distribution.items()]
                if all(t is not None for t, _ in targets):
                    branches = " + ".join(f"{p} : (s'={t})" for t, p in targets)
                    lines.append(f"  [] s={number} -> {branches};")
        starts = " | ".join(f"s={s}" for s in kept.initial) or "false"
        lines += ["endmodule", f"init {starts} endinit" if kept.initial else "init s=0 endinit"]
        stated = []
        for i, (name, formula) in enumerate(prefs.objectives):
            target = kept.where(model.compile(formula.strip()[1:].strip()))
            stated.append(f"objective {name} = F ({' | '.join(f's={s}' for s in target) or 'false'});")
        # A model of one state gets a second one, which no state reaches.
        only = "" if len(kept.states) > 1 else "reachable"
        paths = Path(folder) / "kept.prism", Path(folder) / "kept.pref"
        paths[0].write_text("\n".join([*lines, ""]))
        paths[1].write_text("\n".join([*stated, *self.preferences, f"empty = {self.empty};", ""]))
        return (*paths, only or "all")

    def differences(self, binary):
        with tempfile.TemporaryDirectory() as folder:
            paths = self.write(folder)
            model, prefs = read_model(paths[0], {}), read_preferences(paths[1])
            settings = ["--scope", self.scope, "--safety", self.safety]
            try:
                found = report(binary, "check", *paths, *settings, "--engine", self.engine)
            except AssertionError as error:
                return [str(error)]
            return [
                *self.against_reference(found, check(model, prefs, self.scope, self.safety)),
                *self.against_kept(binary, folder, found, model, prefs),
                *self.of_one_target(binary, folder, paths[0], model, prefs),
                *self.verified(binary, folder, paths, settings),
            ]

    def against_reference(self, found, expected):
        wrong = [f"{k}: {found[k]}, not {expected[k]}" for k in ("counts", "improvement", "sasi", "spi") if found[k] != expected[k]]
        wrong += differing("classes", named(found["classes"]), named(expected["classes"]))
        for ours, theirs in zip(found["objectives"], expected["objectives"]):
            wrong += differing(ours["name"], [ours[k] for k in COUNTED], [theirs[k] for k in COUNTED])
        entries = [[{**e, "state": None, "unsafe": "unsafe" in e} for e in r["initial"]] for r in (found, expected)]
        for ours, theirs in zip(*entries):
            if ours["unsafe"] or theirs["unsafe"]:
                wrong += differing("unsafe", ours["unsafe"], theirs["unsafe"])
            else:
                wrong += differing("initial", ours, theirs)
        return wrong

    def against_kept(self, binary, folder, found, model, prefs):
        written = None if self.play else self.write_kept(folder, model, prefs)
        if written is None:
            return []
        *paths, scope = written
        if scope == "reachable" and not any("unsafe" not in e for e in found["initial"]):
            return []
        kept = report(binary, "check", *paths, "--scope", scope, "--safety", self.safety)
        wrong = [f"kept {k}: {found[k]}, not {kept[k]}" for k in ("classes", "improvement", "sasi", "spi") if found[k] != kept[k]]
        for ours, theirs in zip(found["objectives"], kept["objectives"]):
            keys = ("target", *COUNTED)
            wrong += differing(f"kept {ours['name']}", [ours[k] for k in keys], [theirs[k] for k in keys])
        safe = [e for e in found["initial"] if "unsafe" not in e]
        if safe and len(found["initial"]) == 1:
            given = Path(folder) / "m.prism", Path(folder) / "m.pref", "--scope", self.scope, "--engine", self.engine
            ours = report(binary, "values", *given, "--safety", self.safety)["states"][0]
            theirs = report(binary, "values", *paths, "--scope", scope, "--safety", self.safety)["states"][0]
            wrong += differing("values", values(ours), values(theirs))
        return wrong

    def of_one_target(self, binary, folder, path, model, prefs):
        """Asks for one target alone. For `reach`, a requirement is about the path from each state on."""
        _, formula = prefs.objectives[0]
        target = target_of(formula)
        if target is None:
            return []
        required = [text for r in self.required for text in ("--require", r)]
        settings = ["--scope", self.scope, "--engine", self.engine]
        found = report(binary, "reach", path, "--target", target, *settings, *required)
        alone = Path(folder) / "alone.pref"
        stated = [f"objective A = {formula};", *(f"require {r};" for r in self.required), "history = play;" if self.play else ""]
        alone.write_text("\n".join([*stated, ""]))
        starts = check(model, read_preferences(alone), self.scope, "action")["initial"]
        sure = ["unsafe" not in s and s["most_preferred"] == ["A"] for s in starts]
        expected = "all" if all(sure) else "some" if any(sure) else "none"
        return differing("reach pmax_one", found["initial"]["pmax_one"], expected)

    def verified(self, binary, folder, paths, settings):
        if self.random.random() > 0.25:
            return []
        dump = Path(folder) / "dump"
        for arguments in (["export", *paths, *settings, "--out", dump], ["verify", dump, *paths]):
            status, out, errors = run(binary, *arguments)
            if status != 0:
                return [f"{arguments[0]}: {out}{errors}"]
        return []


def differing(what, ours, theirs):
    return [] if ours == theirs else [f"{what}: {ours}, not {theirs}"]


def named(classes):
    return sorted(("+".join(c["most_preferred"]), c["states"]) for c in classes)


def values(state):
    """The values of a state, as far as both models must agree to the last digits shown."""
    def near(bound):
        return None if bound is None else f"{(float(bound['lower']) + float(bound['upper'])) / 2:.5f}"

    levels = [(near(level["probability"]), near(level["cost"])) for level in state["levels"]]
    return state["sasi_rank"], state["spi_rank"], levels, near(state["number"])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--models", type=int, default=5000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--binary", help="the command meliora")
    args = parser.parse_args()
    binary, wrong = harness.find_meliora(args.binary), 0
    with ThreadPoolExecutor(args.jobs) as pool:
        seeds = range(args.seed, args.seed + args.models)
        for seed, found in zip(seeds, pool.map(lambda seed: Case(seed).differences(binary), seeds)):
            for text in found:
                print(f"seed {seed}: {text}", flush=True)
            wrong += bool(found)
    print(f"{args.models} models, {wrong} differ")
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
