#!/usr/bin/env python3
"""Sweeps a family over its size for both engines of Meliora, as whole processes.

usage: bench.py [--sizes 8,16,32,64,128,256] [--items 3,6,12] [--runs 3] [--timeout 40] [--memory 4GiB]
                [--engines symbolic] [--csv bench.csv] [--plot crossover.svg] [--markdown table.md]
       bench.py --family models/fleet.prism --prefs models/fleet.pref --const 'L={size}' --sizes 1,2,3,7,63,511

The family is the grid world of `meliora generate gridworld`, or files whose name holds {size}; with --const 'N={size}'
also one file with a constant. Each point is `meliora check` on a model and its preferences: states, seconds of the
whole process (median of the runs) and its largest resident set (the greatest of the runs); what takes ten seconds is not run
again. An engine that is stopped or runs out of memory is not tried on larger sizes. The CSV has one row a run, with its
processor time, machine and version; the plot has states against time and against memory, both axes logarithmic; --markdown writes the table of
`docs/benchmarks.md`. Needs matplotlib for --plot.
Exit status: 0 done, 1 the engines differ in a number or a run failed, 2 usage.
"""

from __future__ import annotations

import argparse
import csv
import statistics
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Iterator

import harness
import plots

ENGINES = ("symbolic", "explicit")
# A point that has taken this many seconds is not measured again: long runs vary little.
ENOUGH = 10.0
RESULTS = ("counts", "objectives", "classes", "improvement", "sasi", "spi", "initial")


@dataclass(frozen=True)
class Member:
    """One member of the family."""

    series: str
    size: int
    model: Path
    preferences: Path
    constants: str


@dataclass(frozen=True)
class Point:
    """The runs of one engine on one member."""

    member: Member
    engine: str
    runs: list[harness.Finished]
    report: dict[str, Any]
    status: str

    @property
    def states(self) -> int | None:
        counts = self.report.get("counts")
        return int(counts["states"]) if counts else None

    @property
    def seconds(self) -> float:
        return statistics.median(run.seconds for run in self.runs)

    @property
    def cpu_seconds(self) -> float:
        return statistics.median(run.cpu_seconds for run in self.runs)

    @property
    def peak_bytes(self) -> int:
        return max(peak(run) for run in self.runs)


def peak(run: harness.Finished) -> int:
    """The peak memory, from the report of Meliora: the system's number includes the process it was forked from."""
    memory = (harness.json_object(run.stdout) or {}).get("memory") or {}
    return int(memory.get("peak_rss_bytes") or run.peak_bytes)


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sizes", type=harness.integers, default=[8, 16, 32, 64, 128, 256], metavar="N,…")
    parser.add_argument("--items", type=harness.integers, default=[3, 6, 12], metavar="K,…", help="of the grid worlds")
    parser.add_argument("--seed", type=int, default=1, help="of the grid worlds")
    parser.add_argument("--family", metavar="PATTERN", help="model files instead of grid worlds, with {size}")
    parser.add_argument("--prefs", metavar="PATTERN", help="their preference files")
    parser.add_argument("--const", default="", metavar="PATTERN", help="their constants")
    parser.add_argument("--meliora", metavar="PATH", help="the binary")
    parser.add_argument("--engines", type=lambda text: text.split(","), default=list(ENGINES), metavar="E,…")
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--timeout", type=float, default=40.0, metavar="SECONDS", help="for each run")
    parser.add_argument("--memory", default="4GiB", metavar="SIZE", help="passed on to Meliora")
    parser.add_argument("--csv", type=Path)
    parser.add_argument("--plot", type=Path, help="crossover plot, .svg or .png")
    parser.add_argument("--markdown", type=Path, help="table for docs/benchmarks.md")
    given = parser.parse_args()
    if not set(given.engines) <= set(ENGINES):
        parser.error(f"--engines: expected some of {', '.join(ENGINES)}")
    if bool(given.family) != bool(given.prefs):
        parser.error("--family and --prefs go together")
    return given


def members(given: argparse.Namespace, meliora: str, folder: Path) -> Iterator[Member]:
    """The family, series by series, each from small to large."""
    sizes = sorted(given.sizes)
    for size in sizes if given.family else []:
        model, preferences, constants = (text.replace("{size}", str(size)) for text in (given.family, given.prefs, given.const))
        yield Member(Path(given.family).stem, size, Path(model), Path(preferences), constants)
    for items in given.items if not given.family else []:
        for size in sizes:
            world = harness.gridworld(meliora, size, items, given.seed, folder)
            yield Member(f"{items} items", size, world.model, world.preferences, "")


def measure(given: argparse.Namespace, meliora: str, member: Member, engine: str) -> Point:
    """All runs of one engine on one member; a run that fails is the last."""
    command = [meliora, "check", str(member.model), str(member.preferences), "--engine", engine, "--json", "--quiet"]
    command += ["--timeout", f"{given.timeout:g}s"]
    command += ["--const", member.constants] if member.constants else []
    command += ["--memory", given.memory]
    runs: list[harness.Finished] = []
    while len(runs) < given.runs and all(run.status == 0 for run in runs):
        runs.append(harness.run(command, given.timeout + 10.0))
        if sum(run.seconds for run in runs) > ENOUGH:
            break
    last = runs[-1]
    stopped = last.timed_out or last.status == harness.OUT_OF_RESOURCES
    status = "done" if last.status == 0 else f"{'stopped' if stopped else 'failed'}: {harness.complaint(last)}"
    return Point(member, engine, runs, harness.json_object(last.stdout) or {}, status)


def sweep(given: argparse.Namespace, meliora: str, folder: Path) -> Iterator[Point]:
    """Every point, the engines alternating; an engine that was stopped leaves the rest of its series out."""
    ended: set[tuple[str, str]] = set()
    for member in members(given, meliora, folder):
        for engine in given.engines:
            if (member.series, engine) not in ended:
                point = measure(given, meliora, member, engine)
                if point.status != "done":
                    ended.add((member.series, engine))
                yield point


def differences(points: list[Point]) -> list[str]:
    """Returns the members on which the engines report different results."""
    found: dict[Member, list[Point]] = {}
    for point in points:
        if point.status == "done":
            found.setdefault(point.member, []).append(point)
    return [
        f"{member.series}, size {member.size}: the engines differ in {name}"
        for member, pair in found.items()
        for name in RESULTS
        if any(point.report.get(name) != pair[0].report.get(name) for point in pair)
    ]


def show(point: Point) -> None:
    """Prints a point as a line of the table."""
    states = "?" if point.states is None else str(point.states)
    line = f"{point.member.series:14} {point.member.size:>6} {point.engine:9} {states:>24}"
    line += f" {point.seconds:>9.3f} s {point.cpu_seconds:>9.3f} s cpu {point.peak_bytes / 2**20:>8.0f} MiB"
    print(line + ("" if point.status == "done" else f"  {point.status}"), flush=True)


def write_csv(path: Path, points: list[Point], meliora: str) -> None:
    """Writes one row per run."""
    about = [harness.machine(), harness.version(meliora)]
    with path.open("w", newline="", encoding="utf-8") as file:
        out = csv.writer(file)
        out.writerow(["series", "size", "engine", "run", "states", "seconds", "cpu_seconds", "peak_bytes", "status", "machine", "version"])
        for point in points:
            for number, run in enumerate(point.runs, 1):
                status = "done" if run.status == 0 else point.status
                head = [point.member.series, point.member.size, point.engine, number, point.states]
                out.writerow([*head, f"{run.seconds:.4f}", f"{run.cpu_seconds:.4f}", peak(run), status, *about])


def write_markdown(path: Path, points: list[Point], given: argparse.Namespace, meliora: str) -> None:
    """Writes the table of docs/benchmarks.md: one row per member, one column per engine, and which is ahead."""
    rows: dict[Member, dict[str, Point]] = {}
    for point in points:
        rows.setdefault(point.member, {})[point.engine] = point
    first = "grid" if not given.family else "size"
    lines = [f"|  | {first} | states | " + " | ".join(ENGINES) + " |", "| --- " * (3 + len(ENGINES)) + "|"]
    for member, row in rows.items():
        states = next((f"{point.states:,}" for point in row.values() if point.states), "")
        size = str(member.size) if given.family else f"{member.size} x {member.size}"
        cells = [cell(row.get(engine), given) for engine in ENGINES]
        lines.append("| " + " | ".join([member.series, size, states, *cells]) + " |")
    about = f"{harness.version(meliora)}; {harness.machine()}; at most {given.timeout:g} s and {given.memory} a run."
    lines += ["", *ahead(rows), "", about]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def cell(point: Point | None, given: argparse.Namespace) -> str:
    """Returns the table cell for one engine on one member."""
    if point is None:
        return "–"
    if point.status == "done":
        return f"{point.seconds:.2f} s, {point.peak_bytes / 2**20:.0f} MiB"
    if point.status.startswith("failed"):
        return "failed"
    return f"more than {given.timeout:g} s" if point.runs[-1].seconds >= given.timeout else f"more than {given.memory}"


def done(point: Point | None) -> Point | None:
    """Returns the point if the engine finished there."""
    return point if point is not None and point.status == "done" else None


def ahead(rows: dict[Member, dict[str, Point]]) -> list[str]:
    """Returns a sentence per series: the number of states from which on the symbolic engine is never slower."""
    said = []
    for series in dict.fromkeys(member.series for member in rows):
        first: int | None = None
        for member in (member for member in rows if member.series == series):
            symbolic, explicit = (done(rows[member].get(engine)) for engine in ENGINES)
            if symbolic is None and explicit is None:
                continue
            if symbolic is None or (explicit is not None and explicit.seconds < symbolic.seconds):
                first = None
            elif first is None:
                first = symbolic.states
        said.append(f"- {series}: " + (f"symbolic is ahead from {first:,} states on" if first else "explicit is ahead throughout"))
    return said


def draw(path: Path, points: list[Point]) -> None:
    """Draws the crossover plot of the finished points."""
    panels: dict[str, dict[str, list[tuple[float, float]]]] = {"seconds": {}, "MiB": {}}
    for point in points:
        if point.status == "done" and point.states:
            name = f"{point.engine}, {point.member.series}"
            panels["seconds"].setdefault(name, []).append((float(point.states), point.seconds))
            panels["MiB"].setdefault(name, []).append((float(point.states), point.peak_bytes / 2**20))
    plots.crossover(path, panels, "meliora check: both engines")


def main() -> int:
    given = arguments()
    if given.plot is not None:
        plots.require()
    meliora = harness.find_meliora(given.meliora)
    print(f"{harness.version(meliora)} on {harness.machine()}; {given.runs} runs, {given.timeout:g} s each")
    points: list[Point] = []
    with tempfile.TemporaryDirectory() as folder:
        for point in sweep(given, meliora, Path(folder)):
            points.append(point)
            show(point)
            if given.csv is not None:
                write_csv(given.csv, points, meliora)
    if given.plot is not None:
        draw(given.plot, points)
    if given.markdown is not None:
        write_markdown(given.markdown, points, given, meliora)
        print(given.markdown.read_text(encoding="utf-8"), end="")
    wrong = differences(points)
    print("\n".join(wrong), end="\n" if wrong else "")
    return 1 if wrong or any(point.status.startswith("failed") for point in points) else 0


if __name__ == "__main__":
    sys.exit(main())
