"""The notebooks: without outputs in the repository, and executed without changes."""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import EXAMPLES

NOTEBOOKS = sorted(EXAMPLES.glob("*.ipynb"))
NEEDS = ["nbconvert", "ipykernel", "matplotlib", "pandas", "numpy"]


def test_there_are_four_notebooks() -> None:
    assert [path.stem for path in NOTEBOOKS] == ["first_steps", "from_arrays", "shield", "sweep"]


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_has_no_outputs(notebook: Path) -> None:
    cells = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
    code = [cell for cell in cells if cell["cell_type"] == "code"]
    assert code and all(cell["outputs"] == [] and cell["execution_count"] is None for cell in code)


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs(notebook: Path, tmp_path: Path) -> None:
    missing = [package for package in NEEDS if importlib.util.find_spec(package) is None]
    if missing:
        pytest.skip(f"notebooks need {', '.join(missing)}")
    command = [sys.executable, "-m", "nbconvert", "--to", "notebook", "--execute", "--output-dir", str(tmp_path)]
    done = subprocess.run([*command, str(notebook)], cwd=EXAMPLES, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    cells = json.loads((tmp_path / notebook.name).read_text(encoding="utf-8"))["cells"]
    assert any(cell.get("outputs") for cell in cells)
