#!/usr/bin/env python3
"""Coverage of Meliora on a collection of planning problems in PDDL.

    python3 scripts/planning.py FOLDER [--meliora PATH] [--seconds 10] [--memory 2GiB] [--domains REGEX]
                                [--every 1] [--list]

FOLDER contains one folder per domain, as the public collection AI-Planning/fond-domains does. Each problem is
paired with its domain: in the same file, or the file that its name or `(:domain NAME)` tells. `meliora reach`
is asked for a strong cyclic plan. The table has one row per domain: problems, those with a plan, those proved to
have none, those that ended at the limit of CPU time or memory, and errors. `--list` prints the pairs only.
"""

import argparse
import json
import re
import resource
import subprocess
import sys
import time
from pathlib import Path


def text_of(path):
    """Returns the text of a file without comments, in small letters."""
    text = path.read_text(errors="replace")
    return re.sub(r";[^\n]*", "", text).lower()


def name_in(text, key):
    """Returns the name in `(KEY NAME)`."""
    found = re.search(r"\(\s*" + key + r"\s+([^\s()]+)", text)
    return found.group(1) if found else None


def numbers(path):
    """Returns the digits of a file name, which pair `d_1_2.pddl` with `p_1_2.pddl`."""
    return re.findall(r"\d+", path.stem)


def pairs(folder):
    """Returns the files of each problem of a folder: its domain and itself, or itself alone."""
    texts = {path: text_of(path) for path in sorted(folder.glob("*.pddl"))}
    domains = {path: name for path, text in texts.items() if (name := name_in(text, "domain"))}
    for path, text in texts.items():
        if name_in(text, "problem") is None:
            continue
        if path in domains:
            yield [path]
            continue
        wanted = name_in(text, ":domain")
        rank = lambda domain: (
            domains[domain] != wanted,
            0 if numbers(domain) == numbers(path) else 1 if not numbers(domain) else 2,
            domain.name != "domain.pddl",
            len(domain.name),
            domain.name,
        )
        if domains:
            yield [min(domains, key=rank), path]


def limited(seconds):
    """Returns a function that limits the CPU time of a process."""
    return lambda: resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 1))


def solve(meliora, files, seconds, memory):
    """Asks for a strong cyclic plan. Returns the verdict, the message of an error, and the seconds of wall time."""
    command = [meliora, "reach", *map(str, files), "--json", "--memory", memory, "--threads", "1"]
    start = time.monotonic()
    done = subprocess.run(command, capture_output=True, text=True, preexec_fn=limited(seconds), check=False)
    spent = time.monotonic() - start
    if done.returncode not in (0, 1):
        return ("limit" if done.returncode in (4, -9, -24) else "error"), done.stderr.strip(), spent
    plan = json.loads(done.stdout)["plan"]["strong_cyclic"]
    return {True: "plan", False: "none", None: "limit"}[plan], "", spent


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--meliora", default="meliora")
    parser.add_argument("--seconds", type=int, default=10, help="CPU time for each problem")
    parser.add_argument("--memory", default="2GiB")
    parser.add_argument("--domains", default="", help="a regular expression")
    parser.add_argument("--every", type=int, default=1, help="asks about every n-th problem")
    parser.add_argument("--list", action="store_true")
    options = parser.parse_args()
    folders = sorted({path.parent for path in options.folder.rglob("*.pddl")})
    for folder in folders:
        name = str(folder.relative_to(options.folder))
        if not re.search(options.domains, name):
            continue
        problems = list(pairs(folder))[:: options.every]
        if options.list:
            for files in problems:
                print(*files)
            continue
        counts = dict.fromkeys(("plan", "none", "limit", "error"), 0)
        slowest = 0.0
        for files in problems:
            verdict, message, spent = solve(options.meliora, files, options.seconds, options.memory)
            counts[verdict] += 1
            slowest = max(slowest, spent if verdict in ("plan", "none") else 0)
            if verdict in ("none", "error"):
                detail = message.splitlines()[0] if message else ""
                print(f"{files[-1].relative_to(options.folder)}: {verdict} {detail}", file=sys.stderr)
        if problems:
            row = [name, len(problems), *counts.values(), f"{slowest:.1f}"]
            print("| " + " | ".join(map(str, row)) + " |", flush=True)


if __name__ == "__main__":
    main()
