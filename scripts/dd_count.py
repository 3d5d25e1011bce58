#!/usr/bin/env python3
"""Loads a dump with the Python package `dd` and counts the members of every region.

    pip install dd
    dd_count.py DIR            prints "region count" lines
    dd_count.py DIR --check    and exits with 1 where the manifest says another count

A second opinion on the files: nothing of Meliora takes part. The counts are over the bits of the
states, or of states and choices; the dump's regions have only patterns that are values.
"""

import argparse
import json
import pathlib
import sys

import dd.dddmp


def root_numbers(path):
    """The numbers after `.rootids`: nodes of the file, negative where complemented."""
    with open(path) as lines:
        for line in lines:
            if line.startswith(".rootids"):
                return [int(word) for word in line.split()[1:]]
            if line.startswith(".nodes"):
                break
    raise SystemExit(f"{path}: no .rootids")


def region_counts(directory, part="regions"):
    """Yields (name, count, the manifest's count) for the roots of one file of a dump."""
    manifest = json.loads((directory / "manifest.json").read_text())
    described = manifest[part]
    path = directory / described["path"]
    sys.setrecursionlimit(100_000)
    bdd = dd.dddmp.load(str(path))
    numbers = root_numbers(path)
    state_bits = len(manifest["encoding"]["order"])
    choice_bits = len(manifest["choices"]["order"])
    for root in described["roots"]:
        width = state_bits if root["kind"] == "states" else state_bits + choice_bits
        # The file numbers nodes as `dd` does when it loads them, so its numbers are valid here.
        yield root["name"], bdd.count(numbers[root["root"]], width), int(root["count"])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("directory", type=pathlib.Path)
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--certificate", action="store_true", help="count the certificate's roots too")
    args = parser.parse_args()
    parts = ["regions", "certificate"] if args.certificate else ["regions"]
    wrong = 0
    for part in parts:
        for name, counted, expected in region_counts(args.directory, part):
            print(name, counted)
            if args.check and counted != expected:
                print(f"{name}: dd counts {counted}, the manifest says {expected}", file=sys.stderr)
                wrong = 1
    return wrong


if __name__ == "__main__":
    sys.exit(main())
