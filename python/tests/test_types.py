"""The type stubs: they are correct, and the tests conform to them."""

from __future__ import annotations

import ast
import inspect
import subprocess
import sys
from pathlib import Path

import pytest

from meliora import _native

pytest.importorskip("mypy")
pytest.importorskip("numpy")


def run(*arguments: str) -> None:
    done = subprocess.run([sys.executable, "-m", *arguments], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_stubs_are_what_the_module_has() -> None:
    run("mypy.stubtest", "meliora", "--ignore-disjoint-bases")


def test_stubs_have_the_docstrings_of_the_module() -> None:
    stub = Path(__file__).resolve().parents[1] / "lib" / "meliora" / "_native.pyi"
    for node in ast.parse(stub.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.ClassDef):
            cls = getattr(_native, node.name)
            assert ast.get_docstring(node) == inspect.getdoc(cls), node.name
            methods = [method for method in node.body if isinstance(method, ast.FunctionDef)]
            # The first of several signatures has the docstring.
            first = {method.name: method for method in reversed(methods)}
            for method in first.values():
                if not method.name.startswith("_"):
                    shown = inspect.getdoc(getattr(cls, method.name))
                    advice = f"{node.name}.{method.name}: run `python stub.py`"
                    assert shown and ast.get_docstring(method) == shown, advice


def test_the_package_is_typed() -> None:
    run("mypy", "--strict", "-p", "meliora")


def test_what_programs_do_with_it_is_typed() -> None:
    here = Path(__file__).resolve().parent
    run("mypy", "--strict", str(here), str(here.parent / "examples"))
