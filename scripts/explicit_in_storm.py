#!/usr/bin/env python3
"""Loads explicit exports in Storm and checks that they are the model, and that a strategy keeps its promise.

usage: explicit_in_storm.py MODEL PREFS [--kind sasi|spi] [--const K=4,N=3] [--meliora PATH]

Exports the model as `.drn` and as `.tra` and `.lab`, and the chain of the progress strategy as `.drn`, loads all three
by stormpy and requires: the same states, choices and transitions as `meliora check` counts, in both formats; and in
the chain, from every initial state of a rank above 0, a probability of 1 (sasi) or more than 0 (spi) to improve.
Exit status: 0 all hold, 1 something differs, 2 usage. Needs stormpy.
"""

from __future__ import annotations

import argparse
import re
import sys
import tempfile
from pathlib import Path
from typing import Any

import harness

CLOSE = 1e-6


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("model", type=Path, metavar="MODEL")
    parser.add_argument("preferences", type=Path, metavar="PREFS")
    parser.add_argument("--kind", choices=["sasi", "spi"], default="sasi")
    parser.add_argument("--const", default="", metavar="K=4,…")
    parser.add_argument("--meliora", metavar="PATH", help="the binary")
    given = parser.parse_args()
    given.meliora = harness.find_meliora(given.meliora)
    return given


def meliora(given: argparse.Namespace, command: str, *more: str) -> dict[str, Any]:
    """One run; its JSON object."""
    line = [given.meliora, command, str(given.model), str(given.preferences), "--json", "--quiet", *more]
    line += ["--const", given.const] if given.const else []
    finished = harness.run(line, 600.0)
    report = harness.json_object(finished.stdout)
    if finished.status != 0 or report is None:
        harness.stop(f"meliora {command}: {harness.complaint(finished)}")
    return report


def for_storm(folder: Path) -> tuple[Path, Path]:
    """PRISM's .tra and .lab in Storm's format: the kind in place of the sizes, labels by name."""
    sizes, *lines = (folder / "model.tra").read_text().splitlines()
    kind = "mdp" if len(sizes.split()) == 3 else "dtmc"
    transitions = folder / "storm.tra"
    # The names of actions stand behind the probability, where Storm expects nothing.
    columns = 4 if kind == "mdp" else 3
    rows = [" ".join(line.split(" ", columns)[:columns]) for line in lines]
    transitions.write_text("\n".join([kind, *rows]) + "\n")
    heads, *lines = (folder / "model.lab").read_text().splitlines()
    names = dict(re.findall(r'(\d+)="([^"]*)"', heads))
    labels = folder / "storm.lab"
    declared = ["#DECLARATION", " ".join(names.values()), "#END"]
    labelled = [re.sub(r"\d+$|\d+(?= )", lambda m: names[m[0]], rest) for rest in (line.split(": ", 1)[1] for line in lines)]
    states = [f"{line.split(':', 1)[0]} {own}" for line, own in zip(lines, labelled)]
    labels.write_text("\n".join([*declared, *states]) + "\n")
    return transitions, labels


def sizes(model: Any) -> dict[str, int]:
    """Returns the counts of Storm."""
    return {"states": model.nr_states, "choices": model.nr_choices, "transitions": model.nr_transitions}


def same(name: str, expected: dict[str, int], found: dict[str, int]) -> bool:
    """Prints the sizes; returns whether they are the same."""
    print(f"{name:6} " + ", ".join(f"{count} {key}" for key, count in found.items()))
    for key, count in found.items():
        if expected[key] != count:
            print(f"  DIFFERS: {expected[key]} {key} expected")
    return expected == found


def keeps_promise(stormpy: Any, kind: str, chain: Any) -> bool:
    """Returns whether each initial state of a rank improves as its strategy guarantees."""
    if "improved" not in chain.labeling.get_labels():
        print("chain  has no improvement, and no state of a rank promises one")
        return not any(f"{kind}_rank_{k}" in chain.labeling.get_labels() for k in ("1", "2", "unbounded"))
    values = stormpy.model_checking(chain, stormpy.parse_property('P=? [ F "improved" ]'))
    kept = True
    for state in chain.initial_states:
        idle = f"{kind}_rank_0" in chain.labeling.get_labels_of_state(state)
        value = float(values.at(state) if hasattr(values, "at") else values[state])
        good = idle or (value > 1 - CLOSE if kind == "sasi" else value > 0)
        kept &= good
        print(f"chain  state {state} improves with probability {value:.6f}" + ("" if good else "  BROKEN PROMISE"))
    return kept


def main() -> int:
    given = arguments()
    try:
        import stormpy
    except ImportError:
        harness.stop("the Python package stormpy is missing: `pip install stormpy`")
    counts = meliora(given, "check")["counts"]
    expected = {key: int(counts[key]) for key in ("states", "choices", "transitions")}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for wanted in ("explicit", "drn"):
            meliora(given, "export", "--out", name, "--format", wanted)
        meliora(given, "export", "--out", name, "--format", "drn", "--kind", given.kind, "--scheduler", "progress")
        good = same("drn", expected, sizes(stormpy.build_model_from_drn(str(folder / "model.drn"))))
        transitions, labels = for_storm(folder)
        good &= same("tra", expected, sizes(stormpy.build_model_from_explicit(str(transitions), str(labels))))
        chain = stormpy.build_model_from_drn(str(folder / f"{given.kind}-progress.drn"))
        good &= keeps_promise(stormpy, given.kind, chain)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
