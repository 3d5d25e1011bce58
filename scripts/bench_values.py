#!/usr/bin/env python3
"""Compares the time of `meliora values --all` with that of `meliora check` on random grid worlds.

usage: bench_values.py [--sizes 16,32,64] [--items 6] [--seed 1] [--levels 2] [--timeout 600] [--memory 8GiB]
                       [--markdown FILE] [--binary PATH]

Both are whole processes. `explore` and `solve` are the phases that only `values` has; the rest of its time is that of
`check` and of writing the report with all states.
Exit status: 0 done, 1 a run failed, 2 usage.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from pathlib import Path

import harness


def measure(args: argparse.Namespace, size: int, folder: Path) -> list[str] | None:
    """One row of the table; none if a run failed."""
    world = harness.gridworld(args.binary, size, args.items, args.seed, folder)
    files = [str(world.model), str(world.preferences)]
    limits = ["--timeout", f"{args.timeout:.0f}s", "--memory", args.memory]
    check = harness.run([args.binary, "check", *files, "--json", *limits], args.timeout + 30)
    options = ["--all", "--limit", "4000000000", "--levels", str(args.levels), "--json", *limits]
    values = harness.run([args.binary, "values", *files, *options], args.timeout + 30)
    if check.status != 0:
        return None
    report = json.loads(values.stdout) if values.stdout else {}
    time = report.get("time", {})
    states = json.loads(check.stdout)["counts"]["states"]
    phases = [f"{time[phase]:.2f} s" if phase in time else "-" for phase in ("explore", "solve")]
    done = f"{values.seconds:.2f} s" if values.status == 0 else f"status {values.status} after {values.seconds:.0f} s"
    memory = f"{values.peak_bytes / 2**20:.0f} MiB"
    return [f"{size} x {size}", f"{int(states):,}", f"{check.seconds:.2f} s", *phases, done, memory]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sizes", type=harness.integers, default=[16, 32, 64])
    parser.add_argument("--items", type=int, default=6)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--levels", type=int, default=2)
    parser.add_argument("--timeout", type=float, default=600)
    parser.add_argument("--memory", default="8GiB")
    parser.add_argument("--markdown", type=Path)
    parser.add_argument("--binary", help="the command meliora")
    args = parser.parse_args()
    args.binary = harness.find_meliora(args.binary)
    lines = ["| grid | states | check | explore | solve | values, in all | memory |", "| --- " * 7 + "|"]
    with tempfile.TemporaryDirectory() as folder:
        for size in args.sizes:
            row = measure(args, size, Path(folder))
            if row is None:
                print(f"{size} x {size}: the run failed", file=sys.stderr)
                return 1
            lines.append("| " + " | ".join(row) + " |")
            print(lines[-1], flush=True)
    if args.markdown:
        args.markdown.write_text("\n".join(lines) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
