"""The examples, run without changes."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
from pathlib import Path

import pytest

from conftest import EXAMPLES

NEEDS = {
    "heat_map.py": ["numpy", "matplotlib"],
    "masked_environment.py": ["numpy"],
    **dict.fromkeys(["frozen_lake.py", "taxi.py", "cliff_walking.py"], ["numpy", "gymnasium"]),
}
MASKS = {
    "frozen_lake.py": "[False  True False False]",
    "cliff_walking.py": "[ True False False False]",
    "taxi.py": "[ True  True  True  True  True False]",
}


@pytest.mark.parametrize("example", sorted(path.name for path in EXAMPLES.glob("*.py")))
def test_example(example: str, tmp_path: Path) -> None:
    for package in NEEDS.get(example, []):
        if importlib.util.find_spec(package) is None:
            pytest.skip(f"{example} needs {package}")
    arguments = [str(tmp_path / "map.png")] if example == "heat_map.py" else []
    done = subprocess.run([sys.executable, str(EXAMPLES / example), *arguments], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    if example == "robot.py":
        assert done.stdout.split("\n")[:2] == ["768 98", "1946 1477 1165 1010 1004"]
    elif example == "heat_map.py":
        assert (tmp_path / "map.png").read_bytes().startswith(b"\x89PNG")
    elif example in MASKS:
        assert done.stdout.strip() == MASKS[example]
    elif example == "minigrid_shield.py":
        without, shielded = done.stdout.strip().split("\n")
        assert shielded.startswith("with shield: 0 of 20000 steps weaken, ") and " 0 improve" not in shielded
        assert not without.startswith("without shield: 0 ")
    else:
        assert "At least 1 in each of 200 plays: improvements" in done.stdout
