#!/usr/bin/env python3
"""Asks questions in several forms: what can be asked, and how long it takes, must not depend on how it is written.

usage: forms.py [SOURCE…] [--root FOLDER] [--count 40] [--seed 0] [--limit 20] [--floor 0.2] [--ratio 1.3]
                [--meliora BINARY] [--python INTERPRETER]

Each SOURCE is a collection as for scripts/bench: models with targets are asked with one of several operators each, and
planning problems for their goals. Without a source, the questions are about the models of this repository, games and JANI among them. --count questions are drawn.

| form | is |
| --- | --- |
| alone | `--property P` |
| brackets | `!!(P)`, of a number `(P)` |
| joined | `true & (P)`, of a number `0 + (P)` |
| filter | `filter(forall, P, "init")`, of a number `filter(range, P, "init")` |
| twice | `--property P --property P` |
| file | a property file with P alone |
| next to a hard one | a property file with P and a property that takes very long; only its answer counts |
| jani | a property of the model in JANI, where the target can be copied to it |
| python | `Model.ask(P)` of the package, which INTERPRETER imports |

Every form must have the same answer, or none has one within --limit seconds of processor time. The processor time of each
is at most --ratio times that of the quickest; times below --floor count as --floor.
Exit status: 0 all agree, 1 some differ, 2 usage.
"""

from __future__ import annotations

import argparse
import json
import random
import re
import sys
import tempfile
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path
from typing import Any

import harness
from bench import instances

CONDITIONS = ("Pmax>=1", "P>=1", "Pmax>0", "P>0", "Pmax<1", "P<=0", "Pmax>=0.5")
NUMBERS = ("Pmax=?", "Pmin=?")
FORMULAS = ("F ({0})", "F ({0})", "G F ({0})", "!(F ({0}))", "X X ({0})")
# Takes very long in every model: nearly a billion steps, from every state.
HARD = 'filter(sum, Pmax=? [ F<=900000000 ("deadlock" & !"init") ], true)'
EQUALITIES = re.compile(r"\w+=-?\w+( & \w+=-?\w+)*")
OWN: tuple[tuple[str, str], ...] = (
    ("robot5x5.prism", "Pmax>=1 [ F (r=4 & c=4 & e) ]"),
    ("robot5x5.prism", "P>0 [ F b=0 ]"),
    ("robot5x5.prism", "Pmax=? [ F b=0 ]"),
    ("toy.prism", "P>=1 [ F s=3 ]"),
    ("toy.prism", "Pmin=? [ G F s=3 ]"),
    ("courier.prism", 'P>=1 [ F "deadlock" ]'),
    ("pond.prism", "Pmax>=1 [ F at=5 ]"),
    ("pond.prism", "Pmax<1 [ G at!=5 ]"),
    ("pursuit.prism -c N=4", "<<1>> P>=1 [ F !robots_turn ]"),
    ("pursuit.prism -c N=4", "<<1>> Pmax=? [ F !robots_turn ]"),
    ("responders.pddl", 'Pmax>=1 [ F "goal" ]'),
    ("responders.pddl", 'Pmax<1 [ F "goal" ]'),
    ("responders.pddl", 'Pmax=? [ F "goal" ]'),
    ("household.pddl household-flat.pddl", 'Pmax>=1 [ F "goal" ]'),
    ("household.pddl household-flat.pddl", 'P>=1 [ F "goal" ]'),
    ("workshop.jani -c N=2", "Pmax>=1 [ F broken ]"),
)


@dataclass(frozen=True)
class Asked:
    """A property of a model, with its target and its operator where they are known."""

    model: tuple[str, ...]
    text: str
    options: tuple[str, ...] = ()
    target: str = ""
    operator: str = ""

    @property
    def is_number(self) -> bool:
        return "=?" in self.text


def own(arguments: str, text: str) -> Asked:
    """A question about a model of this repository."""
    words = arguments.split()
    files = [str(harness.ROOT / "models" / word) for word in words if (harness.ROOT / "models" / word).exists()]
    return Asked(tuple(files), text, tuple(words[len(files) :]))


def drawn(source: str, root: Path | None, folder: Path, meliora: str, rng: random.Random) -> list[Asked]:
    """One question about each instance of a collection."""
    found = []
    for instance in instances.read(source, root, folder, meliora):
        options: tuple[str, ...] = ("--const", instance.constants) if instance.constants else ()
        options += ("--coalition", instance.coalition) if instance.coalition else ()
        text, target, operator = instances.PLAN if instance.kind == "plan" else instance.text, "", ""
        if instance.kind in ("regions", "states"):
            target, operator, formula = text, rng.choice((*CONDITIONS, *NUMBERS)), rng.choice(FORMULAS)
            text = f"{operator} [ {formula.format(target)} ]"
            operator = operator if formula == FORMULAS[0] else ""
        if instance.kind != "check":
            found.append(Asked(tuple(map(str, instance.files)), text, options, target, operator))
    return found


def forms(asked: Asked, folder: Path) -> dict[str, list[str]]:
    """The arguments of each form."""
    p, number = asked.text, asked.is_number
    file, hard = folder / "asked.props", folder / "hard.props"
    file.write_text(f"{p}\n", encoding="utf-8")
    hard.write_text(f"{p}\n{HARD}\n", encoding="utf-8")
    made = {
        "alone": ["--property", p],
        "brackets": ["--property", f"({p})" if number else f"!!({p})"],
        "joined": ["--property", f"0 + ({p})" if number else f"true & ({p})"],
        "filter": ["--property", f'filter({"range" if number else "forall"}, {p}, "init")'],
        "twice": ["--property", p, "--property", p],
        "file": ["--properties", str(file)],
        "next to a hard one": ["--properties", str(hard)],
    }
    made = {form: [*asked.model, *arguments, *asked.options] for form, arguments in made.items()}
    if asked.model[0].endswith(".jani") and asked.operator and EQUALITIES.fullmatch(asked.target):
        copy = folder / "asked.jani"
        copy.write_text(json.dumps(with_property(asked)), encoding="utf-8")
        made["jani"] = [str(copy), "--property", "asked", *asked.options]
    return made


# The form in Python: the arguments are the limit, the property, the constants and the files.
ASK = """
import json, sys, time
import meliora
begin, (limit, text, constants, *files) = time.process_time(), sys.argv[1:]
given = {name: json.loads(value) for name, value in (part.split("=") for part in constants.split(",") if part)}
read = meliora.Model.from_pddl if len(files) > 1 else meliora.Model.from_file
model = read(*files) if len(files) > 1 else read(*files, constants=given)
try:
    found = [model.ask(text, timeout=limit + "s", memory="3GiB")]
except meliora.errors.LimitError as error:
    found = error.known["properties"]
print(json.dumps({"properties": found, "seconds": time.process_time() - begin}))
"""


def in_python(asked: Asked, python: str, limit: float) -> harness.Finished:
    """Runs the form in Python."""
    constants = next((value for name, value in zip(asked.options, asked.options[1:]) if name in ("-c", "--const")), "")
    arguments = [f"{limit:.0f}", asked.text, constants, *asked.model]
    return harness.run([python, "-c", ASK, *arguments], 4.0 * limit)


def with_property(asked: Asked) -> dict[str, Any]:
    """The JANI model with the property."""
    model = json.loads(Path(asked.model[0]).read_text(encoding="utf-8-sig"))
    target: Any = True
    for part in asked.target.split(" & "):
        name, value = part.split("=")
        value = {"true": True, "false": False}.get(value, int(value) if value.lstrip("-").isdigit() else value)
        target = {"op": "∧", "left": target, "right": {"op": "=", "left": name, "right": value}}
    name, sign, bound = re.fullmatch(r"(P(?:max|min)?)(>=|<=|>|<|=)(.*)", asked.operator).groups()
    unnamed = "Pmin" if sign in (">=", ">") else "Pmax"
    values: Any = {"op": unnamed if name == "P" else name, "exp": {"op": "F", "exp": target}}
    if sign != "=":
        values = {"op": {">=": "≥", "<=": "≤"}.get(sign, sign), "left": values, "right": float(bound)}
    states = {"op": "initial"}
    fun = "max" if sign == "=" else "∀"
    filtered = {"op": "filter", "fun": fun, "values": values, "states": states}
    model["properties"] = [{"name": "asked", "expression": filtered}]
    return model


def answer(report: dict[str, Any] | None) -> Any:
    """The answer to the first property; None without one."""
    first = ((report or {}).get("properties") or [{}])[0]
    if isinstance(first.get("value"), dict) and first.get("holds") is None:
        return ("value", first["value"]["lower"], first["value"]["upper"])
    return None if first.get("holds") is None else ("holds", first["holds"])


def agree(one: Any, other: Any) -> bool:
    if one is None or other is None or one[0] != other[0] or one[0] == "holds":
        return one == other
    near = [abs(x - y) <= 3e-6 * max(1.0, abs(x)) for x, y in zip(one[1:], other[1:]) if x != y]
    return all(near)


def checked(asked: Asked, options: argparse.Namespace, meliora: str, folder: Path) -> list[str]:
    """The faults of the forms of a question."""
    runs = {}
    name = f"{' '.join(Path(path).name for path in asked.model)} {' '.join(asked.options)} {asked.text}"
    for form, arguments in forms(asked, folder).items():
        limits = ["--timeout", f"{options.limit:.0f}s", "--memory", "3GiB", "--json"]
        run = harness.run([meliora, "reach", *arguments, *limits], 4.0 * options.limit)
        if run.status not in (0, 1, harness.OUT_OF_RESOURCES):
            wrong = [f"{form}: {harness.complaint(run)}"]
            told(name, wrong, "not answered")
            return wrong
        runs[form] = (answer(harness.json_object(run.stdout)), max(run.cpu_seconds, options.floor))
    if options.python:
        run = in_python(asked, options.python, options.limit)
        report = harness.json_object(run.stdout) or {}
        runs["python"] = (answer(report), max(report.get("seconds", run.cpu_seconds), options.floor))
    wanted = next((found for found, _ in runs.values() if found is not None), None)
    timed = {form: seconds for form, (_, seconds) in runs.items() if form != "next to a hard one"}
    quickest = min(timed.values())
    wrong = [f"{form}: {found}, not {wanted}" for form, (found, _) in runs.items() if not agree(found, wanted)]
    for form, seconds in timed.items():
        if wanted is not None and seconds > options.ratio * quickest:
            wrong.append(f"{form}: {seconds:.2f} s, the quickest form {quickest:.2f} s")
    times = " ".join(f"{form} {seconds:.2f}" for form, seconds in timed.items())
    told(name, wrong, f"{wanted}  {times}")
    return wrong


def told(name: str, wrong: list[str], more: str) -> None:
    print("\n    ".join([f"{'DIFFERS' if wrong else 'ok'}  {name}", more, *wrong]), flush=True)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sources", nargs="*", metavar="SOURCE")
    parser.add_argument("--root", type=Path)
    parser.add_argument("--count", type=int, default=40)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--limit", type=float, default=20.0)
    parser.add_argument("--floor", type=float, default=0.2)
    parser.add_argument("--ratio", type=float, default=1.3)
    parser.add_argument("--meliora")
    parser.add_argument("--python", help="an interpreter that imports the package")
    options = parser.parse_args()
    meliora, rng = harness.find_meliora(options.meliora), random.Random(options.seed)
    with tempfile.TemporaryDirectory() as home:
        folder = Path(home)
        collections = [[own(*asked) for asked in OWN]]
        collections += [drawn(source, options.root, folder, meliora, rng) for source in options.sources]
        for collection in collections:
            rng.shuffle(collection)
        turns = [asked for row in zip_longest(*collections) for asked in row if asked is not None]
        questions = turns[: options.count]
        wrong = [reason for asked in questions for reason in checked(asked, options, meliora, folder)]
    print(f"{len(questions)} questions, {len(wrong)} differences")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
