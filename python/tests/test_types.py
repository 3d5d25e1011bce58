"""The type stubs: they are correct, and the tests conform to them."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("mypy")
pytest.importorskip("numpy")


def run(*arguments: str) -> None:
    done = subprocess.run([sys.executable, "-m", *arguments], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_stubs_are_what_the_module_has() -> None:
    run("mypy.stubtest", "meliora", "--ignore-disjoint-bases")


def test_the_package_is_typed() -> None:
    run("mypy", "--strict", "-p", "meliora")


def test_what_programs_do_with_it_is_typed() -> None:
    here = Path(__file__).resolve().parent
    run("mypy", "--strict", str(here), str(here.parent / "examples"))
