"""Tables in Markdown of the rows of a file of results."""

from __future__ import annotations

import argparse
import json
import math
import statistics
from pathlib import Path
from typing import Any, Callable, Iterable, Sequence

import harness

Row = dict[str, Any]
# The runs of each tool on one question.
Runs = dict[str, list[Row]]
PHASES = ("build", "Pmax", "Pmin", "regions", "wall", "cpu")


def read(path: Path) -> list[Row]:
    """The rows of a file; none if it does not exist."""
    return [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()] if path.exists() else []


def time_of(runs: Sequence[Row], phase: str, floor: float) -> float | None:
    """The median time of a phase over the runs that have it, without the start of the tool, and not below the floor."""

    def seconds(row: Row) -> float | None:
        if phase in ("wall", "cpu"):
            return row[phase] - row["start"][phase == "cpu"] if row["status"] == "done" else None
        return row["phases"].get(phase)

    found = [time for row in runs if (time := seconds(row)) is not None]
    return max(floor, statistics.median(found)) if found else None


def memory_of(runs: Sequence[Row]) -> float:
    return max(row["memory"] for row in runs) / 2**20


def mean(ratios: Iterable[float]) -> str:
    """The geometric mean."""
    logs = [math.log(ratio) for ratio in ratios]
    return f"{math.exp(statistics.fmean(logs)):.2f}" if logs else "–"


def lines(head: Sequence[str], rows: Iterable[Sequence[Any]]) -> list[str]:
    cells = [head, ["---"] * len(head), *rows]
    return ["| " + " | ".join(str(cell).replace("|", "\\|") for cell in row) + " |" for row in cells]


def of_questions(rows: list[Row]) -> dict[str, Runs]:
    found: dict[str, Runs] = {}
    for row in rows:
        found.setdefault(row["instance"], {}).setdefault(row["tool"], []).append(row)
    return found


def listing(rows: list[Row], _floor: float) -> list[str]:
    """A row for each question: states, and seconds and memory of each tool."""
    names = list(dict.fromkeys(row["tool"] for row in rows))

    def cell(runs: list[Row] | None) -> str:
        if not runs:
            return "–"
        seconds = time_of(runs, "cpu", 0.0)
        return runs[-1]["status"] if seconds is None else f"{seconds:.2f} s, {memory_of(runs):.0f} MiB"

    def states(runs: Runs) -> str:
        return next((f"{row['answer']['states']:,}" for own in runs.values() for row in own if "states" in row["answer"]), "")

    body = ([name, states(runs), *(cell(runs.get(tool)) for tool in names)] for name, runs in of_questions(rows).items())
    return lines(["question", "states", *names], body)


def ratios(rows: list[Row], floor: float) -> list[str]:
    """A row for each peer and phase, and the questions on which a peer is faster."""
    questions = of_questions(rows)
    body, losses = [], []
    for peer in dict.fromkeys(row["tool"] for row in rows if row["tool"] != "meliora"):
        both = {name: runs for name, runs in questions.items() if peer in runs and "meliora" in runs}
        for phase in PHASES:
            times = {name: [time_of(runs[tool], phase, floor) for tool in ("meliora", peer)] for name, runs in both.items()}
            found = {name: theirs / ours for name, (ours, theirs) in times.items() if ours and theirs}
            alone = [sum(pair[at] is not None and pair[1 - at] is None for pair in times.values()) for at in (0, 1)]
            if found:
                ends = [f"{end(found.values()):.2f}" for end in (min, max)]
                body.append([peer, phase, len(found), *alone, mean(found.values()), *ends])
            slower = sorted((ratio, name) for name, ratio in found.items() if ratio < 1)
            losses += [f"{peer} is faster in {phase}: " + "; ".join(f"{n} {r:.2f}" for r, n in slower)] if slower else []
    head = ["tool", "phase", "both finished", "only Meliora", "only the other", "geometric mean", "least", "most"]
    return [*lines(head, body), "", *losses]


def within(rows: list[Row], _floor: float) -> list[str]:
    """A row for each tool: questions closed in the limit and in less, and those that are refused."""
    body = []
    for tool in dict.fromkeys(row["tool"] for row in rows):
        own = [runs[tool] for runs in of_questions(rows).values() if tool in runs]
        times = [time for runs in own if (time := time_of(runs, "cpu", 0.0)) is not None]
        refused = sum(runs[-1]["status"] not in ("done", "stopped") for runs in own)
        body.append([tool, len(own), *(sum(time <= limit for time in times) for limit in (math.inf, 1.0, 0.1)), refused])
    return lines(["tool", "questions", "in the limit", "in 1 s", "in 0.1 s", "refused or failed"], body)


def plans(rows: list[Row], _floor: float) -> list[str]:
    """A row for each domain, and their sum."""
    domains: dict[str, list[Row]] = {}
    rows = [row for row in rows if row["tool"] == "meliora" and row["instance"].endswith(" plan")]
    for row in rows:
        domains.setdefault(row["instance"].partition(" ")[0], []).append(row)
    body = []
    for domain, own in [*sorted(domains.items()), ("all", rows)]:
        verdicts = [sum(row["answer"].get("plan") is verdict for row in own) for verdict in (True, False)]
        verified = sum(row["answer"].get("policy") == "verified" for row in own)
        limit = sum(row["status"] == "stopped" or row["status"] == "done" and row["answer"].get("plan") is None for row in own)
        errors = len(own) - sum(verdicts) - limit
        body.append([domain, len(own), verdicts[0], verified, verdicts[1], limit, errors])
    return lines(["domain", "problems", "plan", "policy verified", "no plan", "limit", "error"], body)


def regret(rows: list[Row], floor: float) -> list[str]:
    """A row for each collection and half: the processor time of `meliora` over that of the best choice by hand. Runs that
    were not needed are those of questions that `meliora` answers in less than the floor."""
    groups: dict[tuple[str, str], list[Runs]] = {}
    for runs in of_questions(rows).values():
        row = next(iter(runs.values()))[0]
        for collection in (row["collection"], "all"):
            groups.setdefault((collection, row["half"]), []).append(runs)
    body = []
    for (collection, half), all_runs in sorted(groups.items(), key=lambda group: (group[0][0] == "all", group[0])):
        times = [({t: s for t, own in runs.items() if (s := time_of(own, "cpu", floor)) is not None}, runs) for runs in all_runs]
        answered = [(found, runs) for found, runs in times if found]
        own = [(found["meliora"], min(found, key=lambda tool: found[tool]), found, runs) for found, runs in answered if "meliora" in found]
        factors = [auto / found[best] for auto, best, found, _ in own]
        memory = [memory_of(runs["meliora"]) / memory_of(runs[best]) for _, best, _, runs in own]
        slow = sum(len(runs) > 1 for runs in all_runs)
        ends = [f"{max(values, default=math.nan):.1f}" for values in (factors, memory)]
        body.append([f"{collection}, {half}", len(all_runs), slow, len(answered), len(own), mean(factors), *ends])
    head = ["collection, half", "instances", f"above {floor:g} s", "answered by some choice", "by `meliora`"]
    return lines([*head, "geometric mean", "worst", "memory"], body)


TABLES: dict[str, Callable[[list[Row], float], list[str]]] = {
    "list": listing,
    "ratios": ratios,
    "within": within,
    "plans": plans,
    "regret": regret,
}


def show(given: argparse.Namespace) -> int:
    """Prints a table with the commit, the date and the machine of its rows."""
    rows = [row for row in read(given.results) if given.collection in ("", row["collection"])]
    commit = given.commit or (rows[-1]["commit"] if rows else "")
    rows = [row for row in rows if row["commit"] == commit]
    if not rows:
        harness.stop(f"{given.results} has no such rows")
    limits = " to ".join(f"{limit:g}" for limit in sorted({row["limit"] for row in rows}))
    dates = " to ".join(sorted({row["date"] for row in rows}))
    print("\n".join(TABLES[given.kind](rows, given.floor)))
    print(f"\nCommit {commit}, {dates}, {rows[-1]['machine']}; at most {limits} s of processor time for each run.")
    return 0

