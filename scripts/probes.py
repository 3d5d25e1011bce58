"""The probes of a corpus: tiny models on corners of the language, and what the peers make of them.

`corpus.py` runs this part where its folder holds an answers.json.
"""

from __future__ import annotations

import argparse
import re
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import harness

QUANTITIES = {
    "states": "states",
    "choices": "choices",
    "transitions": "transitions",
    "deadlock": "deadlocks",
    "init": "initial",
}
Answer = dict[str, Any]


def reach(given: argparse.Namespace, model: Path, constants: str, target: str) -> harness.Finished:
    """One `meliora reach` with the options of the command line."""
    command = [given.meliora, "reach", str(model), "--target", target, "--json", "--quiet"]
    command += ["--scope", "reachable", "--engine", given.engine]
    command += ["--const", constants] if constants else []
    command += ["--memory", given.memory] if given.memory else []
    return harness.run(command, given.timeout)


@dataclass(frozen=True)
class Verdict:
    """Meliora's answer to a probe against the quantities on which most peers agree."""

    probe: str
    ours: Answer
    peers: dict[str, Answer]
    against: list[str]
    split: list[str]


def answer(given: argparse.Namespace, model: Path) -> Answer:
    """Returns the answer of Meliora to a probe, in the format of answers.json."""
    finished = reach(given, model, "", "true")
    report = harness.json_object(finished.stdout)
    if finished.status == 0 and report is not None:
        return {theirs: int(report["counts"][ours]) for theirs, ours in QUANTITIES.items()}
    return {"error": harness.complaint(finished)}


def majority(values: list[Any]) -> tuple[Any, bool]:
    """Returns the most frequent value, and whether it is more frequent than any other."""
    ranked = Counter(values).most_common(2)
    return ranked[0][0], len(ranked) == 1 or ranked[0][1] > ranked[1][1]


def judge(probe: str, ours: Answer, peers: dict[str, Answer]) -> Verdict:
    """Whether it is an error first; then, among the peers that count, one quantity after the other."""
    answered = {peer: said for peer, said in peers.items() if said}
    against: list[str] = []
    split: list[str] = []

    def compare(quantity: str, mine: Any, theirs: list[Any]) -> None:
        usual, clear = majority(theirs)
        if not clear:
            split.append(quantity)
        elif mine != usual:
            against.append(quantity)

    compare("error", "error" in ours, ["error" in said for said in answered.values()])
    if "error" not in ours and "error" not in against:
        for quantity in QUANTITIES:
            theirs = [said[quantity] for said in answered.values() if quantity in said]
            if theirs:
                compare(quantity, ours[quantity], theirs)
    return Verdict(probe, ours, peers, against, split)


def words(said: Answer) -> str:
    """An answer in one line."""
    if "error" in said:
        return "error: " + " ".join(str(said["error"]).split())[:110]
    return ", ".join(f"{quantity} {said[quantity]}" for quantity in QUANTITIES if quantity in said) or "no answer"


def show(verdict: Verdict) -> None:
    """Prints a line for a probe, and the answers of all tools if there is a difference."""
    word = "AGAINST THE MAJORITY" if verdict.against else "peers are split" if verdict.split else "as the peers"
    on = ", ".join(verdict.against or verdict.split)
    print(f"{verdict.probe:28} {word}" + (f" ({on})" if on else ""))
    if on:
        for name, said in {"meliora": verdict.ours, **verdict.peers}.items():
            print(f"    {name:14} {words(said)}")


def run_probes(given: argparse.Namespace) -> bool:
    """Runs all probes; returns whether Meliora always agrees with the majority."""
    peers: dict[str, dict[str, Answer]] = harness.read_json(given.folder / "answers.json")
    names = [name for name in peers if re.search(given.filter, name)]
    if not names:
        harness.stop("no probe matches --filter")
    with ThreadPoolExecutor(given.jobs) as pool:
        answers = list(pool.map(lambda name: answer(given, given.folder / f"{name}.prism"), names))
    verdicts = [judge(name, ours, peers[name]) for name, ours in zip(names, answers)]
    for verdict in verdicts:
        show(verdict)
    against = sum(bool(verdict.against) for verdict in verdicts)
    split = sum(bool(verdict.split) and not verdict.against for verdict in verdicts)
    print(f"{len(verdicts)} probes ({given.engine}): {against} against the majority, {split} where the peers are split")
    return against == 0
