#!/usr/bin/env python3
"""Compares the four regions of temporal formulas with known counts, in both engines.

Usage: temporal.py FILE [--meliora BIN] [--only ID] [--timeout SECONDS] [--engines symbolic,explicit]

FILE is a JSON list of {id, model, constants, formulas: [{formula, pmax_one, pmax_positive, pmin_one, pmin_positive,
prism_mtbdd_s}]}; `model` is relative to the file's folder. Prints every difference, the totals, and where the file
has PRISM's seconds, the geometric mean of the ratios to ours (build included) by engine.
"""

import argparse
import json
import math
import os
import subprocess
import sys

REGIONS = ["pmax_one", "pmax_positive", "pmin_one", "pmin_positive"]


def ask(arguments, model, constants, formula, engine):
    asked = [f"{strategies} [ {formula} ]" for strategies in ("Pmax>=1", "Pmax>0", "P>=1", "P>0")]
    properties = [word for question in asked for word in ("--property", question)]
    command = [arguments.meliora, "reach", model, *properties, "--json", "--engine", engine]
    if constants:
        command += ["--const", constants]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=arguments.timeout)
    except subprocess.TimeoutExpired:
        return None, f"more than {arguments.timeout} s"
    if done.returncode not in (0, 1):
        return None, f"status {done.returncode}: {done.stderr.strip()[:300]}"
    report = json.loads(done.stdout)
    for name in REGIONS:
        report[name] = next(entry[name] for entry in report["properties"] if entry[name] is not None)
    return report, None


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file")
    parser.add_argument("--meliora", default="target/release/meliora")
    parser.add_argument("--only", help="instances whose id has this in it")
    parser.add_argument("--timeout", type=float, default=300)
    parser.add_argument("--engines", default="symbolic,explicit")
    arguments = parser.parse_args()
    folder = os.path.dirname(os.path.abspath(arguments.file))
    with open(arguments.file, encoding="utf-8") as file:
        instances = json.load(file)
    wrong = equal = 0
    ratios, slowest = {}, []
    for instance in instances:
        if arguments.only and arguments.only not in instance["id"]:
            continue
        model = os.path.join(folder, instance["model"])
        for entry in instance["formulas"]:
            for engine in arguments.engines.split(","):
                found, error = ask(arguments, model, instance.get("constants") or "", entry["formula"], engine)
                here = f"{instance['id']} [{engine}] {entry['formula']}"
                if error:
                    wrong += len(REGIONS)
                    print(f"WRONG {here}: {error}")
                    continue
                for region in REGIONS:
                    if int(found[region]) == entry[region]:
                        equal += 1
                    else:
                        wrong += 1
                        print(f"WRONG {here}: {region} is {found[region]}, expected {entry[region]}")
                seconds = found["time"]["total"]
                slowest.append((seconds, here, entry.get("prism_mtbdd_s")))
                if entry.get("prism_mtbdd_s"):
                    ratios.setdefault(engine, []).append(entry["prism_mtbdd_s"] / max(seconds, 1e-3))
    print(f"{equal} counts equal, {wrong} wrong")
    for engine, all_of_it in ratios.items():
        mean = math.exp(sum(map(math.log, all_of_it)) / len(all_of_it))
        print(f"{engine}: {mean:.2f} times PRISM's speed in the geometric mean of {len(all_of_it)} formulas")
    for seconds, here, prism in sorted(slowest, reverse=True)[:8]:
        print(f"{seconds:8.2f} s (PRISM {prism}) {here}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
