#!/usr/bin/env python3
"""Measures the regret of the automatic choices: the time of `auto` over that of the best choice by hand.

usage: regret.py SOURCE… [--root FOLDER] [--half tuned|held-out|both] [--part N] [--minutes N] [--limit 15]
                 [--floor 0.2] [--threads 1] [--choices auto,explicit,…] [--json FILE] [--markdown FILE]
                 [--meliora BINARY]

SOURCE is one collection, NAME=PATH or PATH:
  a JSON list     objects with `id`, `model` (relative to --root, or else to the list), `constants`, and `target`,
                  `property`, `targets` (a list as in an oracle.json, whose last target is asked for), or
                  `preferences` (a file, for `check`)
  models          a folder of PRISM models with a label `goal`, which are asked for a strong cyclic plan,
                  Pmax>=1 [ F "goal" ]
  worlds          a folder of models with a preference file of the same name each, which are given to `check`
  networks        a folder with Boolean networks (`*.bnet`), which are asked for the states that reach their last variable

Each choice is a `meliora reach` of its own with --limit seconds of processor time, and `auto` with four times as many, so
a busy machine does not matter much. With more than one --threads for `auto`, times are those of a clock. Times below --floor count as --floor, so nothing else is run if `auto` takes less.
An instance belongs to the half that a hash of its name says: choose rules on the tuned half only, and judge them by
both. The collections take turns, each in the order of the hash, so an interrupted run has a random part of each: --part
N leaves all but one in N instances out, and no instance begins after --minutes.
Exit status: 0 done, 1 two choices differ in an answer, 2 usage.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import math
import sys
import tempfile
import time
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path
from typing import Any, Iterator

import boolean_networks
import harness

HALVES = ("tuned", "held-out")
PLAN = 'Pmax>=1 [ F "goal" ]'
# The choices that a user can make: an engine (diagrams have the order of the structure then), an order of the variables,
# a scope.
ORDERS = ("declared", "reversed", "large-first")
# The limit of `auto`, which has several ways to try, over that of the other choices.
AUTO_SHARE = 4
ENGINES = ("explicit", "symbolic")
CHOICES = ("auto", *ENGINES, *ORDERS, *(f"{order}+all" for order in ORDERS))


@dataclass(frozen=True)
class Instance:
    """A model and a question."""

    collection: str
    name: str
    model: Path
    question: tuple[str, ...]
    preferences: Path | None = None

    @property
    def half(self) -> str:
        return HALVES[self.hash[0] % 2]

    @property
    def hash(self) -> bytes:
        return hashlib.sha256(self.name.encode()).digest()


@dataclass(frozen=True)
class Run:
    """The processor time of one choice, its memory and its answer; None if it gave none within the limit."""

    seconds: float
    peak_bytes: int
    found: Any


def instances(source: str, root: Path | None, folder: Path) -> Iterator[Instance]:
    """The instances of a collection. Models of networks are written to a folder."""
    name, _, path_ = source.rpartition("=")
    path = Path(path_)
    collection = name or path.stem
    if path.is_dir():
        for model in sorted(path.glob("*.prism")):
            preferences = model.with_suffix(".pref")
            if preferences.exists():
                yield Instance(collection, model.stem, model, (), preferences)
            else:
                yield Instance(collection, model.stem, model, ("--property", PLAN))
        for number, file in boolean_networks.files(path):
            network = boolean_networks.Network.read(number, file)
            if network.functions:
                model = folder / f"network-{number}.prism"
                model.write_text(network.prism(), encoding="utf-8")
                target = f"n_{list(network.functions)[-1]}"
                yield Instance(collection, f"network-{number}", model, ("--target", target))
        return
    for entry in harness.read_json(path):
        model = (root or path.parent) / entry["model"]
        constants = ("--const", entry["constants"]) if entry.get("constants") else ()
        if "preferences" in entry:
            yield Instance(collection, entry["id"], model, constants, (root or path.parent) / entry["preferences"])
            continue
        if "targets" in entry:
            entry |= {"target": entry["targets"][-1]["target"] if entry["targets"] else "true"}
        asked = "target" if "target" in entry else "property"
        yield Instance(collection, entry["id"], model, (f"--{asked}", entry[asked], *constants))


def in_turns(collections: list[list[Instance]]) -> list[Instance]:
    """The instances of all collections, each in the order of the hash."""
    ordered = (sorted(own, key=lambda instance: instance.hash) for own in collections)
    return [instance for row in zip_longest(*ordered) for instance in row if instance is not None]


class Choices:
    """Runs the choices on an instance."""

    def __init__(self, meliora: str, limit: int, threads: int, folder: Path) -> None:
        self.meliora, self.limit, self.threads, self.folder = meliora, limit, threads, folder

    def run(self, instance: Instance, choice: str) -> Run:
        asked = ["reach", str(instance.model), *instance.question]
        if instance.preferences:
            asked = ["check", str(instance.model), str(instance.preferences), *instance.question]
        command = [self.meliora, *asked, *self.options(instance, choice)]
        limit = self.limit * (AUTO_SHARE if choice == "auto" else 1)
        limited = ["sh", "-c", 'ulimit -t "$0"; exec "$@"', str(limit), *command, "--json", "--quiet"]
        finished = harness.run(limited, 60.0 * limit)
        report = harness.json_object(finished.stdout) or {}
        # A property that does not hold has status 1.
        found = answer(report) if finished.status in (0, 1) else None
        return Run(finished.cpu_seconds if self.threads == 1 else finished.seconds, finished.peak_bytes, found)

    def runs(self, instance: Instance, choices: list[str], floor: float) -> dict[str, Run]:
        """Runs the choices, `auto` first; only that if it takes less than `floor`."""
        runs = {"auto": self.run(instance, "auto")}
        if runs["auto"].found is None or runs["auto"].seconds > floor:
            # All valuations are another question for `check`.
            others = [c for c in choices if c != "auto" and not (instance.preferences and "+" in c)]
            runs |= {choice: self.run(instance, choice) for choice in others}
        return runs

    def options(self, instance: Instance, choice: str) -> list[str]:
        if choice == "auto":
            return ["--threads", str(self.threads)]
        if choice in ENGINES:
            return ["--engine", choice]
        order, _, scope = choice.partition("+")
        named = order if order == "declared" else str(self.order(instance, order))
        return ["--engine", "symbolic", "--order", named, *(["--scope", scope] if scope else [])]

    @staticmethod
    def constants(instance: Instance) -> tuple[str, ...]:
        return instance.question if instance.preferences else instance.question[2:]

    def order(self, instance: Instance, order: str) -> Path:
        """A file with the variables in an order."""
        # The variables are known before the states, which may be too many.
        info = [self.meliora, "info", str(instance.model), *self.constants(instance), "--json", "--timeout", "1"]
        said = harness.run(info, 60.0)
        variables = (harness.json_object(said.stdout) or {}).get("model", {}).get("variables", [])
        if order == "reversed":
            variables = variables[::-1]
        else:
            variables = sorted(variables, key=lambda v: v["low"] - v["high"])
        path = self.folder / f"{order}.order"
        path.write_text("".join(f"{v['name']}\n" for v in variables), encoding="utf-8")
        return path


def answer(report: dict[str, Any]) -> str:
    """What a report says about the initial states, which all scopes agree on, and about the levels."""
    keys = ("initial", "holds", "objectives", "classes", "sasi", "spi")
    return json.dumps({key: report.get(key) for key in keys}, sort_keys=True)


def regret(runs: dict[str, Run], floor: float) -> tuple[float, str, float]:
    """The time of the best choice, its name, and the regret; infinite if only `auto` found nothing."""
    done = {choice: max(run.seconds, floor) for choice, run in runs.items() if run.found is not None}
    best = min(done, key=lambda choice: done[choice])
    return done[best], best, done.get("auto", math.inf) / done[best]


def memory(runs: dict[str, Run], floor: float) -> float:
    """The memory of `auto` over that of the best choice."""
    _, best, _ = regret(runs, floor)
    return runs["auto"].peak_bytes / runs[best].peak_bytes


def row(name: str, half: str, runs: dict[str, Run], floor: float) -> str:
    auto = runs["auto"]
    own = f"{auto.seconds:.2f}" if auto.found is not None else "–"
    if all(run.found is None for run in runs.values()):
        return f"| {name} | {half} | – | – | – | – | – |"
    seconds, best, ratio = regret(runs, floor)
    return f"| {name} | {half} | {own} | {best} | {seconds:.2f} | {ratio:.1f} | {memory(runs, floor):.1f} |"


def summary(name: str, own: list[dict[str, Run]], floor: float) -> str:
    """A row of the table of docs/benchmarks.md."""
    answered = [runs for runs in own if any(run.found is not None for run in runs.values())]
    ratios = [regret(runs, floor)[2] for runs in answered]
    finite = [ratio for ratio in ratios if math.isfinite(ratio)]
    mean = math.exp(sum(map(math.log, finite)) / len(finite)) if finite else math.nan
    slow = sum(len(runs) > 1 for runs in own)
    worst = max(finite, default=math.nan)
    most = max((memory(runs, floor) for runs in answered), default=math.nan)
    cells = [name, len(own), slow, len(answered), len(finite), f"{mean:.2f}", f"{worst:.1f}", f"{most:.1f}"]
    return "| " + " | ".join(map(str, cells)) + " |"


def table(results: list[tuple[Instance, dict[str, Run]]], floor: float) -> list[str]:
    """The rows of all collections, by halves."""
    head = f"instances | above {floor:g} s | answered by some choice | by `auto` | geometric mean | worst | memory |"
    lines = [f"| collection, half | {head}", "| --- " * 8 + "|"]
    for collection in [*dict.fromkeys(i.collection for i, _ in results), None]:
        for half in HALVES:
            own = [runs for i, runs in results if i.half == half and collection in (i.collection, None)]
            lines.append(summary(f"{collection or 'all'}, {half}", own, floor))
    return lines


def measure(options: argparse.Namespace, folder: Path) -> int:
    meliora = harness.find_meliora(options.meliora)
    collections = [list(instances(source, options.root, folder)) for source in options.sources]
    wanted = [i for i in in_turns(collections) if options.half in ("both", i.half)]
    wanted = [i for i in wanted if i.hash[1] % options.part == 0]
    results: list[tuple[Instance, dict[str, Run]]] = []
    differ = 0
    lines = ["| instance | half | `auto`, s | best choice | s | regret | memory |", "| --- " * 7 + "|"]
    choices = Choices(meliora, options.limit, options.threads, folder)
    end = time.monotonic() + 60.0 * options.minutes
    for instance in wanted:
        if time.monotonic() > end:
            break
        runs = choices.runs(instance, options.choices, options.floor)
        found = {run.found for run in runs.values() if run.found is not None}
        if len(found) > 1:
            differ += 1
            print(f"{instance.name}: the choices differ: {found}", file=sys.stderr)
        results.append((instance, runs))
        if len(runs) > 1:
            lines.append(row(instance.name, instance.half, runs, options.floor))
            print(lines[-1], flush=True)
    rows = table(results, options.floor)
    print("\n".join(rows))
    if options.markdown:
        options.markdown.write_text("\n".join([*rows, "", *lines]) + "\n", encoding="utf-8")
    if options.json:
        values = {i.name: {c: (r.seconds, r.peak_bytes, r.found is not None) for c, r in runs.items()} for i, runs in results}
        options.json.write_text(json.dumps(values, indent=1) + "\n", encoding="utf-8")
    return int(differ > 0)


def main() -> int:
    assert __doc__ is not None
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sources", nargs="+")
    parser.add_argument("--root", type=Path)
    parser.add_argument("--half", choices=(*HALVES, "both"), default="both")
    parser.add_argument("--part", type=int, default=1, help="one in this many instances")
    parser.add_argument("--minutes", type=float, default=math.inf, help="begin no instance later")
    parser.add_argument("--limit", type=int, default=15, help="seconds of processor time of each choice")
    parser.add_argument("--floor", type=float, default=0.2, help="times below count as this many seconds")
    parser.add_argument("--threads", type=int, default=1, help="threads of `auto`")
    parser.add_argument("--choices", type=lambda text: text.split(","), default=list(CHOICES))
    parser.add_argument("--json", type=Path)
    parser.add_argument("--markdown", type=Path)
    parser.add_argument("--meliora")
    options = parser.parse_args()
    unknown = set(options.choices) - set(CHOICES)
    if unknown or "auto" not in options.choices:
        harness.stop(f"--choices: `auto` and some of {', '.join(CHOICES[1:])}")
    with tempfile.TemporaryDirectory() as folder:
        return measure(options, Path(folder))


if __name__ == "__main__":
    sys.exit(main())
