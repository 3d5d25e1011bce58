#!/usr/bin/env python3
"""Counts the reachable states of Boolean networks, as whole processes of Meliora.

usage: boolean_networks.py COLLECTION [--only 75,116] [--every N] [--timeout 10] [--memory 4GiB] [--order auto,declared]
                           [--peer COMMAND] [--models DIR] [--csv FILE] [--markdown FILE]

COLLECTION is a checkout of https://github.com/sybila/biodivine-boolean-models, or any folder with files `*.bnet`. Each
network becomes a model of PRISM's language: one Boolean variable per variable of the network, and per variable v with
function f a command `[] f != v -> (v'=f)`. Variables without a function are inputs: they keep their value. Initially the
inputs have any value, and all other variables are false. `meliora info` counts the states; the time is that of the whole
process. Reading the model counts towards the limit. --models keeps the models.

--peer names another program, which gets the file .bnet as its last argument and prints the number of states. It runs
after Meliora on each network. The folder biodivine_reach has such a program; a limit on its memory can be part of the
command: --peer 'prlimit --as=4294967296 biodivine-reach'.
Exit status: 0 done, 1 two runs count different states or a run failed, 2 usage.
"""

from __future__ import annotations

import argparse
import csv
import math
import re
import shlex
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Iterator

import harness

NUMBER = re.compile(r"\bid-(\d+)\b")
WORD = re.compile(r"[A-Za-z_]\w*")
# Times below this many seconds are mostly those of the start of the process.
SHORT = 0.1


@dataclass(frozen=True)
class Network:
    """The update function of each variable, in the order of the file; inputs have none."""

    name: str
    path: Path
    functions: dict[str, str]
    inputs: list[str]

    @staticmethod
    def read(name: str, path: Path) -> Network:
        """Reads the format .bnet: lines `variable, function`, with `!`, `&`, `|`, brackets and 0, 1 or words."""
        text = path.read_text(encoding="utf-8")
        functions = {}
        for line in text.splitlines():
            target, comma, function = (part.strip() for part in line.partition("#")[0].partition(","))
            if comma and (target, function) != ("targets", "factors"):
                functions[target] = function
        used = {word: None for function in functions.values() for word in WORD.findall(function)}
        inputs = [word for word in used if word not in functions and word not in ("true", "false")]
        return Network(name, path, functions, inputs)

    def prism(self) -> str:
        """Returns the network in PRISM's language. Names get a prefix, so that none of them is a keyword."""
        renamed = {name: f"n_{name}" for name in [*self.inputs, *self.functions]}
        constants = {"0": "false", "1": "true"}

        def formula(text: str) -> str:
            text = re.sub(r"(?<!\w)[01](?!\w)", lambda found: constants[found[0]], text)
            return WORD.sub(lambda found: renamed.get(found[0], found[0]), text)

        lines = ["mdp", "module network"]
        lines += [f"  {name} : bool;" for name in renamed.values()]
        for name, function in self.functions.items():
            value = formula(function)
            lines.append(f"  [] ({value}) != {renamed[name]} -> ({renamed[name]}'=({value}));")
        first = " & ".join(f"!{renamed[name]}" for name in self.functions) or "true"
        return "\n".join([*lines, "endmodule", f"init {first} endinit", ""])


@dataclass(frozen=True)
class Point:
    """One run. The order is that of Meliora, or the name of the peer."""

    network: Network
    order: str
    finished: harness.Finished
    report: dict[str, Any]

    @property
    def states(self) -> int | None:
        counts = self.report.get("counts")
        return int(counts["states"]) if self.finished.status == 0 and counts else None

    @property
    def peak_nodes(self) -> int:
        return int((self.report.get("memory") or {}).get("peak_nodes") or 0)

    @property
    def status(self) -> str:
        if self.finished.status == 0:
            return "closed"
        # A negative status is that of a signal, which ends a peer that runs out of memory.
        if self.finished.timed_out or self.finished.status == harness.OUT_OF_RESOURCES or self.finished.status < 0:
            return "stopped"
        return "refused" if self.finished.status == 3 else "failed"


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("collection", type=Path)
    parser.add_argument("--only", type=harness.integers, metavar="N,…", help="numbers of networks")
    parser.add_argument("--every", type=int, default=1, metavar="N", help="only each N-th network")
    parser.add_argument("--meliora", metavar="PATH", help="the binary")
    parser.add_argument("--order", default="auto", metavar="ORDER,…", help="variable orders")
    parser.add_argument("--peer", type=shlex.split, metavar="COMMAND", help="another program that counts the states")
    parser.add_argument("--timeout", type=float, default=10.0, metavar="SECONDS", help="for each run")
    parser.add_argument("--memory", default="4GiB", metavar="SIZE", help="passed on to Meliora")
    parser.add_argument("--models", type=Path, metavar="DIR", help="keep the models there")
    parser.add_argument("--csv", type=Path)
    parser.add_argument("--markdown", type=Path, help="table for docs/benchmarks.md")
    return parser.parse_args()


def files(collection: Path) -> list[tuple[str, Path]]:
    """The networks of a collection with their names: the number in the path, else the file's name."""
    found = []
    for path in sorted(collection.rglob("*.bnet")):
        number = NUMBER.search(str(path.relative_to(collection)))
        found.append((number[1] if number else path.stem, path))
    return found


def chosen(given: argparse.Namespace) -> Iterator[Network]:
    """Yields the networks asked for."""
    all_files = files(given.collection)
    if not all_files:
        harness.stop(f"no file *.bnet in {given.collection}")
    for name, path in all_files[:: given.every]:
        if given.only is None or (name.isdigit() and int(name) in given.only):
            yield Network.read(name, path)


def measure(given: argparse.Namespace, meliora: str, network: Network, model: Path, order: str) -> Point:
    """Lets Meliora count the states of a network."""
    command = [meliora, "info", str(model), "--json", "--quiet", "--order", order, "--memory", given.memory]
    finished = harness.run([*command, "--timeout", f"{given.timeout:g}s"], given.timeout + 5.0)
    return Point(network, order, finished, harness.json_object(finished.stdout) or {})


def measure_peer(command: list[str], network: Network, timeout: float) -> Point:
    """Lets the peer count the states of a network."""
    finished = harness.run([*command, str(network.path)], timeout)
    report = {"counts": {"states": finished.stdout.strip()}} if finished.stdout.strip().isdigit() else {}
    return Point(network, Path(command[-1]).name, finished, report)


def show(point: Point) -> None:
    """Prints a run as a line of the table."""
    states = "" if point.states is None else f"{point.states:.4g}" if point.states < 1e300 else "more than 1e300"
    size = len(point.network.functions) + len(point.network.inputs)
    line = f"{point.network.name:>6} {size:>4} {point.order:15} {point.status:8} {point.finished.seconds:>7.2f} s"
    line += f" {point.peak_nodes:>9} nodes {states:>16}"
    print(line + ("" if point.status == "closed" else f"  {harness.complaint(point.finished)}"), flush=True)


def write_csv(path: Path, points: list[Point], meliora: str) -> None:
    """Writes one row per run."""
    about = [harness.machine(), harness.version(meliora)]
    with path.open("w", newline="", encoding="utf-8") as file:
        out = csv.writer(file)
        out.writerow(["network", "variables", "inputs", "order", "status", "states", "seconds", "peak_nodes", "machine", "version"])
        for point in points:
            network = point.network
            row = [network.name, len(network.functions) + len(network.inputs), len(network.inputs), point.order]
            out.writerow([*row, point.status, point.states, f"{point.finished.seconds:.4f}", point.peak_nodes, *about])


def summary(points: list[Point], timeout: float) -> list[str]:
    """Returns the table of docs/benchmarks.md: a row per order, and one for the peer."""
    lines = [f"| order or peer | networks | closed in {timeout:g} s | in 1 s | in 0.1 s | refused |", "| --- " * 6 + "|"]
    for order in dict.fromkeys(point.order for point in points):
        own = [point for point in points if point.order == order]
        closed = [point.finished.seconds for point in own if point.status == "closed"]
        within = [sum(seconds <= limit for seconds in closed) for limit in (math.inf, 1.0, SHORT)]
        refused = sum(point.status == "refused" for point in own)
        lines.append("| " + " | ".join(str(cell) for cell in [order, len(own), *within, refused]) + " |")
    return lines


def compared(points: list[Point]) -> list[str]:
    """Returns a table that compares the first order with each other one, and with the peer. Ratios of times are those of
    the networks closed by both, where one takes more than the time of starting the processes."""
    times: dict[str, dict[str, float]] = {point.order: {} for point in points}
    for point in points:
        if point.status == "closed":
            times[point.order][point.network.name] = point.finished.seconds
    name, first = next(iter(times.items()))
    lines = [f"| compared with {name} | closed by both | only by {name} | only by the other |"]
    lines = [f"{lines[0]} above {SHORT:g} s | geometric mean of the ratios | least | most |", "| --- " * 8 + "|"]
    for other, second in list(times.items())[1:]:
        both = [(first[network], second[network]) for network in first if network in second]
        ratios = sorted(b / a for a, b in both if max(a, b) > SHORT)
        cells = [other, len(both), len(first) - len(both), len(second) - len(both), len(ratios)]
        if ratios:
            mean = math.exp(sum(map(math.log, ratios)) / len(ratios))
            cells += [f"{mean:.2f}", f"{ratios[0]:.2f}", f"{ratios[-1]:.2f}"]
        lines.append("| " + " | ".join(str(cell) for cell in cells) + " |")
    return lines if len(times) > 1 else []


def differences(points: list[Point]) -> list[str]:
    """Returns the networks whose states two runs count differently."""
    counted: dict[str, set[int]] = {}
    for point in points:
        if point.states is not None:
            counted.setdefault(point.network.name, set()).add(point.states)
    return [f"network {name}: different counts: {sorted(counts)}" for name, counts in counted.items() if len(counts) > 1]


def main() -> int:
    given = arguments()
    meliora = harness.find_meliora(given.meliora)
    print(f"{harness.version(meliora)} on {harness.machine()}; {given.timeout:g} s each")
    points: list[Point] = []
    with tempfile.TemporaryDirectory() as temporary:
        folder = given.models or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        for network in chosen(given):
            model = folder / f"{network.name}.prism"
            model.write_text(network.prism(), encoding="utf-8")
            for order in given.order.split(","):
                points.append(measure(given, meliora, network, model, order))
                show(points[-1])
            if given.peer is not None:
                points.append(measure_peer(given.peer, network, given.timeout))
                show(points[-1])
    if given.csv is not None:
        write_csv(given.csv, points, meliora)
    table = [*summary(points, given.timeout), "", *compared(points)]
    if given.markdown is not None:
        about = f"{harness.version(meliora)}; {harness.machine()}; at most {given.timeout:g} s and {given.memory} a run."
        given.markdown.write_text("\n".join([*table, "", about, ""]), encoding="utf-8")
    wrong = differences(points)
    print("\n".join([*table, *wrong]))
    return 1 if wrong or any(point.status == "failed" for point in points) else 0


if __name__ == "__main__":
    sys.exit(main())
