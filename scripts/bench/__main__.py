"""Measures collections of models with several tools, and makes tables of the results.

    python3 scripts/bench run COLLECTION… [--tool TOOL]… [--ask KIND] [--results FILE] [options]
    python3 scripts/bench table KIND [--results FILE] [options]

COLLECTION is [NAME=]SOURCE; SOURCE is one of
  FILE.json            a list of objects {id, model, constants, …} with a target, targets, a property, or preferences; with
                       a coalition it is about a game. Models are relative to --root, or else to the list
  FOLDER               of models with preferences of the same name (for `check`) or a label `goal`; of Boolean networks
                       (`*.bnet`, whose states are counted); of PDDL problems, a folder for each domain; the folder
                       `benchmarks` of the Quantitative Verification Benchmark Set
  grids:SIZES:ITEMS[:SEEDS]       random grid worlds, as in grids:32,64:3,6
  family:MODEL:CONSTANT=VALUES    a model with its preferences, as in family:models/fleet.prism:L=1,3
TOOL is one of
  meliora [OPTIONS]    with these options; `meliora --engine explicit`. `before=BINARY` is an older one
  by-hand              the choices of a user, for `table regret`: run only where `meliora` takes more than --floor, and
                       `meliora` has four times the limit then
  storm-dd, storm-sparse          stormpy; prism=DIR, prism-games-mtbdd=DIR, prism-games-explicit=DIR: installations
  peer=COMMAND         a program that counts the states of a Boolean network, as scripts/biodivine_reach does
KIND of question: check, regions (the four regions of a target), property (Pmax=? and Pmin=? of a target, with --steps K
within K steps), states, plan (a policy is written and verified), values. Each collection has a usual one.

Every run is a process of its own with --limit seconds of processor time. The tools take turns on an instance. The results
are rows of JSON with the commit, the date and the machine: one file for each machine (default:
target/bench/HOST.jsonl). What it has of the same commit is not run again. A hash of its name puts an instance into
one of two halves: rules are chosen on the tuned half, and judged by both.

Tables: `list` (seconds and memory of each tool), `ratios` (a peer's time by Meliora's, phase by phase), `within`
(instances closed in the limit, 1 s and 0.1 s), `plans` (by domain), `regret` (`meliora` by the best choice by hand), each
with the commit and the date of its rows.
Exit status: 0 done, 1 the tools differ in an answer, 2 usage.
"""

from __future__ import annotations

import argparse
import json
import math
import platform
import re
import sys
import tempfile
import time
from dataclasses import asdict
from fractions import Fraction
from pathlib import Path
from typing import Any

sys.path[0] = str(Path(__file__).resolve().parent.parent)

import harness  # noqa: E402
from bench import instances, tables, tools  # noqa: E402

# The benchmark set has results of 6,295 digits, which Python reads without a limit only (3.9 has no limit).
getattr(sys, "set_int_max_str_digits", int)(0)

# The limit of `meliora`, which has several ways to try, over that of the choices by hand.
AUTO_SHARE = 4
# Runs of more seconds are not repeated.
LONG = 20.0
# Twice the default precision of the tools, relative above 1; the same of approximate results of the benchmark set.
SLACK, APPROXIMATE = 2e-6, 1e-3
Row = dict[str, Any]


def differs(one: Row, other: Row) -> list[str]:
    """Returns where two answers differ. Peers count in floating point: exact up to 2^53 only."""
    wrong = []
    for key in one.keys() & other.keys():
        a, b = one[key], other[key]
        if key == "value":
            slack = SLACK * max(1.0, abs(a[0]))
            same = a[0] - slack <= b[1] and b[0] <= a[1] + slack
        else:
            same = a == b or isinstance(a, int) and min(a, b) >= 2**53 and abs(a - b) <= a * 1e-9
        wrong += [] if same else [f"{key}: {a} against {b}"]
    return wrong


def contains(bounds: list[float | str], value: Fraction | float, exact: bool) -> bool:
    """Whether an interval contains a known value."""
    low, high = (math.inf if x == "inf" else Fraction(x) for x in bounds)
    slack = Fraction(0 if exact or value == math.inf else APPROXIMATE * max(abs(float(value)), 1e-9))
    return low - slack <= value <= high + slack


class Measuring:
    """The runs of some tools, and the file of their rows."""

    def __init__(self, given: argparse.Namespace, meliora: str, folder: Path) -> None:
        self.given = given
        self.tools = [made for text in given.tool for made in tools.tool(text, meliora, given.memory, folder)]
        said = harness.run([meliora, "--version"], 10.0).stdout
        commit = re.search(r"^commit (\S+)", said, re.MULTILINE)
        self.about = {
            "commit": commit[1] if commit else harness.version(meliora),
            "date": time.strftime("%Y-%m-%d"),
            "machine": harness.machine(),
        }
        self.rows = [row for row in tables.read(given.results) if row["commit"] == self.about["commit"]]

    def all(self, instance: instances.Instance) -> list[str]:
        """Runs the tools on an instance. Returns what differs."""
        found: list[Row] = []
        for number in range(self.given.runs):
            for tool in self.tools:
                if tool.reads(instance) and not self.is_spared(tool, found):
                    found.append(self.row(instance, tool, number))
        said = {row["tool"]: row["answer"] for row in found}
        first, *others = said.items() if said else [("", {})]
        wrong = [f"{first[0]} and {name}: {text}" for name, answer in others for text in differs(first[1], answer)]
        if instance.expected and "value" in first[1] and not contains(first[1]["value"], *instance.expected):
            wrong.append(f"{first[1]['value']} does not contain {instance.expected[0]}")
        return [f"{instance.key}: {text}" for text in wrong]

    def is_spared(self, tool: tools.Tool, found: list[Row]) -> bool:
        """Whether another run of the tool on the instance says nothing new."""
        own = [row for row in found if row["tool"] == tool.name]
        if own and (own[-1]["status"] != "done" or own[-1]["wall"] > LONG):
            return True
        auto = next((row for row in found if row["tool"] == "meliora"), None)
        is_by_hand = isinstance(tool, tools.Meliora) and tool.choice
        return bool(is_by_hand and auto and auto["status"] == "done" and auto["cpu"] <= self.given.floor)

    def row(self, instance: instances.Instance, tool: tools.Tool, number: int) -> Row:
        head = {"collection": instance.collection, "instance": instance.key, "half": instance.half, "tool": tool.name, "run": number}
        for row in self.rows:
            is_same = all(row[name] == value for name, value in head.items()) and row["limit"] >= self.given.limit
            if is_same and row["status"] in ("done", "stopped"):
                return row
        share = AUTO_SHARE if tool.name == "meliora" and "by-hand" in self.given.tool else 1
        run = tool.run(instance, self.given.limit * share)
        row = {**head, "limit": self.given.limit, **asdict(run), "start": tool.start, **self.about}
        self.given.results.parent.mkdir(parents=True, exist_ok=True)
        with self.given.results.open("a", encoding="utf-8") as file:
            file.write(json.dumps(row) + "\n")
        cells = [instance.key[:60], tool.name, run.status, f"{run.cpu:.2f} s cpu", f"{run.wall:.2f} s", f"{run.memory / 2**20:.0f} MiB"]
        print("  ".join(cells), flush=True)
        return row


def measure(given: argparse.Namespace, folder: Path) -> int:
    meliora = harness.find_meliora(given.meliora)
    collections = [instances.read(source, given.root, folder, meliora) for source in given.collections]
    if not all(collections):
        harness.stop("a collection has no instance")
    wanted = [i for i in instances.in_turns(collections) if given.half in ("both", i.half) and i.hash[1] % given.part == 0]
    wanted = [asked for i in wanted for asked in instances.asked(i, given.ask, given.steps) if re.search(given.filter, asked.key)]
    measuring, end = Measuring(given, meliora, folder), time.monotonic() + 60.0 * given.minutes
    wrong: list[str] = []
    for instance in wanted:
        if time.monotonic() < end:
            wrong += measuring.all(instance)
    print("\n".join([f"{len(wanted)} questions, {len(wrong)} differences in {given.results}", *wrong]))
    return int(bool(wrong))


def main() -> int:
    assert __doc__ is not None
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    run, table = commands.add_parser("run"), commands.add_parser("table")
    for command in (run, table):
        default = harness.ROOT / "target" / "bench" / f"{platform.node() or 'machine'}.jsonl"
        command.add_argument("--results", type=Path, default=default)
        command.add_argument("--floor", type=float, default=0.2, help="times below count as this many seconds")
    run.add_argument("collections", nargs="+")
    run.add_argument("--tool", action="append")
    run.add_argument("--ask", choices=instances.KINDS, default="")
    run.add_argument("--steps", type=int)
    run.add_argument("--root", type=Path)
    run.add_argument("--half", choices=(*instances.HALVES, "both"), default="both")
    run.add_argument("--part", type=int, default=1, help="one in this many instances")
    run.add_argument("--filter", default="", help="only questions that match")
    run.add_argument("--minutes", type=float, default=math.inf, help="begin no instance later")
    run.add_argument("--runs", type=int, default=1)
    run.add_argument("--limit", type=float, default=15, help="seconds of processor time of each run")
    run.add_argument("--memory", default="4GiB", help="passed on to Meliora")
    run.add_argument("--meliora", help="the binary")
    table.add_argument("kind", choices=sorted(tables.TABLES))
    table.add_argument("--collection", default="", help="only this one")
    table.add_argument("--commit", default="", help="only rows of this commit; else those of the last one")
    given = parser.parse_args()
    if given.command == "table":
        return tables.show(given)
    given.tool = given.tool or ["meliora"]
    with tempfile.TemporaryDirectory() as folder:
        return measure(given, Path(folder))


if __name__ == "__main__":
    sys.exit(main())
