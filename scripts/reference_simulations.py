#!/usr/bin/env python3
"""Simulated paths of plans in random models: every path that starts where something is sure achieves an objective.

Each model is simulated from all of its states under random settings. Each path must end because it has achieved the
objective that it pursues. The paths end within the limit of steps, since no branch of these models is
rare.

    reference_simulations.py [--steps 1000000] [--seed 0] [--binary meliora]
"""

import argparse
import random
import sys
import tempfile
from pathlib import Path

import harness
from reference_quantities import Draw
from reference_requirements import report

RUNS, MOST_STEPS = 100, 1_000_000


class Case(Draw):
    """A random model without rare branches, whose states are all initial, under random settings."""

    def __init__(self, seed):
        super().__init__(seed)
        rng = self.random = random.Random(seed + 2_000_003)
        self.commands = [c.replace("99999999/100000000", "9/10").replace("1/100000000", "1/10") for c in self.commands]
        settings = ["--safety", rng.choice(("action", "prefix")), "--engine", rng.choice(("symbolic", "explicit"))]
        self.settings = settings
        self.more = ["--choose", rng.choice(("first", "likely", "cheap")), "--runs", RUNS, "--steps", MOST_STEPS]

    def write(self, folder):
        model, prefs = super().write(folder)
        text = Path(model).read_text()
        Path(model).write_text(text.replace("endmodule", "endmodule\ninit true endinit", 1))
        return model, prefs

    def outcome(self, binary):
        """Returns the paths that were to achieve something, their steps (at least), and what is wrong."""
        paths, steps, wrong = 0, 0, []
        with tempfile.TemporaryDirectory() as folder:
            files = self.write(folder)
            initial = report(binary, "check", *files, *self.settings)["initial"]
            sure = {str(entry["state"]) for entry in initial if entry["most_preferred"]}
            for play in report(binary, "simulate", *files, *self.settings, *self.more)["plays"]:
                if str(play["state"]) not in sure:
                    continue
                paths += RUNS
                steps += max((round(a["mean"] * a["plays"]) for a in play["achieved"]), default=0)
                if play["achieved_runs"] != RUNS:
                    wrong.append(f"{play['state']}: {play['achieved_runs']} of {RUNS} achieve")
        return paths, steps, wrong


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--steps", type=int, default=1_000_000, help="total number of steps")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--binary", help="the command meliora")
    args = parser.parse_args()
    binary, seed, total = harness.find_meliora(args.binary), args.seed, [0, 0, 0]
    while total[1] < args.steps:
        paths, steps, wrong = Case(seed).outcome(binary)
        for text in wrong:
            print(f"seed {seed}: {text}", flush=True)
        seed, total = seed + 1, [total[0] + paths, total[1] + steps, total[2] + len(wrong)]
    print(f"{seed - args.seed} models, {total[0]} paths, at least {total[1]} steps, {total[2]} starts are wrong")
    return int(total[2] > 0)


if __name__ == "__main__":
    sys.exit(main())
