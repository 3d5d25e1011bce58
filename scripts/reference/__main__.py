"""A second opinion: the answers of `meliora`, computed from the definitions over explicit sets, in fractions.

Reads a subset of PRISM's language (enough for `models/`) and preference files. It shares nothing with the program, and
is slow: a few thousand states are its limit, a few hundred with quantities. Python 3.9 or later, nothing to install.

    python3 scripts/reference info   MODEL [-c N=3]
    python3 scripts/reference check  MODEL PREFS [-c N=3] [--scope all] [--safety prefix] [--empty gain]
    python3 scripts/reference values MODEL PREFS [-c N=3] [--scope all] [--levels K] [--reward NAME]
    python3 scripts/reference reach  MODEL --target EXPR [-c N=3] [--scope all]
    python3 scripts/reference reach  MODEL --formula 'G F "goal"' [-c N=3] [--scope all]
    python3 scripts/reference expect MODEL ...          run the `// EXPECT:` lines of models
    python3 scripts/reference expect --fill MODEL ...   the same, and write the value of every `path=?` into the file
    python3 scripts/reference laws                      compare monitors with the definition of temporal formulas

`info`, `check` and `reach` print the JSON of `meliora --json`, without times and memory.
"""

import argparse
import json
import sys
from pathlib import Path

sys.path[0] = str(Path(__file__).resolve().parent.parent)

from reference import laws, reports  # noqa: E402
from reference.analysis import Analysis  # noqa: E402
from reference.expect import run_expectations  # noqa: E402
from reference.preferences import read_preferences  # noqa: E402
from reference.prism import InputError, read_program  # noqa: E402
from reference.quantities import Quantities  # noqa: E402


def constants_of(items):
    """`["N=3,K=4", "T=true"]` as a dictionary of texts."""
    pairs = [pair.partition("=") for item in items for pair in item.split(",") if pair]
    return {name.strip(): value.strip() for name, _, value in pairs}


def values(program, preferences, args):
    """P_k, C_k and N of each state, one line per state."""
    analysis = Analysis(program, preferences, args.scope, args.safety)
    quantities = Quantities(analysis, args.reward)
    probabilities = quantities.probabilities(args.levels)
    costs, numbers = quantities.costs(probabilities), quantities.numbers()
    for state in analysis.mdp.states:
        node, found = quantities.own(state), []
        for k, ((p, _), (c, _)) in enumerate(zip(probabilities, costs), 1):
            found.append(f"P_{k}={p.get(node, 0)} C_{k}={c.get(node, '-')}")
        print(program.show(analysis.whole.plain(state)), *found, f"N={numbers.get(node, 0)}")


def arguments():
    top = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = top.add_subparsers(dest="command", required=True)
    for name in ("info", "check", "values", "reach"):
        command = commands.add_parser(name)
        command.add_argument("model")
        command.add_argument("-c", "--const", action="append", default=[])
        command.add_argument("--scope", choices=["reachable", "all"], default="reachable")
        command.add_argument("--coalition", type=lambda text: text.split(","), default=[])
        if name in ("check", "values"):
            command.add_argument("prefs")
            command.add_argument("--safety", choices=["action", "transition", "prefix"], default="prefix")
            command.add_argument("--empty", choices=["bottom", "gain", "incomparable"])
        if name == "values":
            command.add_argument("--levels", type=int, default=2)
            command.add_argument("--reward", default="steps")
        if name == "reach":
            asked = command.add_mutually_exclusive_group(required=True)
            asked.add_argument("--target")
            asked.add_argument("--formula")
    command = commands.add_parser("expect")
    command.add_argument("models", nargs="+")
    command.add_argument("--fill", action="store_true")
    command.add_argument("--limit", type=int, default=200_000, help="skip lines whose model has more states")
    command = commands.add_parser("laws")
    command.add_argument("--formulas", type=int, default=2000)
    return top.parse_args()


def answer(args):
    program = read_program(args.model, constants_of(args.const))
    if args.command == "info":
        return reports.info(program, args.scope)
    if args.command == "reach":
        return reports.reach(program, args.scope, args.target, args.formula, coalition=args.coalition)
    preferences = read_preferences(args.prefs)
    preferences.empty = args.empty or preferences.empty
    if args.command == "values":
        return values(program, preferences, args)
    return reports.check(program, preferences, args.scope, args.safety, coalition=args.coalition)


def main():
    args = arguments()
    if args.command == "expect":
        return run_expectations(args.models, fill=args.fill, limit=args.limit)
    if args.command == "laws":
        return laws.compare(args.formulas)
    try:
        found = answer(args)
    except (InputError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 3
    if found is not None:
        print(json.dumps(found, indent=2))
    return 0


if __name__ == "__main__":
    sys.exit(main())
