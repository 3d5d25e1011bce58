#!/usr/bin/env python3
"""Compares the probabilities of `meliora reach` with those of Storm's sparse engine, and the times of both.

usage: compare_values.py FOLDER [--only TEXT] [--runs N] [--timeout S] [--memory M] [--csv FILE] [--binary PATH]
                         [--stop-at-target] [--steps K]

FOLDER/perf.json is a list of {id, model, constants, target}, models relative to FOLDER, in PRISM's language. For each
instance Pmax=? and Pmin=? of reaching the target are asked. Times are CPU seconds in user mode, the least of all runs, which
alternate: Meliora's are those of the whole process, Storm's those of reading, building and checking, with its sound methods,
in a process of its own (`pip install stormpy`). A value agrees if Storm's number is inside the interval, or at most 2e-6 away
from it. With --stop-at-target, `reach` does not explore the states behind the target, as Storm does not. With --steps K, the questions are those of at most K steps:
Pmax=? and Pmin=? of F<=K, and R{NAME}max=? of C<=K for the first reward structure with a name, if there is one.
Exit status: 0 all agree, 1 a difference, 2 usage.
"""

from __future__ import annotations

import argparse
import csv
import json
import math
import re
import sys
from pathlib import Path
from typing import Any

import harness
import storm_worker

# Twice the default precision of both tools.
SLACK = 2e-6
# Times below this many seconds are mostly those of the start of the process.
SHORT = 0.1
COLUMNS = ("id", "property", "lower", "upper", "storm", "seconds", "storm_seconds", "verdict")


def ask(model: str, constants: str, question: str) -> None:
    """Lets Storm compute one value in this process; prints its range over the initial states, and the seconds."""
    import stormpy

    start = storm_worker.cpu_seconds()
    program = storm_worker.parse(stormpy, model)
    asked = stormpy.parse_property(question, program)
    program, [asked] = stormpy.instantiate_constants(program, constants, [asked])
    built = stormpy.build_model(program, [asked])
    environment = stormpy.Environment()
    environment.solver().force_soundness = True
    result = stormpy.model_checking(built, asked, environment=environment)
    values = [result.get_value(state) for state in built.initial_states]
    print(json.dumps({"seconds": storm_worker.cpu_seconds() - start, "least": min(values), "most": max(values)}))


def last_object(text: str) -> dict[str, Any] | None:
    """The JSON object in the last line of a text."""
    try:
        return json.loads(text.splitlines()[-1])
    except (IndexError, json.JSONDecodeError):
        return None


def compare(args: argparse.Namespace, instance: dict[str, Any], question: str) -> dict[str, Any]:
    """One row of the table; cells without an answer are empty."""
    model, constants = str(args.folder / instance["model"]), instance["constants"] or ""
    command = [args.binary, "reach", model, "--property", question, "--json", "--quiet", "--memory", args.memory]
    command += ["--const", constants] if constants else []
    command += ["--stop-at-target"] if args.stop_at_target else []
    asked = [sys.executable, __file__, "--ask", model, constants, question]
    ours, theirs = harness.alternately(
        args.runs, [lambda: harness.run(command, args.timeout), lambda: harness.run(asked, args.timeout)]
    )
    report = json.loads(ours[0].stdout) if ours[0].status == 0 else {}
    bounds = (report.get("properties") or [{}])[0].get("value")
    answers = [last_object(run.stdout) for run in theirs if not run.timed_out]
    storm = min((answer for answer in answers if answer), key=lambda answer: answer["seconds"], default=None)
    row = dict.fromkeys(COLUMNS, "") | {"id": instance["id"], "property": question.split(" [")[0]}
    if bounds:
        row |= {"lower": bounds["lower"], "upper": bounds["upper"], "seconds": f"{min(run.cpu_seconds for run in ours):.2f}"}
    if storm:
        row |= {"storm": storm["least"], "storm_seconds": f"{storm['seconds']:.2f}"}
    if bounds and storm:
        inside = bounds["lower"] - SLACK <= storm["least"] and storm["most"] <= bounds["upper"] + SLACK
        row["verdict"] = "agrees" if inside else "differs"
    return row


def questions(instance: dict[str, Any], folder: Path, steps: int | None) -> list[str]:
    """The properties that are asked about an instance."""
    within = "" if steps is None else f"<={steps}"
    asked = [f"{best}=? [ F{within} ({instance['target']}) ]" for best in ("Pmax", "Pmin")]
    text = (folder / instance["model"]).read_text(encoding="utf-8", errors="replace")
    rewards = re.search(r'^\s*rewards\s+"(\w+)"', text, re.MULTILINE) if steps is not None else None
    return asked + ([f'R{{"{rewards[1]}"}}max=? [ C<={steps} ]'] if rewards else [])


def summary(rows: list[dict[str, Any]]) -> str:
    """Numbers of answers, and the geometric mean of Storm's time divided by Meliora's."""
    both = [row for row in rows if row["verdict"]]
    pairs = [(float(row["storm_seconds"]), float(row["seconds"])) for row in both]
    # A time is printed with two digits.
    long = [math.log(max(a, 0.01) / max(b, 0.01)) for a, b in pairs if max(a, b) > SHORT]
    mean = f"{math.exp(sum(long) / len(long)):.2f}" if long else "-"
    count = {name: sum(bool(row[name]) for row in rows) - len(both) for name in ("seconds", "storm_seconds")}
    differ = sum(row["verdict"] == "differs" for row in rows)
    return (
        f"{len(rows)} asked, {len(both)} answered by both, {differ} differ; only Meliora {count['seconds']}, "
        f"only Storm {count['storm_seconds']}\n"
        f"Storm's time divided by Meliora's, {len(long)} over {SHORT} s: geometric mean {mean}"
    )


def main() -> int:
    if sys.argv[1:2] == ["--ask"]:
        ask(*sys.argv[2:])
        return 0
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--only", default="")
    parser.add_argument("--runs", type=int, default=1)
    parser.add_argument("--timeout", type=float, default=20)
    parser.add_argument("--memory", default="4GiB")
    parser.add_argument("--csv", type=Path)
    parser.add_argument("--binary", help="the command meliora")
    parser.add_argument("--stop-at-target", action="store_true")
    parser.add_argument("--steps", type=int)
    args = parser.parse_args()
    args.binary = harness.find_meliora(args.binary)
    rows: list[dict[str, Any]] = []
    for instance in json.loads((args.folder / "perf.json").read_text()):
        if args.only not in instance["id"]:
            continue
        for question in questions(instance, args.folder, args.steps):
            rows.append(compare(args, instance, question))
            print("  ".join(str(cell) for cell in rows[-1].values()), flush=True)
    if args.csv:
        with args.csv.open("w", newline="") as file:
            writer = csv.DictWriter(file, COLUMNS)
            writer.writeheader()
            writer.writerows(rows)
    print(summary(rows))
    return int(any(row["verdict"] == "differs" for row in rows))


if __name__ == "__main__":
    sys.exit(main())
