#!/usr/bin/env python3
"""One run of Storm, as a process of its own; `compare_peers.py` starts it.

usage: storm_worker.py {dd,sparse} THREADS MODEL CONSTANTS TARGET

Writes one JSON object a line as soon as a phase is done, so that a run that is stopped keeps what it had.
build: from the model's text to the reachable states. The other phases are the qualitative questions, such as
Pmax>=1 for pmax_one. Storm computes both regions of Pmax for either question, and both of Pmin; the first one
asked pays, the second finds most of it in the operation cache. Of a Markov chain only Pmax is asked. Storm wants
the type of a model first: where it stands later, or is missing (then `mdp`), a copy of the model with the type in
front is read.
"""

from __future__ import annotations

import json
import re
import resource
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

QUESTIONS = {"pmax_one": "Pmax>=1", "pmin_one": "Pmin>=1", "pmax_positive": "Pmax>0", "pmin_positive": "Pmin>0"}
COMMENT = re.compile(r"//[^\n]*")
KIND = re.compile(r"(?<![\w\"])(mdp|nondeterministic|dtmc|probabilistic)\b(?!\")")


def cpu_seconds() -> float:
    """The CPU seconds of this process in user mode."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_utime


def tell(phase: str, seconds: float, **counts: int) -> None:
    """Writes the time and the results of a phase."""
    print(json.dumps({"phase": phase, "seconds": seconds, "counts": counts}), flush=True)


def single(stormpy: Any, threads: int) -> Any:
    """Returns an environment whose decision diagrams use this number of threads."""
    environment = stormpy.Environment()
    environment.dd().sylvan().number_of_threads = threads
    return environment


def parse(stormpy: Any, model: str) -> Any:
    """Returns the program, with its type moved to the front if necessary; or a JANI model."""
    if model.endswith(".jani"):
        return stormpy.parse_jani_model(model)[0]
    text = COMMENT.sub("", Path(model).read_text(encoding="utf-8", errors="replace"))
    found = KIND.search(text)
    if found and not text[: found.start()].strip():
        return stormpy.parse_prism_program(model, prism_compatibility=True)
    kind = found[0] if found else "mdp"
    rest = text[: found.start()] + text[found.end() :] if found else text
    with tempfile.NamedTemporaryFile("w", suffix=".prism") as copy:
        copy.write(f"{kind}\n{rest}")
        copy.flush()
        return stormpy.parse_prism_program(copy.name, prism_compatibility=True)


def build(stormpy: Any, engine: str, threads: int, model: str, constants: str, target: str) -> tuple[Any, dict[str, Any]]:
    """The model and the questions about it."""
    program = parse(stormpy, model)
    asked = [stormpy.parse_property(f"{bound} [ F ({target}) ]", program) for bound in QUESTIONS.values()]
    program, asked = stormpy.instantiate_constants(program, constants, asked)
    if engine == "dd":
        built = stormpy.build_symbolic_model(program, asked, environment=single(stormpy, threads))
    else:
        built = stormpy.build_model(program, asked)
    return built, dict(zip(QUESTIONS, asked))


def answer(stormpy: Any, engine: str, threads: int, model: str, constants: str, target: str) -> None:
    """Builds the model, asks the questions and writes the time of each step."""
    start = time.perf_counter()
    built, questions = build(stormpy, engine, threads, model, constants, target)
    tell("build", time.perf_counter() - start, states=built.nr_states)
    chain = built.model_type.name == "DTMC"
    for phase, question in questions.items():
        if chain and phase.startswith("pmin"):
            continue
        start = time.perf_counter()
        result = stormpy.model_checking(built, question)
        tell(phase, time.perf_counter() - start, **{phase: result.count()})


def main() -> None:
    engine, threads, *question = sys.argv[1:]
    import stormpy

    try:
        answer(stormpy, engine, int(threads), *question)
    except (RuntimeError, stormpy.exceptions.StormError) as error:
        sys.exit(f"error: {str(error).splitlines()[0]}")


if __name__ == "__main__":
    main()
