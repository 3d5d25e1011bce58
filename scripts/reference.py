#!/usr/bin/env python3
"""A second opinion: the same answers as `meliora`, computed the slow way.

Reads a simple subset of the PRISM language (enough for `models/`) and preference files, enumerates
every state, builds the improvement MDP literally as S x {0,1} and runs textbook nested fixpoints on
it. It shares no code and no idea of efficiency with the Rust program; a few hundred thousand states
are its limit. Python 3.9 or later, nothing to install.

    reference.py info   MODEL [-c N=3]
    reference.py check  MODEL PREFS [-c N=3] [--scope all] [--safety prefix] [--empty gain]
    reference.py reach  MODEL --target EXPR [-c N=3] [--scope all]
    reference.py reach  MODEL --formula 'G F "goal"' [-c N=3] [--scope all]
    reference.py expect MODEL ...          run the `// EXPECT:` lines of models
    reference.py expect --fill MODEL ...   the same, and write the value of every `path=?` into the file

`info`, `check` and `reach` print the JSON of `meliora --json`, without times and memory.
"""

import argparse
import json
import sys

from reference_expect import run_expectations
from reference_lang import InputError, read_model, read_preferences
from reference_plan import check, info, reach, satisfy


def parse_constants(items):
    """`["N=3,K=4", "T=true"]` as a dictionary of texts."""
    pairs = [pair.partition("=") for item in items for pair in item.split(",") if pair]
    return {name.strip(): value.strip() for name, _, value in pairs}


def main():
    top = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = top.add_subparsers(dest="command", required=True)
    for name in ("info", "check", "reach"):
        command = commands.add_parser(name)
        command.add_argument("model")
        command.add_argument("-c", "--const", action="append", default=[])
        command.add_argument("--scope", choices=["reachable", "all"], default="reachable")
        if name == "check":
            command.add_argument("prefs")
            command.add_argument("--safety", choices=["action", "transition", "prefix"], default="action")
            command.add_argument("--empty", choices=["bottom", "gain", "incomparable"])
        if name == "reach":
            asked = command.add_mutually_exclusive_group(required=True)
            asked.add_argument("--target")
            asked.add_argument("--formula")
    command = commands.add_parser("expect")
    command.add_argument("models", nargs="+")
    command.add_argument("--fill", action="store_true")
    command.add_argument("--limit", type=int, default=200_000, help="skip lines whose model has more states")
    args = top.parse_args()

    if args.command == "expect":
        return run_expectations(args.models, fill=args.fill, limit=args.limit)
    try:
        model = read_model(args.model, parse_constants(args.const))
        if args.command == "info":
            result = info(model, args.scope)
        elif args.command == "reach":
            ask = reach if args.target else satisfy
            result = ask(model, args.target or args.formula, args.scope)
        else:
            result = check(model, read_preferences(args.prefs), args.scope, args.safety, args.empty)
    except InputError as error:
        print(f"error: {error}", file=sys.stderr)
        return 3
    print(json.dumps(result, indent=2))
    return 0


if __name__ == "__main__":
    sys.exit(main())
