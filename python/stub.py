"""Writes the type stub of the compiled module: `python stub.py`; with `--check`, fails if it is stale.

PyO3 knows the classes, the signatures, the docstrings and the types that Rust has; `maturin generate-stubs` writes them.
This adds the types that Rust does not say, and signatures that depend on an argument.
"""

from __future__ import annotations

import ast
import copy
import inspect
import re
import subprocess
import sys
import tempfile
import textwrap
from pathlib import Path

HERE = Path(__file__).resolve().parent
STUB = HERE / "lib" / "meliora" / "_native.pyi"

HEAD = '''"""Types and docstrings of the compiled part, written by `python/stub.py`."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from os import PathLike
from typing import Any, Final, Literal, final, overload

import numpy as np
from numpy.typing import NDArray
from typing_extensions import TypeAlias

from ._answers import Answer
from .reports import (
    CheckReport,
    CompareReport,
    PolicyReport,
    SimulatePlaysCommits,
    SimulatePlaysValue,
    StrategyStatesAttains,
    ValuesStates,
)

_Value: TypeAlias = bool | int | str
_State: TypeAlias = Mapping[str, _Value]
_ShieldState: TypeAlias = Mapping[str, _Value] | Sequence[_Value] | NDArray[Any] | int
_Path: TypeAlias = str | PathLike[str]
_Rank: TypeAlias = int | float
_Timeout: TypeAlias = float | str
_Scope: TypeAlias = Literal["reachable", "all"]
_Storage: TypeAlias = Literal["symbolic", "explicit"]
_Engine: TypeAlias = Literal["auto", "symbolic", "explicit"]
_Safety: TypeAlias = Literal["action", "transition", "prefix"]
_StrategyKind: TypeAlias = Literal["sasi", "spi", "plan", "achieve"]
_Order: TypeAlias = Literal["auto", "declared"] | Sequence[str]
_Choose: TypeAlias = Literal["first", "likely", "cheap"]
_Which: TypeAlias = Literal["permitted", "progress", "chosen", "kept"]
_Empty: TypeAlias = Literal["bottom", "gain", "incomparable"]
_Constants: TypeAlias = dict[str, bool | int | float | Fraction]
_Bounds: TypeAlias = dict[str, tuple[int, int]]
_Successors: TypeAlias = dict[str, list[tuple[float, dict[str, Any]]]]
#: A dictionary as Gymnasium's `P`, an array, or one matrix per action; scipy has no types.
_Transitions: TypeAlias = Any
_States: TypeAlias = int | str | Iterable[Any] | NDArray[Any]
_Progress: TypeAlias = Callable[[Progress], object]
'''

#: Types of numbers, lists and paths as PyO3 writes them, and as this package means them.
REPLACED = [
    (r"SupportsFloat \| SupportsIndex", "float"),
    (r"SupportsIndex", "int"),
    (r"SupportsGetItem\[int, ", "Sequence["),
    (r"str \| PathLike\[str\]", "_Path"),
]

#: The types of arguments: of all methods, of those of a class, or of one method.
ARGUMENTS = {
    "bounds": "_Bounds | None", "choose": "_Choose", "constants": "_Constants | None", "engine": "_Engine",
    "memory": "int | str | None", "order": "_Order | None", "preferences": "Preferences | _Path",
    "progress": "_Progress | None", "safety": "_Safety", "scope": "_Scope", "state": "_State",
    "states": "Sequence[_State] | None", "timeout": "_Timeout | None", "values": "_Value", "where": "_State | None",
    "which": "_Which",
    "Analysis.explicit_files.format": 'Literal["explicit", "drn", "umb"]', "Analysis.kind": "_StrategyKind | None", "Dump.where": "str | None",
    "Exploration.condition": "str | _State | None", "Exploration.target": "Region | str | _State",
    "Levels.index": "int | slice", "Model._restore.archive": "bytes | None", "Model._restore.bounds": "str",
    "Model._restore.constants": "str", "Model._restore.rewards": "Sequence[Any]",
    "Model.from_transitions.actions": "Sequence[str] | None",
    "Model.from_transitions.states": "Sequence[Any] | None", "Model.labels": "Mapping[str, _States] | None",
    "Model.players": "str | int", "Model.policy": "_Path | dict[str, Any] | list[Any]",
    "Model.ask.policy": "bool", "Model.ask.opponent_policy": "bool", "Model.simulate_policy.preferences": "Preferences | _Path | None",
    "Model.verify_policy.preferences": "Preferences | _Path | None", "Model.rewards": "Mapping[str, Any] | None", "Model.source": "_Path | bytes",
    "Model.start": "_States | None", "Model.transitions": "_Transitions", "Preferences.empty": "_Empty",
    "Preferences.history": 'Literal["state", "play"] | None', "Preferences.objectives": "dict[str, str]",
    "Preferences.prefer": "Sequence[str | tuple[str, str]] | None", "Preferences.require": "Sequence[str] | None",
    "Region.__and__.other": "Region", "Region.__or__.other": "Region", "Region.__sub__.other": "Region",
    "Region.__xor__.other": "Region", "Region.__le__.other": "Region", "Region.__lt__.other": "Region",
    "Region.__ge__.other": "Region", "Region.__gt__.other": "Region", "Shield.action": "str | int",
    "Shield.memory": "Sequence[int] | NDArray[Any] | None", "Shield.state": "_ShieldState",
    "_Rows.constants": "Sequence[tuple[str, Sequence[str]]]",
    "Shield.states": "Iterable[_ShieldState] | NDArray[Any]", "Strategy.opponent": 'Literal["random", "worst"]',
    "Strategy.picks": 'Literal["permissive", "progress"]',
}  # fmt: skip

#: The types of results and attributes: of all classes, or of one.
RESULTS = {
    "__eq__": "bool", "__ge__": "bool", "__gt__": "bool", "__le__": "bool", "__lt__": "bool", "__ne__": "bool",
    "__next__": "dict[str, Any]", "__reduce__": "tuple[Any, ...]",
    "action_names": "list[str]", "ahead": "_Rank", "allowed": "tuple[str, ...]",
    "almost_sure": "dict[str, Region]", "attains": "StrategyStatesAttains | None",
    "change": 'Literal["improving", "weakening", "lateral"]', "checked": "tuple[str, ...]", "choose": "_Choose",
    "classes": "dict[tuple[str, ...], Region]", "coalition": "tuple[str, ...]",
    "compare": 'Literal[">", "<", "~"] | None', "constants": "dict[str, bool | int | float]",
    "empty": "_Empty", "engine": "_Storage", "exploration": "Exploration",
    "gained": "tuple[str, ...]", "history": 'Literal["state", "play"]', "improves": "NDArray[np.bool_]",
    "jointly": "dict[tuple[str, ...], dict[tuple[str, ...], Region]]", "kind": "_StrategyKind", "labels": "list[str]",
    "left": "tuple[str, ...]", "lengths": "NDArray[np.int64]", "lost": "tuple[str, ...]",
    "manifest": "dict[str, Any]", "mask": "NDArray[np.bool_]", "masks": "NDArray[np.bool_]", "model": "Model",
    "most_preferred": "tuple[str, ...]", "moves": "dict[str, int]", "objectives": "dict[str, str]",
    "order": "list[str] | None", "players": "tuple[str, ...]", "positive": "dict[str, Region]", "rank": "_Rank",
    "requirements": "tuple[str, ...]", "safety": "_Safety", "sample": "list[dict[str, Any]]", "scope": "_Scope",
    "state": "dict[str, Any]", "states": "list[dict[str, Any]]", "successors": "_Successors",
    "to_dict": "CheckReport", "verify_policy": "PolicyReport", "simulate_policy": "PolicyReport", "policy": "dict[str, Any]", "type": 'Literal["int", "bool"]', "uncertified": "tuple[str, ...]",
    "usage": "dict[str, int]",
    "Action.successors": "tuple[Successor, ...]", "Analysis.counts": "dict[str, int] | None",
    "Analysis.improvement": "dict[str, int] | None", "Analysis.target": "dict[str, Region]",
    "Analysis.values": "list[ValuesStates]", "Dump.actions": "tuple[str, ...]", "Dump.regions": "tuple[str, ...]",
    "Explanation.achieved": "tuple[str, ...]", "Explanation.actions": "tuple[Action, ...]",
    "Exploration.counts": "dict[str, int]", "Exploration.players": "dict[str, Region]",
    "Exploration.states": "Region", "Levels.__iter__": "Iterator[Region]", "Levels.kind": 'Literal["sasi", "spi"]',
    "Levels.regions": "tuple[Region, ...]", "Levels.to_numpy": "NDArray[np.float64]", "Model.actions": "list[str]", "Model.compare": "CompareReport",
    "Model.kind": 'Literal["mdp", "dtmc", "smg"]', "Model.variables": "dict[str, Variable]",
    "Region.to_numpy": "NDArray[np.bool_]", "Shield.kind": '_StrategyKind | Literal["safety"]',
    "Shield.pursues": "tuple[str, ...]", "Shield.rule": "dict[str, Any] | None",
    "Shield.safety": 'Literal["action", "prefix"]', "Shield.values": "dict[str, tuple[float, float]]",
    "Simulation.achieved": "dict[str, NDArray[np.int64]]",
    "Simulation.actions": "NDArray[np.int64]", "Simulation.commits": "list[SimulatePlaysCommits]",
    "Simulation.improvements": "dict[int, int]", "Simulation.states": "NDArray[np.int64]",
    "Simulation.value": "SimulatePlaysValue | None", "Simulation.variables": "list[str]",
    "Variable.initial": "_Value | None", "Verdict.state": "dict[str, Any] | None",
}  # fmt: skip

#: The signatures of methods whose result depends on an argument: other types of arguments, and the result.
OVERLOADS = {
    "Levels.__getitem__": [({"index": "int"}, "Region"), ({"index": "slice"}, "tuple[Region, ...]")],
    "Model.ask": [
        ({"properties": "str", "file": "None", "constants": "None", "only": "None"}, "Answer"),
        ({"properties": "list[str] | tuple[str, ...]", "file": "None", "constants": "None", "only": "None"}, "list[Answer]"),
        ({"properties": "None"}, "Any"),
    ],
    "Shield.correct": [({"action": "str"}, "str"), ({"action": "int"}, "int")],
}

#: Binary operators, which Python may call on their right side.
BINARY = ("__and__", "__or__", "__sub__", "__xor__")

#: The names of the tables that no class has used yet.
UNUSED: dict[int, set[str | None]] = {id(types): set(types) for types in (ARGUMENTS, RESULTS)}


def plain(annotation: ast.expr) -> ast.expr:
    """Returns an annotation in our words."""
    text = ast.unparse(annotation)
    for written, meant in REPLACED:
        text = re.sub(written, meant, text)
    return parsed(text)


def parsed(text: str) -> ast.expr:
    return ast.parse(text, mode="eval").body


def known(types: dict[str, str], *names: str) -> str | None:
    """Returns the type with the first of these names."""
    found = next((name for name in names if name in types), None)
    UNUSED[id(types)].discard(found)
    return None if found is None else types[found]


def typed(function: ast.FunctionDef, cls: str) -> ast.FunctionDef:
    """Returns a function with its types."""
    given, name = function.args, f"{cls}.{function.name}"
    for argument in [*given.posonlyargs, *given.args, *given.kwonlyargs, given.vararg, given.kwarg]:
        if argument is not None and argument.arg not in ("self", "cls"):
            own = argument.arg
            type_ = known(ARGUMENTS, f"{name}.{own}", f"{cls}.{own}", own)
            argument.annotation = parsed(type_) if type_ else argument.annotation and plain(argument.annotation)
    # `self` is positional anyway; stubs leave the mark out.
    if [argument.arg for argument in given.posonlyargs] in (["self"], ["cls"]):
        given.args, given.posonlyargs = [*given.posonlyargs, *given.args], []
    type_ = known(RESULTS, name, function.name)
    if function.returns is not None:
        function.returns = parsed(type_) if type_ else plain(function.returns)
    return function


def overloaded(function: ast.FunctionDef, arguments: dict[str, str], result: str) -> ast.FunctionDef:
    """Returns one of several signatures of a function."""
    function = copy.deepcopy(function)
    function.decorator_list.insert(0, ast.Name("overload"))
    function.returns = parsed(result)
    for argument in [*function.args.posonlyargs, *function.args.args, *function.args.kwonlyargs]:
        if argument.arg in arguments:
            argument.annotation = parsed(arguments[argument.arg])
    if "None" not in arguments.get("properties", "None"):
        function.args.defaults = []
    return function


def written(node: ast.FunctionDef | ast.ClassDef, indent: str, with_doc: bool = True) -> str:
    """Returns the text of a function, or the head of a class, with its docstring."""
    doc = inspect.cleandoc(ast.get_docstring(node) or "") if with_doc else ""
    head = copy.copy(node)
    head.body = [ast.Expr(ast.Constant(...))]
    text = textwrap.indent(ast.unparse(head).removesuffix("...").rstrip(), indent)
    if not doc:
        return text + ("" if isinstance(node, ast.ClassDef) else " ...") + "\n"
    end = "\n" if doc.endswith('"') else ""
    return f"{text}\n" + textwrap.indent(f'"""{doc}{end}"""', indent + "    ") + "\n"


def functions(function: ast.FunctionDef, cls: str, indent: str) -> str:
    """Returns the text of a function with all its signatures."""
    function = typed(function, cls)
    several = OVERLOADS.get(f"{cls}.{function.name}")
    if several is None:
        return written(function, indent)
    all_ = [overloaded(function, *one) for one in several]
    return "".join(written(one, indent, with_doc=one is all_[0]) for one in all_)


def stub(generated: str) -> str:
    """Returns the stub for what PyO3 has written."""
    text = HEAD
    for node in ast.parse(generated).body:
        if isinstance(node, ast.FunctionDef):
            text += "\n" + functions(node, "", "")
        elif isinstance(node, ast.ClassDef):
            text += "\n" + written(node, "")
            for member in node.body:
                if isinstance(member, ast.FunctionDef) and member.name not in ("__repr__", "__str__"):
                    text += functions(member, node.name, "    ")
                    if member.name in BINARY:
                        member.name = member.name.replace("__", "__r", 1)
                        text += written(member, "    ")
        elif isinstance(node, (ast.Assign, ast.AnnAssign)):
            text += "\n" + ast.unparse(node) + "\n"
    return text


def main() -> None:
    with tempfile.TemporaryDirectory() as out:
        command = ["-m", "maturin", "generate-stubs", "--locked", "--quiet", "--features", "stub", "--out", out]
        subprocess.run([sys.executable, *command], cwd=HERE, check=True)
        text = stub((Path(out) / "meliora" / "_native.pyi").read_text(encoding="utf-8"))
    unused = sorted(str(name) for names in UNUSED.values() for name in names)
    if unused:
        sys.exit(f"no class has {', '.join(unused)}: remove them from the tables of stub.py")
    if "--check" not in sys.argv:
        STUB.write_text(text, encoding="utf-8")
    elif text != STUB.read_text(encoding="utf-8"):
        sys.exit(f"{STUB} is stale: run `python stub.py`")


if __name__ == "__main__":
    main()
