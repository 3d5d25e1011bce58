#!/usr/bin/env python3
"""Compares Meliora with Storm and PRISM on the same models in one go.

usage: compare_peers.py --corpus FOLDER                 the models of FOLDER/perf.json, or of a FILE like it
       compare_peers.py --gridworld 16,32 --items 3,6   grid worlds, through `meliora generate gridworld`
       compare_peers.py ... --prism DIR --runs 5 --timeout 60 --csv runs.csv --plot scatter.svg

Both kinds of input may be given at once. perf.json is a list of {id, model, constants, target}, models relative to
FOLDER, in PRISM's language or in JANI (which PRISM does not read: there it is left out); in place of a target there
may be a list of targets, the first of which is asked.

Every run is a process of its own with a time limit, and the median counts; a run over 20 s is not repeated. First the
binaries of Meliora go through all instances, taking turns on each, then the peers one by one: Storm frees gigabytes, and
while the kernel clears them, the next processes take up to 0.2 s longer.
Times below 20 ms count as 20 ms for every tool (--floor). The phases, as each tool tells them:

  build          from the model's text to the reachable states
  existential    the two regions of Pmax: where some strategy reaches the target almost surely, or possibly
  universal      the two regions of Pmin: where every strategy does. Markov chains have none of their own
  regions        all four
  total          the wall time of the whole process, from the text to the four answers
  cpu            its user and system time. Of all these only this one means something on a machine that does other work

Storm and PRISM compute both regions of Pmax for either question, and both of Pmin: for them, existential, universal and
regions are the time of the first question of each kind, for Meliora the sum of its phases. In total and cpu, all four
questions count. The start-up of a peer is measured before, printed, and taken from its total and cpu: for Storm that of
Python with the import of stormpy, for PRISM that of `prism -version`. Of Meliora nothing is taken off.
--before names an older binary of Meliora, which is measured like a peer.

A ratio is the peer's time by Meliora's: above 1 Meliora is faster. `>` marks the phase in which a peer was stopped,
from the time that was left for it (its start-up included); such instances stay out of the geometric means and are
counted beside them. At the end, all instances on which a peer is faster are listed. Storm runs on one thread unless
--storm-threads says otherwise.
Exit status: 0 the counts agree, 1 they differ somewhere, 2 usage. Needs stormpy (unless --storm none), and matplotlib
for --plot.
"""

from __future__ import annotations

import argparse
import csv
import math
import re
import statistics
import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import Iterator

import harness
import peers
import plots
from peers import Instance, Measurement, Tool

# Runs of more seconds are not repeated.
LONG = 20.0
COLUMNS = ("build", "existential", "universal", "regions", "total", "cpu")
# The phases of a peer that make up a column, in which it may be stopped; for the last two columns these are all.
WITHIN = {
    "build": ("build",),
    "existential": ("pmax_one",),
    "universal": ("pmin_one",),
    "regions": ("pmax_one", "pmin_one"),
}
Runs = dict[str, list[Measurement]]


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--corpus", type=Path, metavar="FOLDER", help="a folder with a perf.json, or such a file")
    parser.add_argument("--gridworld", type=harness.integers, default=[], metavar="N,…", help="rows and columns")
    parser.add_argument("--items", type=harness.integers, default=[3, 6, 9, 12], metavar="K,…")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--objectives", type=int, default=1, metavar="N", help="ask for the first N objectives")
    parser.add_argument("--filter", type=re.compile, default="", metavar="REGEX", help="only instances whose name matches")
    parser.add_argument("--meliora", metavar="PATH", help="the binary")
    parser.add_argument("--before", metavar="PATH", help="an older binary of Meliora")
    parser.add_argument("--storm", default="dd,sparse", metavar="dd,sparse|none")
    parser.add_argument("--storm-threads", type=int, default=1, metavar="N")
    parser.add_argument("--prism", type=Path, metavar="DIR", help="a PRISM installation")
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--timeout", type=float, default=60.0, metavar="SECONDS", help="for each run")
    parser.add_argument("--floor", type=float, default=0.02, metavar="SECONDS", help="shorter times count as this (0.02)")
    parser.add_argument("--csv", type=Path, help="every run, with machine and version")
    parser.add_argument("--plot", type=Path, help="scatter plot, .svg or .png")
    given = parser.parse_args()
    if given.corpus is None and not given.gridworld:
        parser.error("name a --corpus, sizes of --gridworld, or both")
    if given.floor <= 0:
        parser.error("--floor is above 0")
    return given


def instances(given: argparse.Namespace, meliora: str, folder: Path) -> Iterator[Instance]:
    """Yields the measured instances: the corpus first, then the grid worlds."""
    if given.corpus is not None:
        listed = given.corpus if given.corpus.is_file() else given.corpus / "perf.json"
        for entry in harness.read_json(listed):
            target = entry["target"] if "target" in entry else entry["targets"][0]["target"]
            yield Instance(entry["id"], listed.parent / entry["model"], entry["constants"], target)
    for size in given.gridworld:
        for items in given.items:
            world = harness.gridworld(meliora, size, items, given.seed, folder)
            for number, target in enumerate(world.targets[: given.objectives], 1):
                yield Instance(f"{world.name}, objective {number}", world.model, "", target)


@dataclass
class Comparison:
    """The runs by instance and tool, and the limits that count for them."""

    tools: list[Tool]
    timeout: float
    floor: float
    measured: dict[str, Runs] = field(default_factory=dict)

    def measure(self, group: list[Tool], instance: Instance, runs: int) -> None:
        """All runs of some tools on an instance, in turns."""
        found = self.measured.setdefault(instance.name, {})
        for _ in range(runs):
            for tool in group:
                done = found.setdefault(tool.name, [])
                if not done or (done[-1].done and done[-1].wall <= LONG):
                    done.append(tool.measure(instance, self.timeout))

    def median(self, runs: list[Measurement], phase: str) -> float | None:
        """The median over the runs that got through the phase, not below the floor."""
        times = [run.times[phase] for run in runs if phase in run.times]
        return max(self.floor, statistics.median(times)) if times else None

    def ratio(self, found: Runs, peer: str, phase: str) -> float | None:
        """Returns the time of the peer divided by that of Meliora; None if one of the two did not finish."""
        ours, theirs = self.median(found["meliora"], phase), self.median(found[peer], phase)
        return theirs / ours if ours and theirs else None

    def cell(self, found: Runs, peer: str, phase: str) -> str:
        """Returns a ratio as text; for the phase in which the peer was stopped, a lower bound."""
        known = self.ratio(found, peer, phase)
        if known is not None:
            return f"{known:.2f}"
        ours, theirs = self.median(found["meliora"], phase), found[peer][0]
        if ours is None or theirs.status != "stopped":
            return "-"
        within = WITHIN.get(phase, peers.PHASES)
        if next((name for name in peers.PHASES if name not in theirs.times), None) not in within:
            return "-"
        before = (theirs.times.get(name, 0.0) for name in peers.PHASES if name not in within)
        return f">{(self.timeout - sum(before)) / ours:.0f}"

    def show(self, name: str) -> bool:
        """Prints the measurements on an instance; returns whether the counts agree."""
        found = self.measured[name]
        ours = found["meliora"][0]
        print(f"\n{name}  ({ours.counts.get('states', '?')} states)")
        agree = True
        for tool, runs in found.items():
            seconds = [self.median(runs, phase) for phase in COLUMNS]
            print(f"  {tool:13}" + "".join(f"{'-' if s is None else f'{s:.3f}':>13}" for s in seconds), end="")
            print(f"{runs[0].peak_bytes / 2**20:>9.0f} MiB", "" if runs[-1].done else f"  {runs[-1].status}")
            if tool != "meliora":
                print(f"  {'  ratio':13}" + "".join(f"{self.cell(found, tool, phase):>13}" for phase in COLUMNS))
            differs = peers.disagreement(ours, runs[0])
            if differs:
                agree = False
                print(f"  COUNTS DIFFER: {differs}")
        sys.stdout.flush()
        return agree

    def summary(self) -> None:
        """Prints geometric mean, median, least and greatest ratio by peer and phase."""
        heads = ("both", "only us", "only peer", "geo. mean", "median", "least", "most")
        print(f"\n{'peer':13} {'phase':14}" + "".join(f"{head:>10}" for head in heads))
        for tool in self.tools[1:]:
            for phase in COLUMNS:
                every = self.measured.values()
                ratios = [r for found in every if (r := self.ratio(found, tool.name, phase)) is not None]
                done = [tuple(self.median(found[name], phase) is not None for name in ("meliora", tool.name)) for found in every]
                counts = (len(ratios), done.count((True, False)), done.count((False, True)))
                line = f"{tool.name:13} {phase:14}" + "".join(f"{count:>10}" for count in counts)
                if ratios:
                    mean = math.exp(statistics.fmean(map(math.log, ratios)))
                    figures = (mean, statistics.median(ratios), min(ratios), max(ratios))
                    line += "".join(f"{figure:>10.2f}" for figure in figures)
                print(line)

    def losses(self) -> None:
        """Prints every instance and phase in which a peer is faster."""
        for tool in self.tools[1:]:
            for phase in COLUMNS:
                ratios = ((name, self.ratio(found, tool.name, phase)) for name, found in self.measured.items())
                slower = sorted((r, name) for name, r in ratios if r is not None and r < 1)
                if slower:
                    print(f"{tool.name} is faster in {phase}: " + "; ".join(f"{name} {r:.2f}" for r, name in slower))

    def draw(self, path: Path) -> None:
        """The scatter plot of build, of the four regions and of the whole; at the time limit, a tool was stopped."""
        panels: dict[str, dict[str, list[tuple[float, float]]]] = {}
        for phase in ("build", "regions", "total"):
            for tool in self.tools[1:]:
                points = panels.setdefault(phase, {}).setdefault(tool.name, [])
                for found in self.measured.values():
                    ours, theirs = (self.place(found[name], phase) for name in ("meliora", tool.name))
                    if ours and theirs:
                        points.append((ours, theirs))
        plots.scatter(path, panels, self.floor, self.timeout)

    def place(self, runs: list[Measurement], phase: str) -> float | None:
        """Returns the position of a tool in the plot: the time limit if it was stopped, None if it failed."""
        return self.median(runs, phase) or (self.timeout if runs[0].status == "stopped" else None)


def write_csv(path: Path, measured: dict[str, Runs], meliora: str, threads: int) -> None:
    """Writes one row per run, in unrounded seconds."""
    about = [harness.machine(), harness.version(meliora), threads]
    with path.open("w", newline="", encoding="utf-8") as file:
        out = csv.writer(file)
        phases = list(dict.fromkeys([*peers.PHASES, *COLUMNS]))
        heads = [f"{phase}_s" for phase in phases] + [f"count_{count}" for count in peers.COUNTS]
        out.writerow(["instance", "tool", "run", "status", *heads, "wall_s", "peak_bytes", "machine", "version", "storm_threads"])
        for name, found in measured.items():
            for tool, runs in found.items():
                for number, run in enumerate(runs, 1):
                    values = [run.times.get(phase) for phase in phases] + [run.counts.get(count) for count in peers.COUNTS]
                    out.writerow([name, tool, number, run.status, *values, run.wall, run.peak_bytes, *about])


def main() -> int:
    given = arguments()
    if given.plot is not None:
        plots.require()
    meliora = harness.find_meliora(given.meliora)
    engines = [] if given.storm == "none" else given.storm.split(",")
    tools = peers.installed(meliora, given.before, engines, given.storm_threads, given.prism)
    print(f"{harness.version(meliora)} on {harness.machine()}; {given.runs} runs, {given.timeout:g} s each")
    for tool in tools:
        if tool.start_up.wall > 0:
            print(f"start-up of {tool.name}: {tool.start_up.wall:.3f} s, {tool.start_up.cpu:.3f} s of processor time")
    print(f"  {'':13}" + "".join(f"{phase:>13}" for phase in COLUMNS))
    ours: list[Tool] = [tool for tool in tools if isinstance(tool, peers.Meliora)]
    groups: list[list[Tool]] = [ours, *([tool] for tool in tools if tool not in ours)]
    comparison = Comparison(tools, given.timeout, given.floor)
    agree = True
    with tempfile.TemporaryDirectory() as folder:
        every = instances(given, meliora, Path(folder))
        chosen = [instance for instance in every if re.search(given.filter, instance.name)]
        for number, group in enumerate(groups, 1):
            for instance in chosen:
                comparison.measure(group, instance, given.runs)
                if number == len(groups):
                    agree &= comparison.show(instance.name)
                if given.csv is not None:
                    write_csv(given.csv, comparison.measured, meliora, given.storm_threads)
    if not comparison.measured:
        harness.stop("no instance matches --filter")
    comparison.summary()
    comparison.losses()
    if given.plot is not None:
        comparison.draw(given.plot)
    return 0 if agree else 1


if __name__ == "__main__":
    sys.exit(main())
