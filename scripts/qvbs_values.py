#!/usr/bin/env python3
"""Compares the values of `meliora reach` with the reference results of the Quantitative Verification Benchmark Set.

usage: qvbs_values.py BENCHMARKS [--models DIR] [--only TEXT] [--timeout S] [--storm] [--runs N] [--markdown FILE]
                      [--binary PATH] [--stop-at-target]

BENCHMARKS is the folder `benchmarks` of the set (https://github.com/ahartmanns/qcomp), whose files `index.json` have the
results; --models: the folder with the JANI files, if they are elsewhere. For each instance and property of type
`prob-reach` or `exp-reward` with a result, the interval must contain the reference value: exactly if the result is a
fraction, and up to its own precision (1e-3, relative) if it is an approximation. With --storm, Storm's sparse engine
computes the same values with its sound methods, as a process of its own (`pip install stormpy`). Times are CPU seconds in user
mode, the least of all runs, which alternate. With --stop-at-target, `reach` does not explore the states behind the target, as
Storm does not; the column of states has those explored.
Exit status: 0 all agree, 1 a difference, 2 usage.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import Any, Iterator

import harness
import storm_worker

# Exact results have thousands of digits.
sys.set_int_max_str_digits(0)

KINDS = ("prob-reach", "exp-reward")
APPROXIMATE = 1e-3


def instances(index: Path, models: Path) -> Iterator[tuple[str, Path, str, dict[str, Any]]]:
    """The name, file, constants and results by property of each instance whose file exists."""
    family = json.loads(index.read_text(encoding="utf-8-sig"))
    kinds = {p["name"]: p["type"] for p in family["properties"]}
    for file in family["files"]:
        path = models / index.parent.relative_to(index.parents[2]) / file["file"]
        if not path.exists():
            continue
        for setting in file.get("open-parameter-values", [{}]):
            constants = ",".join(f"{v['name']}={str(v['value']).lower()}" for v in setting.get("values", []))
            found = setting.get("results", file.get("results", []))
            results = {r["property"]: r["value"] for r in found if kinds.get(r["property"]) in KINDS}
            if results:
                yield path.stem + (f"[{constants}]" if constants else ""), path, constants, results


def reference(value: Any) -> tuple[Fraction | float, bool] | None:
    """A result and whether it is exact; truth values are not numbers."""
    if isinstance(value, dict) and "num" in value and "den" in value:
        return Fraction(int(value["num"]), int(value["den"])), True
    value = value.get("approx") if isinstance(value, dict) else value
    if value == "inf":
        return math.inf, True
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return None
    return float(value), False


def contains(bounds: dict[str, Any], value: Fraction | float, exact: bool) -> bool:
    low, high = (math.inf if x == "inf" else Fraction(x) for x in (bounds["lower"], bounds["upper"]))
    if exact or value == math.inf:
        return low <= value <= high
    slack = APPROXIMATE * max(abs(value), 1e-9)
    return low - slack <= value <= high + slack


def storm(path: str, constants: str, name: str) -> None:
    """Lets Storm compute one value, in this process; prints the seconds, building included."""
    import stormpy

    start = storm_worker.cpu_seconds()
    program, properties = stormpy.parse_jani_model(path)
    chosen = [p for p in properties if p.get_name() == name]
    program, chosen = stormpy.instantiate_constants(program, constants, chosen)
    model = stormpy.build_model(program, chosen)
    environment = stormpy.Environment()
    environment.solver().force_soundness = True
    stormpy.model_checking(model, chosen[0], environment=environment)
    print(json.dumps({"seconds": storm_worker.cpu_seconds() - start}))


def of_storm(runs: list[harness.Finished], timeout: float) -> str:
    """The least time of Storm, as text."""
    if any(run.timed_out for run in runs):
        return f"> {timeout:.0f} s"
    try:
        return f"{min(json.loads(run.stdout.splitlines()[-1])['seconds'] for run in runs):.2f} s"
    except (IndexError, json.JSONDecodeError):
        return "no answer"


def compare(args: argparse.Namespace, row: tuple[str, Path, str, dict[str, Any]]) -> Iterator[list[str]]:
    name, path, constants, results = row
    for prop, value in results.items():
        wanted = reference(value)
        if wanted is None:
            continue
        commands = [[args.binary, "reach", str(path), "--property", prop, "--json"]]
        commands[0] += ["--const", constants] if constants else []
        commands[0] += ["--stop-at-target"] if args.stop_at_target else []
        if args.storm:
            commands.append([sys.executable, __file__, "--ask-storm", str(path), constants, prop])
        runs = harness.alternately(args.runs, [partial(harness.run, c, args.timeout) for c in commands])
        done = runs[0][0]
        report = json.loads(done.stdout) if done.stdout.startswith("{") else {}
        bounds = (report.get("properties") or [{}])[0].get("value")
        if done.timed_out or not bounds:
            why = f"> {args.timeout:.0f} s" if done.timed_out else (report.get("error") or {}).get("message", done.stderr)
            answer, verdict = str(why).strip().splitlines()[0][:60] if why else "no value", "-"
        else:
            answer = f"[{bounds['lower']}, {bounds['upper']}]"
            verdict = "inside" if contains(bounds, *wanted) else "DIFFERS"
        states = (report.get("counts") or {}).get("states", "")
        shown = f"{float(wanted[0]):.9g}" + (" exact" if wanted[1] else "")
        seconds = min(run.cpu_seconds for run in runs[0])
        cells = [name, prop, str(states), shown, answer, verdict, f"{seconds:.2f} s"]
        yield cells + [of_storm(theirs, args.timeout) for theirs in runs[1:]]


def main() -> int:
    if sys.argv[1:2] == ["--ask-storm"]:
        storm(*sys.argv[2:])
        return 0
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("benchmarks", type=Path)
    parser.add_argument("--models", type=Path)
    parser.add_argument("--only", default="")
    parser.add_argument("--timeout", type=float, default=60)
    parser.add_argument("--storm", action="store_true")
    parser.add_argument("--runs", type=int, default=1)
    parser.add_argument("--markdown", type=Path)
    parser.add_argument("--binary", help="the command meliora")
    parser.add_argument("--stop-at-target", action="store_true")
    args = parser.parse_args()
    args.binary = harness.find_meliora(args.binary)
    heading = ["instance", "property", "states", "reference", "interval", "", "time"] + ["Storm"] * args.storm
    lines = ["| " + " | ".join(heading) + " |", "| " + " | ".join("---" for _ in heading) + " |"]
    differ = 0
    for index in sorted(args.benchmarks.glob("*/*/index.json")):
        for row in instances(index, args.models or args.benchmarks):
            if args.only not in row[0]:
                continue
            for cells in compare(args, row):
                differ += cells[5] == "DIFFERS"
                lines.append("| " + " | ".join(cells) + " |")
                print(lines[-1], flush=True)
    if args.markdown:
        args.markdown.write_text("\n".join(lines) + "\n")
    values = len(lines) - 2
    print(f"{values} values, {differ} differ")
    return int(differ > 0)


if __name__ == "__main__":
    sys.exit(main())
