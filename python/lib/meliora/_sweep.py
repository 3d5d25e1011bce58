"""Sweeps over constants: one analysis and one row per combination of values, in this process or as tasks of Dask.

The rows and their file are those of ``meliora check --csv``; the compiled part makes them.
"""

from __future__ import annotations

import importlib
import itertools
import math
import time
import uuid
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import CancelledError
from dataclasses import dataclass, replace
from fractions import Fraction
from os import PathLike
from typing import Any, Literal, Union

from ._native import Model, Preferences, _Columns, _Rows
from .errors import InputError, LimitError, UsageError

_Value = Union[bool, int, float, Fraction]
_Path = Union[str, "PathLike[str]"]
#: The cells of a row after those of the constants, and the reason of a limit or an error.
_Outcome = tuple[list[str], Union[str, None]]

#: The cells that are not numbers.
_WORDS: dict[str, Any] = {"": None, "true": True, "false": False, "unbounded": math.inf}
#: Maximum number of values of a constant; more are taken for a mistake.
_MOST_VALUES = 1_000_000
#: The model is wrong if it cannot be read with the constants of any of this number of instances.
_MOST_TRIED = 100


def sweep(
    model: _Path,
    preferences: Preferences | _Path | None = None,
    *,
    properties: Sequence[str] | Mapping[str, str] | None = None,
    client: Any = None,
    csv: _Path | None = None,
    resume: bool = False,
    constants: Mapping[str, Any] | None = None,
    bounds: dict[str, tuple[int, int]] | None = None,
    scope: Literal["reachable", "all"] = "reachable",
    safety: Literal["action", "transition", "prefix"] = "prefix",
    engine: Literal["auto", "symbolic", "explicit"] = "auto",
    max_level: int | None = None,
    coalition: Sequence[str | int] | None = None,
    memory: int | str | None = None,
    timeout: float | str | None = None,
    **values: Any,
) -> Any:
    """Analyses a model for every combination of values of its constants, as ``meliora check -c N=2:10``; or answers
    properties for each of them, as ``meliora reach -c N=2:10``.

        >>> meliora.sweep("models/chain.prism", "models/chain.pref", N=range(2, 11, 2))
        >>> meliora.sweep("models/chain.prism", properties=["Pmax=? [ F x=N ]", "P>=1 [ F x=N ]"], N=range(2, 11, 2))

    Each combination is one instance, and each instance is one row. A limit or an error ends only its instance.

    Args:
        model: The path of a model, or its text: a string with a line break is a text.
        preferences: A Preferences, or a path or text likewise; None with `properties`.
        properties: Properties as in ``Exploration.reach``, or a dictionary of properties by the names of their
            columns. A cell has the verdict, or the value: one number, or ``lower..upper`` where the bounds differ. With
            a list of one property, the file also has the sizes of its regions, as that of a single ``--property``.
            `safety` and `max_level` have no meaning for properties.
        client: A ``distributed.Client``: each instance is a task of Dask, and the instances of a lost worker run
            again on others. The workers need this package but no files. None to run the instances in this process.
        csv: A file for the rows, each written as soon as its instance ends; the format is that of the command line.
        resume: Skips the instances that have a row in the file, whatever their status; cuts off an incomplete last
            row.
        constants: Values of constants whose names are also arguments, such as ``{"timeout": [1, 2]}``.
        bounds: As in ``Model.from_file``.
        scope, safety, engine, max_level: As in ``Model.check``.
        coalition: The players of a game that we are, as in ``Model.with_coalition``.
        memory: As in ``Model.check``, for each instance. On workers with a memory limit, the default is half of that,
            divided by the number of their threads.
        timeout: Limit for each of the two parts of an instance: reading the model, and its analysis.
        values: The values of each constant: a bool, int, float or ``fractions.Fraction``, or a range, a list or another
            iterable of them.
            The last constant varies fastest.

    Returns:
        A ``pandas.DataFrame`` if pandas is installed, else a list of dictionaries: the columns of the file that have
        a value in some row, and ``reason``, the message of a limit or an error, which is unknown for rows that were in
        the file. (The file has all columns, because it is written before the results are known.)
        ``peak_rss_bytes`` is the largest size of the process so far.

    Raises:
        InputError: The preferences or the model are invalid, or a constant is unknown. Nothing runs then. The model
            is invalid if it is for each of the first 100 instances.
        UsageError: Arguments are inconsistent, or the file belongs to another sweep.
        OSError: A file cannot be read or written.
    """
    named = _constants(constants, values)
    options = {"scope": scope, "safety": safety, "engine": engine, "max_level": max_level, "timeout": timeout}
    asked = _asked(preferences, properties, options)
    _check_options(options, memory)
    columns = _Columns(max_level, list(asked), len(asked) == 1 and not isinstance(properties, Mapping))
    rows = _Rows([(name, list(map(cell_of, given))) for name, given in named.items()], columns)
    found = _first_readable(model, bounds, timeout, named)
    if coalition is not None:
        found.with_coalition(*coalition)
    wishes = None if preferences is None else _preferences(preferences)
    job = _Job(found.text, found.name, bounds, wishes, options, coalition, memory, asked, columns)
    paths = [given for given in (model, preferences) if given is not None and not isinstance(given, Preferences)]
    if csv is not None:
        rows.open(csv, resume, [given for given in paths if not _is_text(given)])
    elif resume:
        raise UsageError("resume=True needs `csv`, the file of the sweep")
    reasons: dict[int, str | None] = {}
    missing = set(rows.missing())
    todo = {position: instance for position, instance in enumerate(_instances(named)) if position in missing}
    try:
        for position, (cells, reason) in _outcomes(client, job, todo):
            rows.add(position, cells)
            reasons[position] = reason
    finally:
        rows.finish()
    return _table(rows, reasons)


@dataclass(frozen=True)
class _Job:
    """The common part of all instances, which needs no file."""

    model: str
    name: str
    bounds: dict[str, tuple[int, int]] | None
    preferences: Preferences | None
    options: dict[str, Any]
    coalition: Sequence[str | int] | None
    memory: int | str | None
    #: The properties by the names of their columns; empty for an analysis of the preferences.
    properties: dict[str, str]
    columns: _Columns


def _outcomes(client: Any, job: _Job, todo: dict[int, dict[str, _Value]]) -> Iterator[tuple[int, _Outcome]]:
    """Runs instances. Returns the position and the outcome of each as soon as it ends."""
    if client is not None:
        return _on_dask(client, job, todo)
    return ((position, _analyse(instance, job)) for position, instance in todo.items())


def _on_dask(client: Any, job: _Job, todo: dict[int, dict[str, _Value]]) -> Iterator[tuple[int, _Outcome]]:
    distributed = importlib.import_module("distributed")
    sweep_id = uuid.uuid4().hex[:8]
    names = (",".join(f"{name}={cell_of(value)}" for name, value in instance.items()) for instance in todo.values())
    keys = {f"meliora-instance-{sweep_id}-{name}": position for name, position in zip(names, todo)}
    # A task, so that its result is computed again if the only worker that has it is lost.
    shared = client.submit(_same, job, key=f"meliora-job-{sweep_id}")
    # An instance returns its errors in its outcome, so there is nothing to retry.
    tasks = client.map(_analyse_on_worker, list(todo.values()), job=shared, key=list(keys))
    running = {task.key: task for task in tasks}
    lost: list[str] = []
    try:
        for task in distributed.as_completed(tasks):
            if isinstance(task.exception(), distributed.KilledWorker):
                lost.append(task.key)
            else:
                yield keys[task.key], _result(task, job)
            # Results that are kept would be computed again if their worker were lost.
            running.pop(task.key).release()
        # Dask blames all instances that were assigned to lost workers. The one at fault loses more of them when alone.
        for key in lost:
            again = client.submit(_analyse_on_worker, todo[keys[key]], job=shared, key=f"{key}-again")
            yield keys[key], _result(again, job)
    finally:
        client.cancel([shared, *running.values()])


def _result(task: Any, job: _Job) -> _Outcome:
    """Returns the outcome of a task. If it has none, because each worker that ran it was lost, this is an error."""
    try:
        outcome: _Outcome = task.result()
        return outcome
    except CancelledError:
        # The caller, or the end of the scheduler, has cancelled the sweep.
        raise
    except Exception as error:
        return job.columns.cells(None, 0, "error"), f"{type(error).__name__}: {error}"


def _same(job: _Job) -> _Job:
    return job


def _analyse_on_worker(constants: dict[str, _Value], job: _Job) -> _Outcome:
    return _analyse(constants, job if job.memory is not None else replace(job, memory=_memory_of_thread()))


def _memory_of_thread() -> int | None:
    """Returns the memory for an instance on this worker of Dask: half of its limit, divided by its threads."""
    worker = importlib.import_module("distributed").get_worker()
    limit: int | None = worker.memory_manager.memory_limit
    return limit // 2 // worker.state.nthreads if limit else None


def _analyse(constants: dict[str, _Value], job: _Job) -> _Outcome:
    """Runs one instance."""
    begin = time.perf_counter()
    found: Any = None
    status, reason = "done", None
    try:
        timeout = job.options["timeout"]
        model = Model.from_string(job.model, name=job.name, constants=constants, bounds=job.bounds, timeout=timeout)
        if job.coalition is not None:
            model = model.with_coalition(*job.coalition)
        if job.preferences is None:
            options = {name: job.options[name] for name in ("scope", "engine", "timeout")}
            found = model._answers(list(job.properties.values()), memory=job.memory, **options)
            reason = found.reason(list(job.properties))
        else:
            found = model.check(job.preferences, memory=job.memory, **job.options)
    except LimitError as error:
        found = (error.known or {}).get("answers") if job.preferences is None else error.analysis
        status, reason = "limit", str(error)
    except Exception as error:
        status, reason = "error", str(error)
    return job.columns.cells(found, time.perf_counter() - begin, status), reason


def _asked(preferences: Any, properties: Any, options: dict[str, Any]) -> dict[str, str]:
    """Returns the properties by the names of their columns."""
    if (preferences is None) == (properties is None):
        raise UsageError("a sweep needs either preferences or `properties`")
    if properties is None:
        return {}
    if isinstance(properties, str):
        raise UsageError("`properties` is a list of properties, or a dictionary by the names of their columns")
    named = dict(properties) if isinstance(properties, Mapping) else {text: text for text in properties}
    if not named:
        raise UsageError("there are no properties")
    for name, text in named.items():
        if not isinstance(name, str) or not isinstance(text, str):
            raise UsageError(f"a property is a text, not {text!r}")
    if options["safety"] != "prefix" or options["max_level"] is not None:
        raise UsageError("`safety` and `max_level` belong to preferences; properties have none")
    return named


def _table(rows: _Rows, reasons: dict[int, str | None]) -> Any:
    header, known = rows.header, rows.rows()
    # A column without a value in any row says nothing.
    used = [at for at in range(len(header)) if any(row[at] for _, row in known)]
    columns = [*(header[at] for at in used), "reason"]
    cells = ([*(value_of(row[at]) for at in used), reasons.get(position)] for position, row in known)
    records = [dict(zip(columns, row)) for row in cells]
    try:
        pandas = importlib.import_module("pandas")
    except ImportError:
        return records
    # As objects first: numbers of states can be larger than the numbers that a float represents.
    return pandas.DataFrame(records, columns=columns, dtype=object).convert_dtypes()


def _constants(more: Mapping[str, Any] | None, values: dict[str, Any]) -> dict[str, list[_Value]]:
    """Returns the values of each constant, without repetitions."""
    both = sorted(set(more or {}) & set(values))
    if both:
        raise UsageError(f"`{both[0]}` has values in `constants` and as an argument")
    return {name: _values(name, given) for name, given in {**(more or {}), **values}.items()}


def _instances(named: dict[str, list[_Value]]) -> Iterator[dict[str, _Value]]:
    """Returns the instances in their order: the last constant varies fastest."""
    return (dict(zip(named, combination)) for combination in itertools.product(*named.values()))


def _values(name: str, given: Any) -> list[_Value]:
    several = isinstance(given, Iterable) and not isinstance(given, (str, bytes)) and getattr(given, "ndim", 1) > 0
    # One more than there may be, so that too many are noticed without a list of them.
    listed = itertools.islice(given, _MOST_VALUES + 1) if several else [given]
    # The numbers of NumPy have `item`.
    values = [value.item() if hasattr(value, "item") else value for value in listed]
    if len(values) > _MOST_VALUES:
        raise UsageError(f"`{name}` has over {_MOST_VALUES} values: a sweep has at most that number of instances")
    for value in values:
        if not isinstance(value, (bool, int, float, Fraction)):
            raise UsageError(f"constants are bools, ints, floats and fractions: `{name}` is {value!r}")
    if not values:
        raise UsageError(f"there are no values for `{name}`")
    return list({cell_of(value): value for value in values}.values())


def _is_text(given: Any) -> bool:
    return isinstance(given, str) and "\n" in given


def _preferences(given: Preferences | _Path) -> Preferences:
    if isinstance(given, Preferences):
        return given
    return Preferences.from_string(str(given)) if _is_text(given) else Preferences.from_file(given)


def _first_readable(
    given: _Path, bounds: dict[str, tuple[int, int]] | None, timeout: Any, named: dict[str, list[_Value]]
) -> Model:
    """Reads the model for the first instance for which it is valid."""
    read: Any = Model.from_string if _is_text(given) else Model.from_file
    wrong: InputError | None = None
    for constants in itertools.islice(_instances(named), _MOST_TRIED):
        try:
            model: Model = read(given, constants=constants, bounds=bounds, timeout=timeout)
            return model
        except InputError as error:
            wrong = wrong or error
    assert wrong is not None
    raise wrong


def _check_options(options: dict[str, Any], memory: int | str | None) -> None:
    """Refuses wrong options before instances run: checks a model of one state with them."""
    smallest = Model.from_string("mdp\nmodule m\n x : [0..0];\n [] true -> true;\nendmodule\n")
    try:
        smallest.check(Preferences({"A": "F x=0"}), memory=memory, **options)
    except LimitError:
        pass


def cell_of(value: _Value) -> str:
    """Returns a value as it is written in a cell."""
    return str(value).lower() if isinstance(value, bool) else str(value)


def value_of(cell: str) -> Any:
    """Reads a cell."""
    if cell in _WORDS:
        return _WORDS[cell]
    for kind in (int, float, Fraction):
        try:
            return kind(cell)
        except (ValueError, ZeroDivisionError):
            pass
    return cell
