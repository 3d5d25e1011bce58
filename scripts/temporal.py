#!/usr/bin/env python3
"""Compares the four regions of temporal formulas with known counts, in both engines.

Usage: temporal.py FILE [--meliora BIN] [--only ID] [--timeout SECONDS] [--engines symbolic,explicit]

FILE is a JSON list of {id, model, constants, formulas: [{formula, pmax_one, pmax_positive, pmin_one, pmin_positive,
prism_mtbdd_s}]}; `model` is relative to the file's folder. Prints every difference, the totals, and where the file
has PRISM's seconds, the geometric mean of the ratios to ours (build included) by engine.
Exit status: 0 all equal, 1 a difference, 2 usage.
"""

from __future__ import annotations

import argparse
import math
import sys
from pathlib import Path
from typing import Any

import harness

REGIONS = {"pmax_one": "Pmax>=1", "pmax_positive": "Pmax>0", "pmin_one": "P>=1", "pmin_positive": "P>0"}


def ask(given: argparse.Namespace, instance: dict[str, Any], formula: str, engine: str) -> dict[str, Any] | str:
    """Returns the report of the four questions, with a count for each region; or what went wrong."""
    asked = [word for bound in REGIONS.values() for word in ("--property", f"{bound} [ {formula} ]")]
    command = [given.meliora, "reach", str(given.file.parent / instance["model"]), *asked, "--json", "--engine", engine]
    command += ["--const", instance["constants"]] if instance.get("constants") else []
    finished = harness.run(command, given.timeout)
    report = harness.json_object(finished.stdout)
    if finished.timed_out or finished.status not in (0, 1) or report is None:
        return harness.complaint(finished)
    known = {name: next(p[name] for p in report["properties"] if p[name] is not None) for name in REGIONS}
    return report | known


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", type=Path)
    parser.add_argument("--meliora")
    parser.add_argument("--only", default="", help="instances whose id has this in it")
    parser.add_argument("--timeout", type=float, default=300)
    parser.add_argument("--engines", type=lambda text: text.split(","), default=["symbolic", "explicit"])
    given = parser.parse_args()
    given.meliora = harness.find_meliora(given.meliora)
    asked = [(i, entry) for i in harness.read_json(given.file) if given.only in i["id"] for entry in i["formulas"]]
    wrong = equal = 0
    ratios: dict[str, list[float]] = {engine: [] for engine in given.engines}
    slowest = []
    for instance, entry in asked:
        for engine in given.engines:
            found = ask(given, instance, entry["formula"], engine)
            here = f"{instance['id']} [{engine}] {entry['formula']}"
            if isinstance(found, str):
                wrong += len(REGIONS)
                print(f"WRONG {here}: {found}")
                continue
            differing = [name for name in REGIONS if int(found[name]) != entry[name]]
            for name in differing:
                print(f"WRONG {here}: {name} is {found[name]}, expected {entry[name]}")
            wrong, equal = wrong + len(differing), equal + len(REGIONS) - len(differing)
            seconds, prism = found["time"]["total"], entry.get("prism_mtbdd_s")
            slowest.append((seconds, here, prism))
            ratios[engine] += [prism / max(seconds, 1e-3)] if prism else []
    print(f"{equal} counts equal, {wrong} wrong")
    for engine, own in ratios.items():
        if own:
            mean = math.exp(sum(map(math.log, own)) / len(own))
            print(f"{engine}: {mean:.2f} times PRISM's speed in the geometric mean of {len(own)} formulas")
    for seconds, here, prism in sorted(slowest, reverse=True)[:8]:
        print(f"{seconds:8.2f} s (PRISM {prism}) {here}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
