"""The tools: how each is run, and how its answer is read."""

from __future__ import annotations

import hashlib
import importlib.util
import json
import re
import shlex
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Sequence

import harness
from bench.instances import Instance

# The regions in the order in which peers are asked: the first of Pmax and of Pmin pay for the second.
REGIONS = ("pmax_one", "pmin_one", "pmax_positive", "pmin_positive")
# What a report says about the initial states, which all scopes agree on, and about the levels.
SAID = ("initial", "holds", "objectives", "classes", "sasi", "spi")
# The choices that a user can make: an engine (diagrams have the order of the structure then), an order, a scope.
ORDERS = ("declared", "reversed", "large-first")
BY_HAND = ("explicit", "symbolic", *ORDERS, *(f"{order}+all" for order in ORDERS))
# Of a Markov chain only Pmax is asked. With PRISM, P<1 says that no strategy reaches 1: its complement is Pmax=1.
PRISM_BOUNDS = dict(zip(REGIONS, ("<1", ">=1", "<=0", ">0")))


@dataclass
class Run:
    """One run: what the process took, seconds by phase, the answer, and what went wrong."""

    status: str = "done"
    wall: float = 0.0
    cpu: float = 0.0
    memory: int = 0
    phases: dict[str, float] = field(default_factory=dict)
    answer: dict[str, Any] = field(default_factory=dict)

    @classmethod
    def of(cls, finished: harness.Finished) -> Run:
        # A negative status is that of a signal, which ends a process at its limit.
        stopped = finished.timed_out or finished.status == harness.OUT_OF_RESOURCES or finished.status < 0
        # A property that does not hold has status 1, and the shell adds 128 to the number of a signal.
        done, stopped = finished.status in (0, 1), stopped or finished.status > 128
        status = "done" if done else "stopped" if stopped else harness.complaint(finished)
        return cls(status, finished.seconds, finished.cpu_seconds, finished.peak_bytes)

    def add_sums(self, pmax: Sequence[str], pmin: Sequence[str]) -> None:
        """Adds the times of the regions of Pmax, of Pmin, and of all, as sums of the phases that they take."""
        for name, parts in {"Pmax": pmax, "Pmin": pmin, "regions": [*pmax, *pmin]}.items():
            if parts and all(part in self.phases for part in parts):
                self.phases[name] = sum(self.phases[part] for part in parts)


def limited(command: Sequence[str], limit: float) -> harness.Finished:
    """Runs a command with a limit on its processor time."""
    words = ["sh", "-c", 'ulimit -t "$0"; exec "$@"', str(max(1, round(limit))), *command]
    return harness.run(words, 20.0 * limit + 10.0)


@dataclass
class Tool:
    """A program that answers questions. Its start, in seconds of wall and processor time, is taken off in tables."""

    name: str
    start: tuple[float, float] = (0.0, 0.0)

    def run(self, instance: Instance, limit: float) -> Run:
        raise NotImplementedError

    def reads(self, instance: Instance) -> bool:
        """Whether the tool can answer such a question."""
        return instance.kind in ("regions", "property") and not instance.coalition

    def measure_start(self, command: Sequence[str]) -> None:
        runs = [harness.run(command, 60.0) for _ in range(5)]
        self.start = min(run.seconds for run in runs), min(run.cpu_seconds for run in runs)


@dataclass
class Meliora(Tool):
    binary: str = ""
    options: tuple[str, ...] = ()
    memory: str = "4GiB"
    choice: str = ""  # one of BY_HAND
    folder: Path = Path()

    def reads(self, instance: Instance) -> bool:
        # All valuations are another question for `check`. Files of orders cannot have the names of facts.
        if instance.kind == "plan":
            return self.choice not in BY_HAND[3:]
        return "+" not in self.choice or instance.kind in ("regions", "property")

    def run(self, instance: Instance, limit: float) -> Run:
        files = [str(file) for file in instance.files]
        policy = self.folder / "policy.txt"
        policy.unlink(missing_ok=True)
        words = {
            "check": ["check", *files],
            "regions": ["reach", *files, "--target", instance.text, *([] if self.choice else ["--scope", "reachable"])],
            "property": ["reach", *files, "--property", instance.text],
            "states": ["info", *files],
            "plan": ["reach", *files, "--policy", str(policy)],
            "values": ["values", *files, "--all", "--limit", "4000000000", "--levels", "2"],
        }[instance.kind]
        words += ["--const", instance.constants] if instance.constants else []
        words += ["--coalition", instance.coalition] if instance.coalition else []
        words += ["--memory", self.memory, *self.options, *self.by_hand(instance)]
        if instance.kind in ("regions", "property", "plan", "check") and "--threads" not in words:
            words += ["--threads", "1"]
        finished = limited([self.binary, *words, "--json", "--quiet"], limit)
        run, report = Run.of(finished), harness.json_object(finished.stdout) or {}
        if run.status == "done":
            self.read(report, instance, run)
        if instance.kind == "plan" and policy.exists():
            checked = limited([self.binary, "verify", str(policy), *files], limit)
            run.answer["policy"] = {0: "verified", 1: "refused"}.get(checked.status, "limit or error")
        return run

    def read(self, report: dict[str, Any], instance: Instance, run: Run) -> None:
        time, counts = report.get("time") or {}, report.get("counts") or {}
        run.memory = int((report.get("memory") or {}).get("peak_rss_bytes") or run.memory)
        run.phases = {name: seconds for name, seconds in time.items() if isinstance(seconds, (int, float))}
        if "build" in time:
            run.phases["build"] += time.get("parse") or 0.0
        chain = (report.get("model") or {}).get("type") == "dtmc"
        run.add_sums(("pmax_one", "pmax_positive"), () if chain else ("pmin_one", "pmin_positive"))
        said = {key: report.get(key) for key in SAID}
        if instance.kind == "plan":
            run.answer["plan"] = report["plan"]["strong_cyclic"]
        elif instance.kind == "property" and (value := (report["properties"] or [{}])[0].get("value")):
            run.answer["value"] = [value["lower"], value["upper"]]
        elif instance.kind != "states":
            run.answer["said"] = hashlib.sha256(json.dumps(said, sort_keys=True).encode()).hexdigest()[:16]
        # Another scope has other states.
        if not self.choice and counts.get("states") is not None:
            run.answer["states"] = int(counts["states"])
            run.answer |= {name: int(report[name]) for name in REGIONS if report.get(name) is not None}

    def by_hand(self, instance: Instance) -> list[str]:
        if not self.choice:
            return []
        if self.choice not in BY_HAND[2:]:
            return ["--engine", self.choice]
        order, _, scope = self.choice.partition("+")
        named = order if order == "declared" else str(self.order(instance, order))
        return ["--engine", "symbolic", "--order", named, *(["--scope", scope] if scope else [])]

    def order(self, instance: Instance, order: str) -> Path:
        """A file with the variables in an order. They are known before the states, which may be too many."""
        constants = ["--const", instance.constants] if instance.constants else []
        said = harness.run([self.binary, "info", str(instance.files[0]), *constants, "--json", "--timeout", "1"], 60.0)
        variables = (harness.json_object(said.stdout) or {}).get("model", {}).get("variables", [])
        variables = variables[::-1] if order == "reversed" else sorted(variables, key=lambda v: v["low"] - v["high"])
        path = self.folder / f"{order}.order"
        path.write_text("".join(f"{v['name']}\n" for v in variables), encoding="utf-8")
        return path


@dataclass
class Storm(Tool):
    """Storm by stormpy, on one thread. Its start is that of Python with the import."""

    def run(self, instance: Instance, limit: float) -> Run:
        question = [instance.kind, str(instance.files[0]), instance.constants, instance.text]
        worker = [sys.executable, str(Path(__file__).with_name("storm_worker.py")), self.name.partition("-")[2], *question]
        finished = limited(worker, limit)
        run = Run.of(finished)
        run.status = "stopped" if finished.timed_out else harness.complaint(finished) if finished.status == 1 else run.status
        for line in finished.stdout.splitlines():
            if line.startswith("{"):
                told = json.loads(line)
                run.phases[told["phase"]] = told["seconds"]
                # Above 2^64 Storm reports 0 states: then none of its counts mean anything.
                if told["phase"] in ("build", "value") or "states" in run.answer:
                    run.answer |= {name: value for name, value in told["found"].items() if name != "states" or value > 0}
        run.add_sums(("pmax_one",), ("pmin_one",) if "pmin_one" in run.phases else ())
        return run


@dataclass
class Prism(Tool):
    """PRISM's symbolic engine. Its start is that of `prism -version`, mostly the Java machine."""

    folder: Path = Path()

    def reads(self, instance: Instance) -> bool:
        return instance.kind == "regions" and not instance.coalition and instance.files[0].suffix != ".jani"

    def prism(self, instance: Instance, limit: float, *options: str) -> harness.Finished:
        constants = ["-const", instance.constants] if instance.constants else []
        return limited([str(self.folder / "bin" / "prism"), str(instance.files[0]), *options, *constants], limit)

    def run(self, instance: Instance, limit: float) -> Run:
        questions = [f"filter(count, P{bound} [ F ({instance.text}) ])" for bound in PRISM_BOUNDS.values()]
        finished = self.prism(instance, limit, "-mtbdd", "-pf", ";".join(questions))
        run, log = Run.of(finished), finished.stdout
        run.status = harness.complaint(finished) if finished.status == 1 else run.status
        spent = re.findall(r"^Time for model (?:construction|checking): ([\d.]+) seconds", log, re.MULTILINE)
        run.phases = dict(zip(("build", *REGIONS), map(float, spent)))
        run.add_sums(("pmax_one",), () if re.search(r"^Type:\s+DTMC", log, re.MULTILINE) else ("pmin_one",))
        if states := re.search(r"^States:\s+(\d+) ", log, re.MULTILINE):
            run.answer["states"] = int(states[1])
            for (region, bound), number in zip(PRISM_BOUNDS.items(), re.findall(r"^Result: (-?\d+)", log, re.MULTILINE)):
                # PRISM counts in 32 bits and says -1 above.
                if int(number) >= 0:
                    run.answer[region] = int(states[1]) - int(number) if bound.startswith("<") else int(number)
        return run


@dataclass
class PrismGames(Prism):
    """PRISM-games. The first step of value iteration ends the run: the regions of Pmax are known then."""

    def reads(self, instance: Instance) -> bool:
        return instance.kind == "regions" and bool(instance.coalition)

    def run(self, instance: Instance, limit: float) -> Run:
        question, engine = f"<<{instance.coalition}>> Pmax=? [ F ({instance.text}) ]", self.name.rpartition("-")[2]
        finished = self.prism(instance, limit, "-pf", question, "-maxiters", "1", f"-{engine}", "-javamaxmem", "8g")
        run, log = Run.of(finished), finished.stdout
        built = re.search(r"^Time for model construction: ([\d.]+) seconds", log, re.MULTILINE)
        states = re.search(r"^States:\s+(\d+) ", log, re.MULTILINE)
        sizes = re.search(r"^target=\d+, yes=(\d+), no=(\d+), maybe=\d+", log, re.MULTILINE)
        if not (built and states and sizes):
            error = re.search(r"^Error: (.*)", log, re.MULTILINE)
            run.status = run.status if run.status == "stopped" else error[1] if error else harness.complaint(finished)
            return run
        took = r"^Prob([01])(?: \(\w+\))? took \d+ iterations and ([\d.]+) seconds"
        spent = dict(re.findall(took, log, re.MULTILINE))
        # Without these lines, the target has no states, or all of them.
        run.phases = {"build": float(built[1]), "pmax_one": float(spent.get("1", 0)), "pmax_positive": float(spent.get("0", 0))}
        run.add_sums(("pmax_one", "pmax_positive"), ())
        yes, no = int(sizes[1]), int(sizes[2])
        run.status, run.answer = "done", {"states": int(states[1]), "pmax_one": yes, "pmax_positive": int(states[1]) - no}
        return run


@dataclass
class Peer(Tool):
    """A program that gets a file .bnet as its last argument and prints the number of states, as `biodivine_reach` does."""

    command: tuple[str, ...] = ()

    def reads(self, instance: Instance) -> bool:
        return instance.kind == "states" and instance.source is not None

    def run(self, instance: Instance, limit: float) -> Run:
        finished = limited([*self.command, str(instance.source)], limit)
        run = Run.of(finished)
        if finished.stdout.strip().isdigit():
            run.answer["states"] = int(finished.stdout)
        return run


def tool(text: str, meliora: str, memory: str, folder: Path) -> list[Tool]:
    """The tools of one `--tool`."""
    name, _, where = text.partition("=")
    words = shlex.split(name)
    if words[0] == "meliora":
        return [Meliora(name, binary=where or meliora, options=tuple(words[1:]), memory=memory, folder=folder)]
    if name == "before":
        return [Meliora(name, binary=harness.find_meliora(where), memory=memory, folder=folder)]
    if name == "by-hand":
        return [Meliora(choice, binary=meliora, memory=memory, choice=choice, folder=folder) for choice in BY_HAND]
    if name == "peer":
        return [Peer(name, command=tuple(shlex.split(where)))]
    if name in ("storm-dd", "storm-sparse"):
        if importlib.util.find_spec("stormpy") is None:
            harness.stop("the Python package stormpy is missing: `pip install stormpy`")
        made: Tool = Storm(name)
        made.measure_start([sys.executable, "-c", "import stormpy"])
        return [made]
    if name not in ("prism", "prism-games-mtbdd", "prism-games-explicit"):
        harness.stop(f"no tool is called `{name}`")
    command = Path(where) / "bin" / "prism"
    if not command.exists():
        harness.stop(f"no PRISM in `{where}`: expected {command}")
    made = (Prism if name == "prism" else PrismGames)(name, folder=Path(where))
    made.measure_start([str(command), "-version"])
    return [made]
