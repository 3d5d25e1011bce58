"""Random cases against the reference.

    python3 scripts/tester [--seeds 0:5000] [-j N] [--minutes N] [--binary PATH] [--only CHECK,...] [--python]

Each seed draws a model, preferences and settings. Everything that the program can say about the case is compared with
the reference, or with what its definition promises. A difference is made smaller and printed with its files and its
command. At the end a table shows the cases, the checks by kind, the pairs of features that met, and the differences.
Exit status: 0 no difference, 1 differences.
"""

import argparse
import importlib.util
import itertools
import math
import os
import re
import signal
import sys
import tempfile
import time
import traceback
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field, replace
from pathlib import Path

sys.path[0] = str(Path(__file__).resolve().parent.parent)

import harness  # noqa: E402
from reference.games import LeftOut  # noqa: E402
from reference.prism import InputError  # noqa: E402
from tester import games, package, suites  # noqa: E402
from tester.context import Context, Difference  # noqa: E402
from tester.draw import draw  # noqa: E402
from tester.program import Program, Refused  # noqa: E402


# The checks of the Python package.
PYTHON = ("python", "asked")
# The commands that checks ask, besides `check` and `reach`. Not all honour the players of a game.
NEEDED = {
    **dict.fromkeys(("strategy", "ranks", "cut", "pursue", "tables", "together", "followed", "places", "memory"), "strategy"),
    **dict.fromkeys(("simulate", "chosen"), "simulate"),
    **dict.fromkeys(("dump", "limited", "exchange", "induced"), "export"),
    **dict.fromkeys(("values", "choose"), "values"),
    "pages": "report",
}
# The program may refuse a case, and then no command answers.
THE_CASE = re.compile("(is|are) not supported")
# It may refuse one question: the bounds of doubles cannot tell a probability above 1 - 2^-53 from 1.
THE_QUESTION = "no bound below 1 was found for a probability below 1"


@dataclass
class Outcome:
    seed: int
    features: set
    compared: dict = field(default_factory=dict)
    differences: list = field(default_factory=list)
    text: str = ""


def examine(case, binary, checks, ignored=""):
    """Runs the checks of a case. Returns the number of comparisons by check, and one difference per check."""
    with tempfile.TemporaryDirectory() as folder:
        program = Program(binary, Path(folder), case)
        try:
            context = Context(case, program)
        except InputError as error:
            compared, found = games.refused(case, program, error)
            if "python" in checks:
                found += package.refused(case, error)
                compared["faults"] += 1
            return compared, found
        except LeftOut:
            return {"left out": 1}, []
        case.features |= context.features()
        for name in ["model", *(name for name in checks if name != "model")]:
            if name != "model" and any(d.check == "model" for d in context.differences):
                break  # nothing can be compared state by state
            if not program.plays(NEEDED.get(name, "check")):
                continue
            context.check = name
            try:
                suites.ALL[name](context)
            except Refused as refused:
                if THE_CASE.search(str(refused)):
                    context.compared["refused by name"] = 1
                    if not context.is_game:
                        break
                    continue
                if THE_QUESTION not in str(refused):
                    found = Difference(name, "refused", "an answer", str(refused), program.asked[-1])
                    context.differences.append(found)
            except Exception:
                found = traceback.format_exc(limit=-3)
                context.differences.append(Difference(name, "the tester failed", "", found, program.asked[-1:]))
        found = [d for d in context.differences if not (ignored and re.search(ignored, str(d)))]
        return context.compared, list({d.check: d for d in reversed(found)}.values())[::-1]


def shrink(case, binary, difference, ignored, rounds=3):
    """Leaves out what a difference does not need, as long as the same check still differs."""

    def differs(smaller):
        try:
            _, found = examine(smaller, binary, [difference.check], ignored)
        except Exception:
            return False
        return next((d for d in found if likeness(d) == likeness(difference)), None)

    for _ in range(rounds):
        before = case
        for name in case.LISTS:
            for item in list(getattr(case, name)):
                left = [other for other in getattr(case, name) if other is not item]
                found = differs(replace(case, **{name: left}))
                if found:
                    case, difference = replace(case, **{name: left}), found
        for name, value in SIMPLEST.items():
            smaller = replace(case, settings={**case.settings, name: value})
            found = case.settings[name] != value and differs(smaller)
            if found:
                case, difference = smaller, found
        if case is before:
            break
    return case, difference


def likeness(difference):
    """What two differences of the same kind have in common."""
    said = re.search(r'"message": "[^`"]*', str(difference.got))
    return difference.check, difference.what.split()[0], said and said[0]


SIMPLEST = {
    "scope": "reachable", "safety": "action", "threads": 1, "order": "declared", "reward": "steps", "coalition": "",
}  # fmt: skip


def features_of(seed):
    """The features that are drawn in a case, and those that the reference finds in it."""
    case = draw(seed)
    try:
        found = Context(case, None).features()
    except (InputError, LeftOut):
        found = set()
    return Outcome(seed, case.features | found)


def run_case(seed, binary, checks, ignored, shrinks):
    case = draw(seed)
    outcome = Outcome(seed, case.features)
    try:
        outcome.compared, outcome.differences = examine(case, binary, checks, ignored)
    except Exception:
        outcome.differences = [Difference("reference", "failed", "", traceback.format_exc(limit=-3), [])]
    if outcome.differences:
        first, *others = outcome.differences
        small, first = shrink(case, binary, first, ignored) if shrinks and first.check != "reference" else (case, first)
        outcome.text = "\n".join(
            [*(f"seed {seed}: also {other}" for other in others), reproduction(seed, small, first)]
        )
    return outcome


def reproduction(seed, case, difference):
    command = " ".join(f"'{word}'" if " " in str(word) else str(word) for word in difference.command)
    lines = [f"seed {seed}: {difference}", f"  command: {command}"]
    lines += [f"  | {line}" for line in (case.model_text() + case.preferences_text()).splitlines() if line]
    return "\n".join(lines)


def table(outcomes, least=200):
    """The table of comparisons, and of the pairs of features that met."""
    compared, pairs, features, differing = Counter(), Counter(), Counter(), Counter()
    for outcome in outcomes:
        compared.update(outcome.compared)
        features.update(outcome.features)
        pairs.update(itertools.combinations(sorted(outcome.features), 2))
        differing.update({d.check for d in outcome.differences})
    lines = [f"{len(outcomes)} cases, {sum(bool(o.differences) for o in outcomes)} with differences"]
    lines += [f"  {name:12} {count:10} compared {differing[name]:6} differ" for name, count in sorted(compared.items())]
    met = sum(count >= least for count in pairs.values())
    lines.append(f"{len(features)} features, {len(pairs)} pairs met, {met} of them at least {least} times")
    rarest = sorted(pairs.items(), key=lambda item: item[1])[:8]
    lines += [f"  {count:6} {' with '.join(pair)}" for pair, count in rarest]
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", default="0:1000", help="FIRST:END, or one seed")
    parser.add_argument("-j", "--jobs", type=int, default=2)
    parser.add_argument("--binary", help="the command meliora")
    parser.add_argument("--only", help="checks to run, with commas: " + ", ".join(suites.ALL))
    parser.add_argument("--avoid", default="", help="features of cases to leave out, with commas")
    parser.add_argument("--ignore", default="", help="regular expression of differences that are known")
    parser.add_argument("--no-shrink", action="store_true", help="print cases as they were drawn")
    parser.add_argument("--pairs", action="store_true", help="only count the pairs of features that meet")
    parser.add_argument("--python", action="store_true", help="also compare the Python package with the command")
    parser.add_argument("--minutes", type=float, default=math.inf, help="stop after this time")
    parser.add_argument("--most", type=int, default=20, help="stop after this number of cases with differences")
    args = parser.parse_args()
    checks = args.only.split(",") if args.only else [name for name in suites.ALL if name not in PYTHON]
    if args.python:
        checks = list(dict.fromkeys([*checks, *PYTHON]))
    if set(PYTHON) & set(checks) and importlib.util.find_spec("meliora") is None:
        parser.error("--python needs the package meliora: install ./python, and use the interpreter that has it")
    first, _, last = args.seeds.partition(":")
    avoided = set(filter(None, args.avoid.split(",")))
    seeds = range(int(first), int(last) if last else int(first) + 1)
    seeds = [seed for seed in seeds if not avoided & draw(seed).features] if avoided else seeds
    if args.pairs:
        with ProcessPoolExecutor(args.jobs) as pool:
            print(table(list(pool.map(features_of, seeds, chunksize=64))))
        return 0
    binary, outcomes, wrong = harness.find_meliora(args.binary), [], 0
    end = time.monotonic() + 60 * args.minutes
    for wanted in (signal.SIGINT, signal.SIGTERM):
        signal.signal(wanted, signal.default_int_handler)
    with ProcessPoolExecutor(args.jobs) as pool:
        pending = pool.map(
            run_case, seeds, *map(itertools.repeat, (binary, checks, args.ignore, not args.no_shrink)), chunksize=4
        )
        try:
            for outcome in pending:
                outcomes.append(outcome)
                if outcome.text:
                    print(outcome.text, flush=True)
                    wrong += 1
                if wrong >= args.most or time.monotonic() > end:
                    break
        except KeyboardInterrupt:
            pass  # the table has the cases so far
        finally:
            pool.shutdown(wait=False, cancel_futures=True)
    print(table(outcomes))
    return int(wrong > 0)


if __name__ == "__main__":
    try:
        status = main()
        sys.stdout.flush()
    except BrokenPipeError:  # nobody reads on; the interpreter must not write at its end, either
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        status = 1
    sys.exit(status)
