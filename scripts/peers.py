"""The tools that `compare_peers.py` compares: how each is run and how its answers are read."""

from __future__ import annotations

import importlib.util
import json
import re
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

import harness

PHASES = ("build", "pmax_one", "pmax_positive")
COUNTS = ("states", "pmax_one", "pmax_positive")
WORKER = Path(__file__).with_name("storm_worker.py")


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
    """One run of one tool: seconds by phase, counts, and what went wrong."""

    times: dict[str, float] = field(default_factory=dict)
    counts: dict[str, int] = field(default_factory=dict)
    wall: float = 0.0
    cpu: float = 0.0
    peak_bytes: int = 0
    status: str = "done"

    @property
    def done(self) -> bool:
        return self.status == "done"


class Tool(Protocol):
    """A program that answers the questions."""

    @property
    def name(self) -> str:
        """The name of the tool in tables."""
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
    """`meliora reach`. Its build is parsing, building and counting; both regions are its two phases together."""

    binary: str
    name: str = "meliora"
    engine: str = ""

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
        return result

    @staticmethod
    def _read(report: dict[str, Any], result: Measurement) -> None:
        time = report.get("time") or {}
        seconds = {phase: time[phase] for phase in PHASES if time.get(phase) is not None}
        if "build" in seconds:
            seconds["build"] += time["parse"]
        if "pmax_one" in seconds and "pmax_positive" in seconds:
            seconds["existential"] = seconds["pmax_one"] + seconds["pmax_positive"]
        result.times = seconds
        found = {**report, "states": (report.get("counts") or {}).get("states")}
        result.counts = {count: int(found[count]) for count in COUNTS if found.get(count) is not None}
        if "existential" in seconds:
            result.status = "done"


@dataclass
class Storm:
    """Storm by stormpy. Either question computes both regions: the first one asked stands for both."""

    engine: str
    threads: int

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
        return result

    @staticmethod
    def _read(told: dict[str, Any], result: Measurement) -> None:
        result.times[told["phase"]] = told["seconds"]
        if told["phase"] == "pmax_one":
            result.times["existential"] = told["seconds"]
        # Above 2^64 Storm reports 0 states: then none of its counts mean anything.
        if told["phase"] == "build" or "states" in result.counts:
            result.counts |= {name: count for name, count in told["counts"].items() if name != "states" or count > 0}


@dataclass
class Prism:
    """PRISM's mtbdd engine. Each question computes both regions: the first one asked stands for both."""

    folder: Path
    name: str = "prism"

    def measure(self, instance: Instance, timeout: float) -> Measurement:
        if instance.model.suffix == ".jani":
            return Measurement(status="does not read JANI")
        # For an MDP, P<1 says that no strategy reaches 1: its complement is Pmax=1; P<=0 likewise.
        questions = [f"filter(count, P{bound} [ F ({instance.target}) ])" for bound in ("<1", "<=0")]
        command = [str(self.folder / "bin" / "prism"), str(instance.model), "-mtbdd", "-pf", ";".join(questions)]
        if instance.constants:
            command += ["-const", instance.constants]
        finished = harness.run(command, timeout)
        result = _measurement(finished)
        self._read(finished.stdout, result)
        return result

    @staticmethod
    def _read(log: str, result: Measurement) -> None:
        spent = re.findall(r"^Time for model (construction|checking): ([\d.]+) seconds", log, re.MULTILINE)
        result.times = dict(zip(PHASES, (float(seconds) for _, seconds in spent)))
        if "pmax_one" in result.times:
            result.times["existential"] = result.times["pmax_one"]
        states = re.search(r"^States:\s+(\d+) ", log, re.MULTILINE)
        if states is None:
            return
        result.counts["states"] = int(states[1])
        for phase, below in zip(PHASES[1:], re.findall(r"^Result: (-?\d+)", log, re.MULTILINE)):
            # PRISM counts in 32 bits and says -1 above.
            if int(below) >= 0:
                result.counts[phase] = int(states[1]) - int(below)


def installed(meliora: str, names: list[str], threads: int, prism: Path | None) -> list[Tool]:
    """Meliora and the peers that were asked for, Meliora first."""
    tools: list[Tool] = [Meliora(meliora)]
    if names and importlib.util.find_spec("stormpy") is None:
        harness.stop("the Python package stormpy is missing: `pip install stormpy`, or leave Storm out with --storm none")
    tools += [Storm(name, threads) for name in names]
    if prism is not None:
        if not (prism / "bin" / "prism").exists():
            harness.stop(f"no PRISM in {prism}: expected {prism / 'bin' / 'prism'}")
        tools.append(Prism(prism))
    return tools


def disagreement(ours: Measurement, theirs: Measurement) -> str:
    """Returns the counts that differ, or the empty string. Peers count in floating point: exact up to 2^53 only."""
    pairs = [(name, ours.counts[name], theirs.counts[name]) for name in COUNTS if name in ours.counts and name in theirs.counts]
    wrong = [(name, a, b) for name, a, b in pairs if a != b and (min(a, b) < 2**53 or abs(a - b) > a * 1e-9)]
    return ", ".join(f"{name} {a} against {b}" for name, a, b in wrong)
