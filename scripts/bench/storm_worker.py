"""One run of Storm by stormpy, as a process of its own.

usage: storm_worker.py {dd,sparse} {regions,property} MODEL CONSTANTS TEXT

Writes one JSON object per line as soon as a phase is done, so that a run that is stopped keeps what it had. `build` goes
from the model's text to the reachable states. `regions` asks the qualitative questions, such as Pmax>=1 for pmax_one.
Storm computes both regions of Pmax for either question, and both of Pmin: the first one asked pays. Of a Markov chain
only Pmax is asked. `property` computes a value with sound methods. Storm wants the type of a model first: where it
stands later, or is missing (then `mdp`), a copy of the model with the type in front is read.
"""

from __future__ import annotations

import json
import re
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

QUESTIONS = {"pmax_one": "Pmax>=1", "pmin_one": "Pmin>=1", "pmax_positive": "Pmax>0", "pmin_positive": "Pmin>0"}
KIND = re.compile(r"(?<![\w\"])(mdp|nondeterministic|dtmc|probabilistic)\b(?!\")")


def parse(stormpy: Any, model: str) -> tuple[Any, list[Any]]:
    """Returns the program and, of a JANI model, its properties."""
    if model.endswith(".jani"):
        return stormpy.parse_jani_model(model)
    text = re.sub(r"//[^\n]*", "", Path(model).read_text(encoding="utf-8", errors="replace"))
    found = KIND.search(text)
    kind, rest = (found[0], text[: found.start()] + text[found.end() :]) if found else ("mdp", text)
    with tempfile.NamedTemporaryFile("w", suffix=".prism") as copy:
        copy.write(f"{kind}\n{rest}")
        copy.flush()
        return stormpy.parse_prism_program(copy.name, prism_compatibility=True), []


def answer(stormpy: Any, engine: str, kind: str, model: str, constants: str, text: str) -> None:
    """Builds the model, asks the questions and writes the time of each step."""
    start = time.perf_counter()

    def tell(phase: str, **found: Any) -> None:
        nonlocal start
        now = time.perf_counter()
        print(json.dumps({"phase": phase, "seconds": now - start, "found": found}), flush=True)
        start = now

    program, own = parse(stormpy, model)
    texts = {phase: f"{bound} [ F ({text}) ]" for phase, bound in QUESTIONS.items()} if kind == "regions" else {"value": text}
    asked = [p for p in own if p.get_name() == text] or [stormpy.parse_property(t, program) for t in texts.values()]
    program, asked = stormpy.instantiate_constants(program, constants, asked)
    environment = stormpy.Environment()
    environment.dd().sylvan().number_of_threads = 1
    if engine == "dd":
        built = stormpy.build_symbolic_model(program, asked, environment=environment)
    else:
        built = stormpy.build_model(program, asked)
    tell("build", states=built.nr_states)
    environment.solver().force_soundness = kind == "property"
    for phase, question in zip(texts, asked):
        if phase.startswith("pmin") and built.model_type.name == "DTMC":
            continue
        result = stormpy.model_checking(built, question, environment=environment)
        if kind == "regions":
            tell(phase, **{phase: result.count()})
        else:
            values = [result.get_value(state) for state in built.initial_states]
            tell(phase, value=[min(values), max(values)])


def main() -> None:
    import stormpy

    try:
        answer(stormpy, *sys.argv[1:])
    except (RuntimeError, stormpy.exceptions.StormError) as error:
        sys.exit(f"error: {str(error).splitlines()[0]}")


if __name__ == "__main__":
    main()
