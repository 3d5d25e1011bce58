"""The examples, run without changes."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
from pathlib import Path

import pytest

from conftest import EXAMPLES

NEEDS = {"heat_map.py": ["numpy", "matplotlib"], "masked_environment.py": ["numpy"]}


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
    else:
        assert "2 improvements or more in all of 200 plays" in done.stdout
