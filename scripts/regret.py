#!/usr/bin/env python3
"""Measures the regret of the automatic choices: the time of `auto` over that of the best choice by hand.

usage: regret.py INSTANCES… [--root FOLDER] [--half tuned|held-out|both] [--part N] [--limit 15] [--floor 0.2]
                 [--choices auto,explicit,…] [--json FILE] [--markdown FILE] [--meliora BINARY]

INSTANCES is a JSON list of objects with `id`, `model` (relative to --root, or else to the list), `constants`, and
`target` or `property`; or a folder of PRISM models with a label `goal`, which are asked for a strong cyclic plan,
Pmax>=1 [ F "goal" ]. Each choice is a `meliora reach` of its own with --limit seconds of processor time, and `auto`
with four times as many, so a busy machine does not matter much. --part N leaves all but one in N instances out. An instance belongs to the half that a hash of its name says: choose rules on the
tuned half only, and judge them by both. Times below --floor count as --floor.
Exit status: 0 done, 1 two choices differ in an answer, 2 usage.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import math
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Iterator

import harness

HALVES = ("tuned", "held-out")
PLAN = 'Pmax>=1 [ F "goal" ]'
# The choices that a user can make: an order of the variables, an engine, a scope.
ORDERS = ("declared", "reversed", "large-first")
# The limit of `auto`, which has several ways to try, over that of the other choices.
AUTO_SHARE = 4
CHOICES = ("auto", "explicit", *ORDERS, *(f"{order}+all" for order in ORDERS))


@dataclass(frozen=True)
class Instance:
    """A model and a question."""

    name: str
    model: Path
    question: tuple[str, ...]

    @property
    def half(self) -> str:
        return HALVES[self.hash[0] % 2]

    @property
    def hash(self) -> bytes:
        return hashlib.sha256(self.name.encode()).digest()


@dataclass(frozen=True)
class Run:
    """The processor time of one choice and its answer; None if it gave none within the limit."""

    seconds: float
    found: Any


def instances(source: Path, root: Path | None) -> Iterator[Instance]:
    """The instances of a list, or of a folder of planning problems."""
    if source.is_dir():
        for model in sorted(source.glob("*.prism")):
            yield Instance(model.stem, model, ("--property", PLAN))
        return
    for entry in harness.read_json(source):
        asked = "target" if "target" in entry else "property"
        constants = ("--const", entry["constants"]) if entry.get("constants") else ()
        model = (root or source.parent) / entry["model"]
        yield Instance(entry["id"], model, (f"--{asked}", entry[asked], *constants))


class Choices:
    """Runs the choices on an instance."""

    def __init__(self, meliora: str, limit: int, folder: Path) -> None:
        self.meliora, self.limit, self.folder = meliora, limit, folder

    def run(self, instance: Instance, choice: str) -> Run:
        command = [self.meliora, "reach", str(instance.model), *instance.question, *self.options(instance, choice)]
        limit = self.limit * (AUTO_SHARE if choice == "auto" else 1)
        limited = ["sh", "-c", 'ulimit -t "$0"; exec "$@"', str(limit), *command, "--json", "--quiet"]
        finished = harness.run(limited, 60.0 * limit)
        report = harness.json_object(finished.stdout) or {}
        # A property that does not hold has status 1.
        found = answer(report) if finished.status in (0, 1) else None
        return Run(finished.cpu_seconds, found)

    def options(self, instance: Instance, choice: str) -> list[str]:
        if choice in ("auto", "explicit"):
            return ["--engine", choice]
        order, _, scope = choice.partition("+")
        named = order if order == "declared" else str(self.order(instance, order))
        return ["--engine", "symbolic", "--order", named, *(["--scope", scope] if scope else [])]

    def order(self, instance: Instance, order: str) -> Path:
        """A file with the variables in an order."""
        constants = instance.question[2:]
        said = harness.run([self.meliora, "info", str(instance.model), *constants, "--json"], 60.0)
        variables = (harness.json_object(said.stdout) or {}).get("model", {}).get("variables", [])
        if order == "reversed":
            variables = variables[::-1]
        else:
            variables = sorted(variables, key=lambda v: v["low"] - v["high"])
        path = self.folder / f"{order}.order"
        path.write_text("".join(f"{v['name']}\n" for v in variables), encoding="utf-8")
        return path


def answer(report: dict[str, Any]) -> str:
    """What a report says about the initial states, which all scopes agree on."""
    return json.dumps({key: report.get(key) for key in ("initial", "holds")}, sort_keys=True)


def regret(runs: dict[str, Run], floor: float) -> tuple[float, str, float]:
    """The time of the best choice, its name, and the regret; infinite if only `auto` found nothing."""
    done = {choice: max(run.seconds, floor) for choice, run in runs.items() if run.found is not None}
    best = min(done, key=lambda choice: done[choice])
    return done[best], best, done.get("auto", math.inf) / done[best]


def row(name: str, half: str, runs: dict[str, Run], floor: float) -> str:
    auto = runs["auto"]
    own = f"{auto.seconds:.2f}" if auto.found is not None else "–"
    if all(run.found is None for run in runs.values()):
        return f"| {name} | {half} | – | – | – | – |"
    seconds, best, ratio = regret(runs, floor)
    return f"| {name} | {half} | {own} | {best} | {seconds:.2f} | {ratio:.1f} |"


def summary(results: list[tuple[Instance, dict[str, Run]]], half: str, floor: float) -> str:
    own = [runs for instance, runs in results if instance.half == half]
    answered = [runs for runs in own if any(run.found is not None for run in runs.values())]
    ratios = [regret(runs, floor)[2] for runs in answered]
    finite = [ratio for ratio in ratios if math.isfinite(ratio)]
    mean = math.exp(sum(map(math.log, finite)) / len(finite)) if finite else math.nan
    return (
        f"{half}: {len(own)} instances; some choice answers {len(answered)}, auto {len(finite)}; "
        f"regret {mean:.2f} in the geometric mean, {max(finite, default=math.nan):.1f} at most"
    )


def measure(options: argparse.Namespace) -> int:
    meliora = harness.find_meliora(options.meliora)
    wanted = [i for source in options.instances for i in instances(source, options.root)]
    wanted = [i for i in wanted if options.half in ("both", i.half) and i.hash[1] % options.part == 0]
    results: list[tuple[Instance, dict[str, Run]]] = []
    differ = 0
    lines = ["| instance | half | `auto`, s | best choice | s | regret |", "| --- | --- | --- | --- | --- | --- |"]
    with tempfile.TemporaryDirectory() as folder:
        choices = Choices(meliora, options.limit, Path(folder))
        for instance in wanted:
            runs = {choice: choices.run(instance, choice) for choice in options.choices}
            found = {run.found for run in runs.values() if run.found is not None}
            if len(found) > 1:
                differ += 1
                print(f"{instance.name}: the choices differ: {found}", file=sys.stderr)
            results.append((instance, runs))
            lines.append(row(instance.name, instance.half, runs, options.floor))
            print(lines[-1], flush=True)
    for half in HALVES:
        print(summary(results, half, options.floor))
    if options.markdown:
        options.markdown.write_text("\n".join(lines) + "\n", encoding="utf-8")
    if options.json:
        times = {i.name: {c: (r.seconds, r.found is not None) for c, r in runs.items()} for i, runs in results}
        options.json.write_text(json.dumps(times, indent=1) + "\n", encoding="utf-8")
    return int(differ > 0)


def main() -> int:
    assert __doc__ is not None
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("instances", nargs="+", type=Path)
    parser.add_argument("--root", type=Path)
    parser.add_argument("--half", choices=(*HALVES, "both"), default="both")
    parser.add_argument("--part", type=int, default=1, help="one in this many instances")
    parser.add_argument("--limit", type=int, default=15, help="seconds of processor time of each choice")
    parser.add_argument("--floor", type=float, default=0.2, help="times below count as this many seconds")
    parser.add_argument("--choices", type=lambda text: text.split(","), default=list(CHOICES))
    parser.add_argument("--json", type=Path)
    parser.add_argument("--markdown", type=Path)
    parser.add_argument("--meliora")
    options = parser.parse_args()
    unknown = set(options.choices) - set(CHOICES)
    if unknown or "auto" not in options.choices:
        harness.stop(f"--choices: `auto` and some of {', '.join(CHOICES[1:])}")
    return measure(options)


if __name__ == "__main__":
    sys.exit(main())
