"""Writes the docstrings of the compiled module into its type stub.

After a change of docstrings: build the package, then run `python stub_docs.py`.
"""

from __future__ import annotations

import ast
import inspect
import textwrap
from pathlib import Path

from meliora import _native

STUB = Path(__file__).resolve().parent / "lib" / "meliora" / "_native.pyi"


def written(doc: str, indent: str) -> list[str]:
    """Returns the lines of a docstring."""
    end = "\n" if "\n" in doc or doc.endswith('"') else ""
    return textwrap.indent(f'"""{doc}{end}"""', indent).split("\n")


def documented(node: ast.ClassDef | ast.FunctionDef, doc: str | None, lines: list[str]) -> None:
    """Replaces the docstring of a class or function; `lines` after it are not used again."""
    if ast.get_docstring(node, clean=False) is not None:
        old = node.body[0]
        first, last = old.lineno - 1, old.end_lineno or old.lineno
    elif isinstance(node, ast.FunctionDef):
        # The body is `...`, on the line of the result.
        last = node.body[0].lineno
        lines[last - 1] = lines[last - 1].removesuffix(" ...")
        first = last
    else:
        first = last = node.lineno
    lines[first:last] = written(doc, " " * (node.col_offset + 4)) if doc else [" " * (node.col_offset + 4) + "..."]


def stub_with_docs(text: str) -> str:
    """Returns the stub with the docstrings of the module."""
    lines = text.split("\n")
    for node in reversed([node for node in ast.parse(text).body if isinstance(node, ast.ClassDef)]):
        cls = getattr(_native, node.name)
        methods = [method for method in node.body if isinstance(method, ast.FunctionDef)]
        # The first of several signatures has the docstring.
        first = {method.name: method for method in reversed(methods)}
        for method in reversed(methods):
            if not method.name.startswith("_"):
                doc = inspect.getdoc(getattr(cls, method.name)) if first[method.name] is method else None
                documented(method, doc, lines)
        documented(node, inspect.getdoc(cls), lines)
    return "\n".join(lines)


if __name__ == "__main__":
    STUB.write_text(stub_with_docs(STUB.read_text(encoding="utf-8")), encoding="utf-8")
