"""The tools that `compare_peers.py` compares: how each is run and how its answers are read."""

from __future__ import annotations

import importlib.util
import json
import re
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar, Protocol, Sequence

import harness

# The regions in the order in which the peers are asked: the first of Pmax and of Pmin pay for the second.
REGIONS = ("pmax_one", "pmin_one", "pmax_positive", "pmin_positive")
PHASES = ("build", *REGIONS)
COUNTS = ("states", *REGIONS)
WORKER = Path(__file__).with_name("storm_worker.py")


@dataclass(frozen=True)
class StartUp:
    """Seconds that a tool takes before it reads anything."""

    wall: float = 0.0
    cpu: float = 0.0


def measure_start_up(command: Sequence[str]) -> StartUp:
    """The least time of five runs of a command that only starts the tool."""
    runs = [harness.run(command, 60.0) for _ in range(5)]
    return StartUp(min(run.seconds for run in runs), min(run.cpu_seconds for run in runs))


@dataclass(frozen=True)
class Instance:
    """One question about one model."""

    name: str
    model: Path
    constants: str
    target: str
    coalition: str = ""  # of a game: the players that want to reach the target


@dataclass
class Measurement:
    """One run of one tool: seconds by phase, counts, and what went wrong. The start-up is not part of `total` and `cpu`."""

    times: dict[str, float] = field(default_factory=dict)
    counts: dict[str, int] = field(default_factory=dict)
    wall: float = 0.0
    cpu: float = 0.0
    peak_bytes: int = 0
    status: str = "done"

    @property
    def done(self) -> bool:
        return self.status == "done"

    def add_sums(self, existential: Sequence[str], universal: Sequence[str]) -> None:
        """Adds the times of both regions of Pmax, both of Pmin, and all four, as sums of the phases that they take."""
        sums = {"existential": existential, "universal": universal, "regions": [*existential, *universal]}
        for name, phases in sums.items():
            if phases and all(phase in self.times for phase in phases):
                self.times[name] = sum(self.times[phase] for phase in phases)

    def add_totals(self, start_up: StartUp) -> None:
        """Adds the time of the whole process, if it came to its end."""
        if self.done:
            self.times["total"] = self.wall - start_up.wall
            self.times["cpu"] = self.cpu - start_up.cpu


class Tool(Protocol):
    """A program that answers the questions."""

    @property
    def name(self) -> str:
        """The name of the tool in tables."""
        ...

    @property
    def start_up(self) -> StartUp:
        """The seconds that are subtracted from its total."""
        ...

    def measure(self, instance: Instance, timeout: float) -> Measurement:
        """Runs it once as a process of its own."""
        ...


def _measurement(finished: harness.Finished) -> Measurement:
    status = "done" if finished.status == 0 else harness.complaint(finished)
    if finished.timed_out or finished.status == harness.OUT_OF_RESOURCES:
        status = "stopped"
    return Measurement(wall=finished.seconds, cpu=finished.cpu_seconds, peak_bytes=finished.peak_bytes, status=status)


@dataclass
class Meliora:
    """`meliora reach`. Its build is parsing, building and counting; each region has a phase of its own."""

    binary: str
    name: str = "meliora"
    engine: str = ""
    start_up: StartUp = StartUp()

    def measure(self, instance: Instance, timeout: float) -> Measurement:
        command = [self.binary, "reach", str(instance.model), "--target", instance.target, "--json", "--quiet"]
        command += ["--scope", "reachable", "--threads", "1", "--timeout", f"{timeout:g}s"]
        if instance.constants:
            command += ["--const", instance.constants]
        if instance.coalition:
            command += ["--coalition", instance.coalition]
        if self.engine:
            command += ["--engine", self.engine]
        finished = harness.run(command, timeout + 10.0)
        result = _measurement(finished)
        self._read(harness.json_object(finished.stdout) or {}, result)
        result.add_totals(self.start_up)
        return result

    @staticmethod
    def _read(report: dict[str, Any], result: Measurement) -> None:
        time = report.get("time") or {}
        result.times = {phase: time[phase] for phase in PHASES if time.get(phase) is not None}
        if "build" in result.times:
            result.times["build"] += time["parse"]
        chain = (report.get("model") or {}).get("type") == "dtmc"
        result.add_sums(("pmax_one", "pmax_positive"), () if chain else ("pmin_one", "pmin_positive"))
        found = {**report, "states": (report.get("counts") or {}).get("states")}
        result.counts = {count: int(found[count]) for count in COUNTS if found.get(count) is not None}


@dataclass
class Storm:
    """Storm by stormpy. Either question computes both regions: the first one asked stands for both.

    Its start-up is that of Python with the import of stormpy.
    """

    engine: str
    threads: int
    start_up: StartUp

    @property
    def name(self) -> str:
        return f"storm-{self.engine}"

    def measure(self, instance: Instance, timeout: float) -> Measurement:
        question = [str(instance.model), instance.constants, instance.target]
        command = [sys.executable, str(WORKER), self.engine, str(self.threads), *question]
        finished = harness.run(command, timeout)
        result = _measurement(finished)
        for line in finished.stdout.splitlines():
            if line.startswith("{"):
                self._read(json.loads(line), result)
        # Of a Markov chain only Pmax is asked.
        chain = result.done and "pmin_one" not in result.times
        result.add_sums(("pmax_one",), () if chain else ("pmin_one",))
        result.add_totals(self.start_up)
        return result

    @staticmethod
    def _read(told: dict[str, Any], result: Measurement) -> None:
        result.times[told["phase"]] = told["seconds"]
        # Above 2^64 Storm reports 0 states: then none of its counts mean anything.
        if told["phase"] == "build" or "states" in result.counts:
            result.counts |= {name: count for name, count in told["counts"].items() if name != "states" or count > 0}


@dataclass
class Prism:
    """PRISM's mtbdd engine. Each question computes both regions: the first one asked stands for both.

    Its start-up is that of `prism -version`, mostly the Java machine.
    """

    folder: Path
    start_up: StartUp
    name: str = "prism"
    # For an MDP, P<1 says that no strategy reaches 1: its complement is Pmax=1; P<=0 likewise.
    BOUNDS: ClassVar[dict[str, str]] = dict(zip(REGIONS, ("<1", ">=1", "<=0", ">0")))

    def measure(self, instance: Instance, timeout: float) -> Measurement:
        if instance.model.suffix == ".jani":
            return Measurement(status="does not read JANI")
        questions = [f"filter(count, P{bound} [ F ({instance.target}) ])" for bound in self.BOUNDS.values()]
        command = [str(self.folder / "bin" / "prism"), str(instance.model), "-mtbdd", "-pf", ";".join(questions)]
        if instance.constants:
            command += ["-const", instance.constants]
        finished = harness.run(command, timeout)
        result = _measurement(finished)
        self._read(finished.stdout, result)
        result.add_totals(self.start_up)
        return result

    @classmethod
    def _read(cls, log: str, result: Measurement) -> None:
        spent = re.findall(r"^Time for model (construction|checking): ([\d.]+) seconds", log, re.MULTILINE)
        result.times = dict(zip(PHASES, (float(seconds) for _, seconds in spent)))
        chain = re.search(r"^Type:\s+DTMC", log, re.MULTILINE)
        result.add_sums(("pmax_one",), () if chain else ("pmin_one",))
        states = re.search(r"^States:\s+(\d+) ", log, re.MULTILINE)
        if states is None:
            return
        result.counts["states"] = int(states[1])
        for (region, bound), number in zip(cls.BOUNDS.items(), re.findall(r"^Result: (-?\d+)", log, re.MULTILINE)):
            # PRISM counts in 32 bits and says -1 above.
            if int(number) >= 0:
                result.counts[region] = int(states[1]) - int(number) if bound.startswith("<") else int(number)


def installed(meliora: str, before: str | None, names: list[str], threads: int, prism: Path | None) -> list[Tool]:
    """Meliora and the peers that were asked for, Meliora first."""
    tools: list[Tool] = [Meliora(meliora)]
    if before is not None:
        tools.append(Meliora(harness.find_meliora(before), "before"))
    if names and importlib.util.find_spec("stormpy") is None:
        harness.stop("the Python package stormpy is missing: `pip install stormpy`, or leave Storm out with --storm none")
    if names:
        imported = measure_start_up([sys.executable, "-c", "import stormpy"])
        tools += [Storm(name, threads, imported) for name in names]
    if prism is not None:
        command = prism / "bin" / "prism"
        if not command.exists():
            harness.stop(f"no PRISM in {prism}: expected {command}")
        tools.append(Prism(prism, measure_start_up([str(command), "-version"])))
    return tools


def disagreement(ours: Measurement, theirs: Measurement) -> str:
    """Returns the counts that differ, or the empty string. Peers count in floating point: exact up to 2^53 only."""
    pairs = [(name, ours.counts[name], theirs.counts[name]) for name in COUNTS if name in ours.counts and name in theirs.counts]
    wrong = [(name, a, b) for name, a, b in pairs if a != b and (min(a, b) < 2**53 or abs(a - b) > a * 1e-9)]
    return ", ".join(f"{name} {a} against {b}" for name, a, b in wrong)
