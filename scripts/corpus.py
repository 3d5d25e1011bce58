#!/usr/bin/env python3
"""Runs Meliora over a corpus of models with known answers and prints where it differs.

usage: corpus.py FOLDER|FILE [--engine symbolic|explicit] [--filter REGEX] [--timeout SECONDS] [--jobs N]

FOLDER holds one of
  oracle.json   a list of {id, model, constants, type, states, choices, transitions, deadlocks, initial_states,
                targets: [{target, count_target, pmax_one, pmax_positive, pmin_one, pmin_positive}]}, models relative
                to FOLDER. Each target is one `meliora reach --scope reachable`; every count must be equal. A count
                that the oracle leaves out (null) is not compared.
                FILE is such a list under another name, say of JANI models.
  answers.json  {probe: {peer: {states, choices, transitions, deadlock, init} or {error}}} for FOLDER/PROBE.prism.
                Meliora must side with the majority of the peers that answered. Where they are split evenly nothing
                is required; what each says is printed, also where Meliora stands against the majority.
Exit status: 0 all equal, 1 a difference (also a run that failed or was stopped), 2 usage. Needs nothing beyond Python.
"""

from __future__ import annotations

import argparse
import re
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Iterator

import harness
import probes

MODEL_COUNTS = {
    "states": "states",
    "choices": "choices",
    "transitions": "transitions",
    "deadlocks": "deadlocks",
    "initial": "initial_states",
}
TARGET_COUNTS = {
    "target": "count_target",
    "pmax_one": "pmax_one",
    "pmax_positive": "pmax_positive",
    "pmin_one": "pmin_one",
    "pmin_positive": "pmin_positive",
}


@dataclass(frozen=True)
class Question:
    """One target of one instance, and the expected answers."""

    instance: str
    model: Path
    constants: str
    target: str
    expected: dict[str, int]


@dataclass(frozen=True)
class Difference:
    """A line of the table."""

    instance: str
    target: str
    quantity: str
    expected: str
    found: str


def questions(oracle: Path) -> Iterator[Question]:
    """The questions of an oracle.json; the counts of a model go with its first target."""
    for entry in harness.read_json(oracle):
        sizes = {ours: entry.get(theirs) for ours, theirs in MODEL_COUNTS.items()}
        for answer in entry["targets"] or [{"target": "true"}]:
            regions = {ours: answer.get(theirs) for ours, theirs in TARGET_COUNTS.items()}
            expected = {name: int(count) for name, count in {**sizes, **regions}.items() if count is not None}
            yield Question(entry["id"], oracle.parent / entry["model"], entry["constants"], answer["target"], expected)
            sizes = {}


def ask(question: Question, given: argparse.Namespace) -> list[Difference]:
    """Runs one question and returns the differences."""
    finished = probes.reach(given, question.model, question.constants, question.target)
    report = harness.json_object(finished.stdout)
    if finished.status != 0 or report is None:
        trouble = Difference(question.instance, question.target, "run", "an answer", harness.complaint(finished))
        return [trouble]
    found = counts(report)
    return [
        Difference(question.instance, question.target, name, str(count), str(found.get(name, "missing")))
        for name, count in question.expected.items()
        if found.get(name) != count
    ]


def counts(report: dict[str, Any]) -> dict[str, int]:
    """All counts of a report of `reach`, as integers."""
    flat = {**report["counts"], **{name: report[name] for name in TARGET_COUNTS}}
    return {name: int(value) for name, value in flat.items() if value is not None}


def table(differences: list[Difference]) -> None:
    """Prints the differences in columns."""
    rows = [("instance", "target", "quantity", "expected", "found")]
    rows += [(d.instance, d.target, d.quantity, d.expected, d.found) for d in differences]
    widths = [min(50, max(len(row[column]) for row in rows)) for column in range(4)]
    for row in rows:
        print("  ".join([*(text.ljust(width) for text, width in zip(row, widths)), row[4]]))


def matches(given: argparse.Namespace, question: Question) -> bool:
    """Returns whether the question matches --filter."""
    return bool(re.search(given.filter, question.instance) or re.search(given.filter, str(question.model)))


def run_oracle(given: argparse.Namespace, oracle: Path) -> bool:
    """Asks all questions and prints the differences; returns whether there are none."""
    asked = [question for question in questions(oracle) if matches(given, question)]
    if not asked:
        harness.stop("no instance matches --filter")
    with ThreadPoolExecutor(given.jobs) as pool:
        answers = list(pool.map(lambda question: ask(question, given), asked))
    differences = [difference for answer in answers for difference in answer]
    if differences:
        table(differences)
    instances = {question.instance for question in asked}
    wrong = {difference.instance for difference in differences}
    print(
        f"{len(instances)} instances, {len(asked)} targets, {sum(len(q.expected) for q in asked)} counts "
        f"({given.engine}): differences: {len(differences)}, in instances: {len(wrong)}"
    )
    return not differences


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, metavar="FOLDER|FILE")
    parser.add_argument("--engine", choices=["symbolic", "explicit"], default="symbolic")
    parser.add_argument("--filter", type=re.compile, default="", metavar="REGEX", help="only ids or model paths that match")
    parser.add_argument("--timeout", type=float, default=60.0, metavar="SECONDS", help="for each run")
    parser.add_argument("--jobs", type=int, default=1, metavar="N", help="number of runs at a time")
    parser.add_argument("--memory", metavar="SIZE", help="passed on to Meliora, for each run")
    parser.add_argument("--meliora", metavar="PATH", help="the binary")
    given = parser.parse_args()
    given.meliora = harness.find_meliora(given.meliora)
    return given


def main() -> int:
    given = arguments()
    oracle = given.folder if given.folder.is_file() else given.folder / "oracle.json"
    if oracle.exists():
        return 0 if run_oracle(given, oracle) else 1
    if (given.folder / "answers.json").exists():
        return 0 if probes.run_probes(given) else 1
    harness.stop(f"{given.folder} holds neither an oracle.json nor an answers.json")


if __name__ == "__main__":
    sys.exit(main())
