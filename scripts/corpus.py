#!/usr/bin/env python3
"""Runs Meliora over a corpus of models with known answers and prints where it differs.

usage: corpus.py FOLDER|FILE [--engine symbolic|explicit] [--filter REGEX] [--timeout SECONDS] [--jobs N]

FILE, or FOLDER/oracle.json, is a list of {id, model, constants, type, states, choices, transitions, deadlocks,
initial_states, targets: [{target, count_target, pmax_one, pmax_positive, pmin_one, pmin_positive}], formulas:
[{formula, pmax_one, …, prism_mtbdd_s}]}; models are relative to its folder. Each target is one `meliora reach`, and
each temporal formula one with four properties; every count must be equal. A count that is left out (null) is not
compared. Where the file has PRISM's seconds, the geometric mean of the ratios to ours is printed, build included.

FOLDER/answers.json has the answers of other tools to tiny models on corners of the language:
{probe: {peer: {states, choices, transitions, deadlock, init} or {error}}} for FOLDER/PROBE.prism. Meliora must side
with the majority of the peers that answered. Where they are split evenly nothing is required; what each says is
printed, also where Meliora stands against the majority.
Exit status: 0 all equal, 1 a difference (also a run that failed or was stopped), 2 usage. Needs nothing beyond Python.
"""

from __future__ import annotations

import argparse
import math
import re
import sys
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, Iterator

import harness

MODEL_COUNTS = {
    "states": "states",
    "choices": "choices",
    "transitions": "transitions",
    "deadlocks": "deadlocks",
    "initial": "initial_states",
}
PROBE_COUNTS = {**MODEL_COUNTS, "deadlocks": "deadlock", "initial": "init"}
REGIONS = {"pmax_one": "Pmax>=1", "pmax_positive": "Pmax>0", "pmin_one": "P>=1", "pmin_positive": "P>0"}
Answer = dict[str, Any]


def reach(given: argparse.Namespace, model: Path, constants: str, asked: list[str]) -> Answer:
    """The counts of one `meliora reach` with the options of the command line, with its seconds; or its error."""
    command = [given.meliora, "reach", str(model), *asked, "--json", "--quiet"]
    command += ["--scope", "reachable", "--engine", given.engine]
    command += ["--const", constants] if constants else []
    command += ["--memory", given.memory] if given.memory else []
    finished = harness.run(command, given.timeout)
    report = harness.json_object(finished.stdout)
    if finished.timed_out or finished.status not in (0, 1) or report is None:
        return {"error": harness.complaint(finished)}
    # Of several properties, each has the count of its region.
    answers = [report, *report.get("properties", [])]
    regions = {name: next((own[name] for own in answers if own.get(name) is not None), None) for name in REGIONS}
    counts = {**report["counts"], **regions, "target": report.get("target")}
    return {"seconds": report["time"]["total"], **{name: int(n) for name, n in counts.items() if n is not None}}


def questions(oracle: Path) -> Iterator[tuple[str, Path, str, str, list[str], Answer]]:
    """The questions of an oracle: the instance, the model, the constants, the question, its arguments, and the expected
    answers. The counts of a model go with its first target."""
    for entry in harness.read_json(oracle):
        sizes = {ours: entry.get(theirs) for ours, theirs in MODEL_COUNTS.items()}
        asked = [(own["target"], ["--target", own["target"]], own) for own in entry.get("targets", [])]
        for own in entry.get("formulas", []):
            properties = [f"{bound} [ {own['formula']} ]" for bound in REGIONS.values()]
            asked.append((own["formula"], [text for p in properties for text in ("--property", p)], own))
        for text, arguments, own in asked or [("true", ["--target", "true"], {})]:
            regions = {name: own.get(name) for name in (*REGIONS, "prism_mtbdd_s")}
            expected = {**sizes, **regions, "target": own.get("count_target")}
            known = {name: count for name, count in expected.items() if count is not None}
            yield entry["id"], oracle.parent / entry["model"], entry.get("constants", ""), text, arguments, known
            sizes = {}


def run_oracle(given: argparse.Namespace, oracle: Path) -> bool:
    """Asks all questions and prints the differences; returns whether there are none."""
    asked = [q for q in questions(oracle) if re.search(given.filter, q[0]) or re.search(given.filter, str(q[1]))]
    if not asked:
        harness.stop("no instance matches --filter")
    with ThreadPoolExecutor(given.jobs) as pool:
        answers = list(pool.map(lambda q: reach(given, q[1], q[2], q[4]), asked))
    wrong, compared, ratios = [], 0, []
    for (instance, _, _, text, _, expected), found in zip(asked, answers):
        prism = expected.pop("prism_mtbdd_s", None)
        if "error" in found:
            wrong.append((instance, f"{text}: {found['error']}"))
            continue
        compared += len(expected)
        ratios += [prism / max(found["seconds"], 1e-3)] if prism else []
        differing = (name for name, count in expected.items() if found.get(name) != int(count))
        wrong += [(instance, f"{text}: {name} is {found.get(name)}, not {expected[name]}") for name in differing]
    for instance, reason in wrong:
        print(f"WRONG {instance}: {reason}")
    if ratios:
        mean = math.exp(sum(map(math.log, ratios)) / len(ratios))
        print(f"{mean:.2f} times PRISM's speed in the geometric mean of {len(ratios)} formulas")
    print(
        f"{len({q[0] for q in asked})} instances, {len(asked)} questions, {compared} counts ({given.engine}): "
        f"differences: {len(wrong)}, in instances: {len({instance for instance, _ in wrong})}"
    )
    return not wrong


def judge(ours: Answer, peers: list[Answer]) -> tuple[list[str], list[str]]:
    """In what an answer differs from most peers, and on what these are split: whether it is an error first; then, among
    the peers that count, one quantity after the other."""
    against: list[str] = []
    split: list[str] = []

    def compare(quantity: str, mine: Any, theirs: list[Any]) -> None:
        (usual, most), *others = Counter(theirs).most_common(2)
        if others and others[0][1] == most:
            split.append(quantity)
        elif mine != usual:
            against.append(quantity)

    compare("error", "error" in ours, ["error" in said for said in peers])
    if "error" not in ours and "error" not in against:
        for quantity in PROBE_COUNTS.values():
            theirs = [said[quantity] for said in peers if quantity in said]
            if theirs:
                compare(quantity, ours[quantity], theirs)
    return against, split


def words(said: Answer) -> str:
    """An answer in one line."""
    if "error" in said:
        return "error: " + " ".join(str(said["error"]).split())[:110]
    return ", ".join(f"{quantity} {said[quantity]}" for quantity in PROBE_COUNTS.values() if quantity in said) or "no answer"


def probe(given: argparse.Namespace, name: str) -> Answer:
    """The answer of Meliora to a probe, in the names of its file."""
    found = reach(given, given.source / f"{name}.prism", "", ["--target", "true"])
    return found if "error" in found else {theirs: found[ours] for ours, theirs in PROBE_COUNTS.items()}


def run_probes(given: argparse.Namespace, file: Path) -> bool:
    """Runs all probes; returns whether Meliora always agrees with the majority."""
    peers: dict[str, dict[str, Answer]] = harness.read_json(file)
    names = [name for name in peers if re.search(given.filter, name)]
    if not names:
        harness.stop("no probe matches --filter")
    with ThreadPoolExecutor(given.jobs) as pool:
        answers = list(pool.map(lambda name: probe(given, name), names))
    count = Counter()
    for name, ours in zip(names, answers):
        against, split = judge(ours, [said for said in peers[name].values() if said])
        word = "AGAINST THE MAJORITY" if against else "peers are split" if split else "as the peers"
        count[word] += 1
        print(f"{name:28} {word}" + (f" ({', '.join(against or split)})" if against or split else ""))
        for peer, said in {"meliora": ours, **peers[name]}.items() if against or split else ():
            print(f"    {peer:14} {words(said)}")
    against, split = count["AGAINST THE MAJORITY"], count["peers are split"]
    print(f"{len(names)} probes ({given.engine}): {against} against the majority, {split} where the peers are split")
    return against == 0


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("source", type=Path, metavar="FOLDER|FILE")
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
    oracle = given.source if given.source.is_file() else given.source / "oracle.json"
    if oracle.exists():
        return 0 if run_oracle(given, oracle) else 1
    probes = given.source / "answers.json"
    if probes.exists():
        return 0 if run_probes(given, probes) else 1
    harness.stop(f"{given.source} holds neither an oracle.json nor an answers.json")


if __name__ == "__main__":
    sys.exit(main())
