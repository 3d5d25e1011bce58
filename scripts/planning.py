#!/usr/bin/env python3
"""Coverage of Meliora on a collection of planning problems in PDDL.

    python3 scripts/planning.py FOLDER [--meliora PATH] [--seconds 10] [--memory 2GiB] [--domains REGEX]
                                [--every 1] [--first 0] [--results FILE.csv] [--list | --table]

FOLDER contains one folder per domain, as the public collection AI-Planning/fond-domains does. Each problem is
paired with its domain: in the same file, or the file that its name or `(:domain NAME)` tells; a corrected version
has `fixed` in its name. `meliora reach`
is asked for a strong cyclic plan within limits of CPU time and memory. The problems are asked in an order of which each
beginning is spread over all domains, so that the table of a part is fair, and the run can be continued. The same run writes a
policy if there is a plan, and `meliora verify` checks it. The results are appended to a file with one line per
problem; problems that it contains are not asked again. The table has one row per domain: problems, those with a
plan, their policies that were written and verified, problems proved to have no plan, those that ended at a limit,
and errors. `--list` prints the pairs only, `--table` the table of the results only.
"""

import argparse
import csv
import json
import re
import resource
import subprocess
import tempfile
import time
from pathlib import Path

FIELDS = ("domain", "problem", "verdict", "seconds", "policy", "states", "message")


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
            "fixed" not in domain.name,
            domain.name != "domain.pddl",
            len(domain.name),
            domain.name,
        )
        if domains:
            yield [min(domains, key=rank), path]


class Asking:
    """Runs of the program within limits."""

    def __init__(self, options):
        self.options = options

    def run(self, command, *arguments):
        """Runs a command with `--json`. Returns the finished process and its seconds of CPU time."""
        seconds, memory = self.options.seconds, ("--memory", self.options.memory)
        limit = lambda: resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 1))
        used = lambda: sum(resource.getrusage(resource.RUSAGE_CHILDREN)[:2])
        start = used()
        words = [self.options.meliora, command, *map(str, arguments), "--json", *memory]
        done = subprocess.run(words, capture_output=True, text=True, preexec_fn=limit, check=False)
        return done, used() - start

    def answer(self, files):
        """Returns the verdict of a problem, the seconds, what became of its policy, its states, and a message.

        The verdict and the policy come from one run; only if that ends at a limit, from one without a policy."""
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "policy.txt")
            done, spent = self.run("reach", *files, "--threads", "1", "--policy", path)
            policy, states = "", ""
            if is_at_limit(done):
                done, spent = self.run("reach", *files, "--threads", "1")
                policy = "limit"
            if done.returncode not in (0, 1):
                lines = done.stderr.strip().splitlines() or [""]
                at_limit = is_at_limit(done)
                return ("limit" if at_limit else "error"), spent, "", "", lines[-1 if at_limit else 0]
            found = json.loads(done.stdout)
            verdict = {True: "plan", False: "none", None: "limit"}[found["plan"]["strong_cyclic"]]
            if path.exists():
                policy, states = self.verified(path, files), found["plan"]["policy_states"]
        way = "guided search" if found.get("by_guided_search") else ""
        way = "all valuations" if found.get("over_all_valuations") else way
        return verdict, spent, policy, states, way

    def verified(self, path, files):
        """Returns what `verify` says of a policy."""
        done, _ = self.run("verify", path, *files)
        return "limit" if is_at_limit(done) else {0: "verified", 1: "refused"}.get(done.returncode, "error")


def is_at_limit(done):
    """Returns whether a finished process ended at its limit of time or memory."""
    return done.returncode in (4, -9, -24)


def spread(items):
    """Returns the items in the order of their reversed binary numbers: each beginning is spread over all."""
    bits = len(items).bit_length()
    numbers = sorted(range(len(items)), key=lambda number: f"{number:0{bits}b}"[::-1])
    return [items[number] for number in numbers]


def read(path):
    """Returns the lines of the results by domain and problem."""
    if not path or not path.exists():
        return {}
    with path.open(newline="") as lines:
        return {(line["domain"], line["problem"]): line for line in csv.DictReader(lines)}


def append(path, line):
    is_new = not path.exists()
    with path.open("a", newline="") as lines:
        writer = csv.DictWriter(lines, FIELDS)
        if is_new:
            writer.writeheader()
        writer.writerow(line)


def table(results):
    """Prints one row per domain, and their sum."""
    domains = {}
    for (domain, _), line in sorted(results.items()):
        domains.setdefault(domain, []).append(line)
    count = lambda lines, field, value: sum(line[field] == value for line in lines)
    rows = []
    for domain, lines in domains.items():
        verdicts = [count(lines, "verdict", verdict) for verdict in ("plan", "none", "limit", "error")]
        rows.append((domain, len(lines), verdicts[0], count(lines, "policy", "verified"), *verdicts[1:]))
    rows.append(("all", *(sum(row[at] for row in rows) for at in range(1, 7))))
    print("| domain | problems | plan | policy verified | no plan | limit | error |")
    print("| --- | ---: | ---: | ---: | ---: | ---: | ---: |")
    for row in rows:
        print("| " + " | ".join(map(str, row)) + " |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--meliora", default="meliora")
    parser.add_argument("--seconds", type=int, default=10, help="CPU time for each run of the program")
    parser.add_argument("--memory", default="2GiB")
    parser.add_argument("--domains", default="", help="a regular expression")
    parser.add_argument("--every", type=int, default=1, help="asks about every n-th problem of all domains")
    parser.add_argument("--first", type=int, default=0, help="the number of the first one, from 0")
    parser.add_argument("--results", type=Path, default=Path("planning.csv"))
    parser.add_argument("--list", action="store_true")
    parser.add_argument("--table", action="store_true")
    options = parser.parse_args()
    results = read(options.results)
    if options.table:
        return table(results)
    folders = sorted({path.parent for path in options.folder.rglob("*.pddl")})
    found = [(str(folder.relative_to(options.folder)), files) for folder in folders for files in pairs(folder)]
    asking = Asking(options)
    for domain, files in spread(found[options.first :: options.every]):
        if not re.search(options.domains, domain):
            continue
        if options.list:
            print(*files)
        elif (domain, files[-1].name) not in results:
            verdict, spent, policy, states, message = asking.answer(files)
            line = (domain, files[-1].name, verdict, f"{spent:.2f}", policy, states, message)
            append(options.results, dict(zip(FIELDS, line)))
    if not options.list:
        table(read(options.results))


if __name__ == "__main__":
    main()
