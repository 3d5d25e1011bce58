"""Fixtures: models of the repository and their analyses, each computed once."""

from __future__ import annotations

import io
import tarfile
from pathlib import Path
from typing import Literal

import pytest

import meliora

Engine = Literal["symbolic", "explicit"]
ENGINES: tuple[Engine, Engine] = ("symbolic", "explicit")

ROOT = Path(__file__).resolve().parents[2]
MODELS = ROOT / "models"
EXAMPLES = ROOT / "python" / "examples"

#: A model with three actions at s=0: `a` reaches the first objective surely, `b` and `c` a preferred one.
TOY = """mdp
const int last;
module toy
  s : [0..last] init 0;
  lost : bool init false;
  [a] s=0 -> 1/2: (s'=1) + 1/2: (s'=5);
  [b] s=0 -> 1/2: (s'=2) + 1/2: (s'=3);
  [c] s=0 -> 1/2: (s'=3) + 1/2: (s'=4);
  [a] s=5 -> (s'=1);
endmodule
label "middle" = s=2 | s=3;
"""

WISHES = """objective First  = F (s=1 | s=5);
objective Second = F (s=2 | s=4);
objective Third  = F (s=3);
prefer Second, Third > First;
"""


def packed(files: dict[str, bytes]) -> bytes:
    """Returns an archive of files, not compressed."""
    out = io.BytesIO()
    with tarfile.open(fileobj=out, mode="w") as tar:
        for name, content in files.items():
            entry = tarfile.TarInfo(name)
            entry.size = len(content)
            tar.addfile(entry, io.BytesIO(content))
    return out.getvalue()


@pytest.fixture(scope="session", params=ENGINES)
def engine(request: pytest.FixtureRequest) -> Engine:
    found: Engine = request.param
    return found


@pytest.fixture(scope="session")
def robot() -> meliora.Model:
    return meliora.Model.from_file(MODELS / "robot5x5.prism")


@pytest.fixture(scope="session")
def wishes() -> meliora.Preferences:
    return meliora.Preferences.from_file(MODELS / "robot5x5.pref")


@pytest.fixture(scope="session")
def found(robot: meliora.Model, wishes: meliora.Preferences, engine: Engine) -> meliora.Analysis:
    """The robot, analysed as in the paper."""
    return robot.check(wishes, scope="all", safety="transition", engine=engine)


@pytest.fixture(scope="session")
def toy() -> meliora.Model:
    return meliora.Model.from_string(TOY, constants={"last": 5})


@pytest.fixture(scope="session")
def toy_wishes() -> meliora.Preferences:
    return meliora.Preferences.from_string(WISHES)


@pytest.fixture(scope="session")
def endless() -> meliora.Model:
    """A model that neither engine explores in the time of a test: four counters with random jumps."""
    lines = ["mdp"]
    for i, prime in enumerate([59999, 59981, 59971, 59957]):
        jumps = [f"0.5: (x{i}'=mod(x{i}*{factor}+{i}, {prime}))" for factor in (7919, 7907)]
        lines.append(f"module m{i}\n  x{i} : [0..{prime - 1}] init {i};\n  [t] true -> {' + '.join(jumps)};\nendmodule")
    return meliora.Model.from_string("\n".join(lines), name="endless")
