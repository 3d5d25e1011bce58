#!/usr/bin/env python3
"""Compares regions of games with those of PRISM-games: symbolic against symbolic, explicit against explicit.

usage: compare_games.py FOLDER --prism-games DIR                     the instances of scripts/games.json
       compare_games.py FOLDER --prism-games DIR --instances FILE    those of another list
       compare_games.py ... --filter REGEX --runs 5 --timeout 60 --csv runs.csv --table games.md

The list has entries {id, model, constants, coalition, target}, with models relative to FOLDER. FOLDER contains the
models of the repositories prismmodelchecker/prism-games and ga67vib/Algorithms-For-Stochastic-Games, in folders of
these last names. DIR is a built PRISM-games.

Every run is a process of its own with a time limit. The tools take turns, so a busy machine slows all of them, and the
least time of all runs counts. Times below 5 ms count as 5 ms for every tool. The phases, as each tool tells them:

  build          from the model's text to the reachable states
  pmax_one       the states from which the coalition enforces the target almost surely (PRISM-games: Prob1)
  pmax_positive  the states from which it does so with positive probability (PRISM-games: Prob0)
  total          the sum of the three
  processor      processor time of the whole process, without that of the shortest run of the tool, which is its start
                 (0.9 s for PRISM-games). On a busy machine, it says more than the others, which are times of the clock.
                 Meliora's includes the regions of the opponent

Value iteration of PRISM-games begins after both regions; it is cut off and not counted. A ratio is PRISM-games' time by
that of Meliora's engine of the same kind: above 1 Meliora is faster. Instances that one tool did not finish stay out of
the geometric means.
Exit status: 0 the counts agree, 1 they differ somewhere, 2 usage.
"""

from __future__ import annotations

import argparse
import csv
import math
import re
import statistics
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Iterator

import harness
from peers import Instance, Measurement, Meliora, Tool

FLOOR = 0.005
# Runs of more seconds are not repeated.
LONG = 20.0
LARGE = 10_000
PHASES = ("build", "pmax_one", "pmax_positive")
COLUMNS = (*PHASES, "total")
COUNTS = ("states", "pmax_one", "pmax_positive")
PROCESSOR = "processor"
PAIRS = {"symbolic": "prism-games-mtbdd", "explicit": "prism-games-explicit"}
Runs = dict[str, list[Measurement]]


@dataclass
class PrismGames:
    """PRISM-games. The first step of value iteration ends the run: both regions are known then."""

    folder: Path
    engine: str

    @property
    def name(self) -> str:
        return f"prism-games-{self.engine}"

    def measure(self, instance: Instance, timeout: float) -> Measurement:
        question = f"<<{instance.coalition}>> Pmax=? [ F ({instance.target}) ]"
        command = [str(self.folder / "bin" / "prism"), str(instance.model), "-pf", question, "-maxiters", "1"]
        command += [f"-{self.engine}", "-javamaxmem", "8g", "-cuddmaxmem", "4g"]
        command += ["-const", instance.constants] if instance.constants else []
        finished = harness.run(command, timeout)
        result = Measurement(wall=finished.seconds, cpu=finished.cpu_seconds, peak_bytes=finished.peak_bytes)
        self._read(finished.stdout, result)
        if not {"pmax_one", "pmax_positive"} <= result.counts.keys():
            error = re.search(r"^Error: (.*)", finished.stdout, re.MULTILINE)
            result.status = "stopped" if finished.timed_out else error[1] if error else harness.complaint(finished)
        return result

    @staticmethod
    def _read(log: str, result: Measurement) -> None:
        built = re.search(r"^Time for model construction: ([\d.]+) seconds", log, re.MULTILINE)
        states = re.search(r"^States:\s+(\d+) ", log, re.MULTILINE)
        sizes = re.search(r"^target=\d+, yes=(\d+), no=(\d+), maybe=\d+", log, re.MULTILINE)
        if built:
            result.times["build"] = float(built[1])
        if states:
            result.counts["states"] = int(states[1])
        if not (states and sizes):
            return
        result.counts |= {"pmax_one": int(sizes[1]), "pmax_positive": int(states[1]) - int(sizes[2])}
        took = r"^Prob([01])(?: \(\w+\))? took \d+ iterations and ([\d.]+) seconds"
        spent = dict(re.findall(took, log, re.MULTILINE))
        # Without these lines, the target has no states, or all of them.
        result.times |= {"pmax_one": float(spent.get("1", 0)), "pmax_positive": float(spent.get("0", 0))}
        result.times["total"] = sum(result.times.values())


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="the models")
    parser.add_argument("--prism-games", type=Path, metavar="DIR", required=True, help="the folder prism of PRISM-games")
    parser.add_argument("--instances", type=Path, default=Path(__file__).with_name("games.json"))
    parser.add_argument("--filter", type=re.compile, default="", metavar="REGEX", help="only instances whose name matches")
    parser.add_argument("--engines", default="symbolic,explicit", metavar="symbolic,explicit")
    parser.add_argument("--meliora", metavar="PATH", help="the binary")
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--timeout", type=float, default=60.0, metavar="SECONDS", help="for each run")
    parser.add_argument("--csv", type=Path, help="every run, with machine and version")
    parser.add_argument("--table", type=Path, help="a table in Markdown")
    return parser.parse_args()


def instances(given: argparse.Namespace) -> Iterator[Instance]:
    """Yields the instances of the list."""
    for entry in harness.read_json(given.instances):
        if re.search(given.filter, entry["id"]):
            model = given.folder / entry["model"]
            yield Instance(entry["id"], model, entry.get("constants", ""), entry["target"], entry["coalition"])


def tools_of(given: argparse.Namespace) -> list[Tool]:
    """Meliora and PRISM-games, in turn by engine."""
    if not (given.prism_games / "bin" / "prism").exists():
        harness.stop(f"no PRISM-games in {given.prism_games}: expected {given.prism_games / 'bin' / 'prism'}")
    binary, tools = harness.find_meliora(given.meliora), []
    for engine in given.engines.split(","):
        tools += [Meliora(binary, engine, engine), PrismGames(given.prism_games, PAIRS[engine].rpartition("-")[2])]
    return tools


def measure(instance: Instance, tools: list[Tool], runs: int, timeout: float) -> Runs:
    """All runs of the tools, which take turns."""
    found: Runs = {tool.name: [] for tool in tools}
    for _ in range(runs):
        for tool in tools:
            known = found[tool.name]
            if not known or known[-1].done and known[-1].wall <= LONG:
                known.append(tool.measure(instance, timeout))
    return found


def least(runs: list[Measurement], phase: str) -> float | None:
    """The least time of a phase over the runs that ended, not below the floor; a sum has the floor for each part."""
    if phase == "total":
        parts = [least(runs, part) for part in PHASES]
        return None if None in parts else sum(part for part in parts if part)
    times = [run.times[phase] for run in runs if run.done and phase in run.times]
    return max(FLOOR, min(times)) if times else None


def ratio(found: Runs, engine: str, phase: str) -> float | None:
    """Returns the time of PRISM-games divided by that of Meliora; None if one of the two did not finish."""
    if engine not in found:
        return None
    ours, theirs = least(found[engine], phase), least(found[PAIRS[engine]], phase)
    return theirs / ours if ours and theirs else None


def net(measured: dict[str, Runs]) -> dict[str, Runs]:
    """Returns the runs with their processor times without the start of the tools as one more phase."""
    starts: dict[str, float] = {}
    for found in measured.values():
        for tool, runs in found.items():
            starts[tool] = min([starts.get(tool, math.inf), *(run.cpu for run in runs if run.done)])
    for found in measured.values():
        for tool, runs in found.items():
            for run in runs:
                run.times[PROCESSOR] = run.cpu - starts[tool]
    return measured


def show(name: str, found: Runs) -> bool:
    """Prints the measurements on an instance; returns whether the counts agree."""
    counts = next((runs[0].counts for runs in found.values() if runs[0].done), {})
    print(f"\n{name}  " + ", ".join(f"{what} {counts.get(what, '?')}" for what in COUNTS))
    agree = True
    for tool, runs in found.items():
        cells = [least(runs, phase) for phase in COLUMNS]
        print(f"  {tool:22}" + "".join(f"{'-' if s is None else f'{s:.3f}':>15}" for s in cells), end="")
        print(f"{min(run.cpu for run in runs):>9.2f} s CPU", "" if runs[0].done else f"  {runs[0].status}")
        if tool in PAIRS.values():
            engine = next(engine for engine, peer in PAIRS.items() if peer == tool)
            ratios = [ratio(found, engine, phase) for phase in COLUMNS]
            print(f"  {'  ratio':22}" + "".join(f"{'-' if r is None else f'{r:.2f}':>15}" for r in ratios))
        differing = {what for what in COUNTS if runs[0].done and runs[0].counts.get(what) != counts.get(what)}
        if differing:
            agree = False
            print(f"  COUNTS DIFFER: {runs[0].counts}")
    sys.stdout.flush()
    return agree


def is_large(found: Runs) -> bool:
    return max((runs[0].counts.get("states", 0) for runs in found.values()), default=0) > LARGE


def summary(measured: dict[str, Runs], engines: list[str]) -> None:
    """Prints geometric mean, least and greatest ratio by engine and phase, of large instances and of all."""
    heads = ("both", "only us", "only peer", "geo. mean", "least", "most")
    print(f"\n{'engine':10} {'instances':10} {'phase':14}" + "".join(f"{head:>10}" for head in heads))
    for engine in engines:
        for which, chosen in (("large", [r for r in measured.values() if is_large(r)]), ("all", list(measured.values()))):
            done = [(found[engine][0].done, found[PAIRS[engine]][0].done) for found in chosen]
            for phase in (*COLUMNS, PROCESSOR):
                ratios = [r for found in chosen if (r := ratio(found, engine, phase)) is not None]
                line = f"{engine:10} {which:10} {phase:14}"
                line += "".join(f"{n:>10}" for n in (len(ratios), done.count((True, False)), done.count((False, True))))
                if ratios:
                    mean = math.exp(statistics.fmean(map(math.log, ratios)))
                    line += f"{mean:>10.2f}{min(ratios):>10.2f}{max(ratios):>10.2f}"
                print(line)


def write_csv(path: Path, measured: dict[str, Runs], meliora: str) -> None:
    """Writes one row per run, in unrounded seconds."""
    about = [harness.machine(), harness.version(meliora)]
    with path.open("w", newline="", encoding="utf-8") as file:
        out = csv.writer(file)
        heads = [f"{phase}_s" for phase in COLUMNS] + [f"count_{count}" for count in COUNTS]
        out.writerow(["instance", "tool", "run", "status", *heads, "wall_s", "cpu_s", "peak_bytes", "machine", "version"])
        for name, found in measured.items():
            for tool, runs in found.items():
                for number, run in enumerate(runs, 1):
                    values = [run.times.get(phase) for phase in COLUMNS] + [run.counts.get(count) for count in COUNTS]
                    out.writerow([name, tool, number, run.status, *values, run.wall, run.cpu, run.peak_bytes, *about])


def write_table(path: Path, measured: dict[str, Runs], engines: list[str]) -> None:
    """Writes the counts, and for each engine the times of both tools and their ratios."""
    times = ("total", PROCESSOR)
    heads = ["game", "states", "surely", "possibly", *(f"{e}, {phase}: ours, theirs, ratio" for e in engines for phase in times)]
    lines = [f"| {' | '.join(heads)} |", "| --- |" + " --: |" * (len(heads) - 1)]
    for name, found in measured.items():
        counts = next((runs[0].counts for runs in found.values() if runs[0].done), {})
        cells = [name, *(f"{counts[what]:,}" if what in counts else "?" for what in COUNTS)]
        for engine, phase in ((engine, phase) for engine in engines for phase in times):
            both = [least(found[tool], phase) for tool in (engine, PAIRS[engine])]
            words = ["–" if time is None else f"{time:.2f}" for time in both]
            share = ratio(found, engine, phase)
            cells.append(", ".join([*words, "–" if share is None else f"{share:.1f}"]))
        lines.append(f"| {' | '.join(cells)} |")
    path.write_text("\n".join([*lines, ""]), encoding="utf-8")


def main() -> int:
    given = arguments()
    tools, engines = tools_of(given), given.engines.split(",")
    meliora = harness.find_meliora(given.meliora)
    print(f"{harness.version(meliora)} on {harness.machine()}; {given.runs} runs, {given.timeout:g} s each")
    print(f"  {'':22}" + "".join(f"{phase:>15}" for phase in COLUMNS))
    measured: dict[str, Runs] = {}
    agree = True
    for instance in instances(given):
        measured[instance.name] = measure(instance, tools, given.runs, given.timeout)
        agree &= show(instance.name, measured[instance.name])
        if given.csv is not None:
            write_csv(given.csv, measured, meliora)
        if given.table is not None:
            write_table(given.table, net(measured), engines)
    if not measured:
        harness.stop("no instance matches --filter")
    summary(net(measured), engines)
    return 0 if agree else 1


if __name__ == "__main__":
    sys.exit(main())
