"""Transition tables as texts in Storm's format DRN, which ``Model`` reads."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from numbers import Integral, Real
from typing import Any, NoReturn

from .errors import UsageError

#: The label of the states that terminated transitions enter.
DONE = "done"

#: The transitions of a state: for each available action, by its number, pairs (successor, probability).
_Row = dict[int, list[tuple[int, float]]]
#: The rows of all states, the names of the actions, and the states that terminated transitions enter.
_Table = tuple[list[_Row], list[str], list[int]]


def drn(
    transitions: Any, rewards: Any = None, labels: Any = None, start: Any = None, actions: Any = None
) -> str:
    """Returns a model as text; see ``Model.from_transitions``."""
    rows, names, done = _rows(transitions)
    if actions is not None:
        names = _names("action", actions, len(names))
    if not rows:
        _wrong("there is no state")
    _check_distributions(rows, names)
    size = len(rows)
    marked = {name: _states(f"label {name!r}", states, size) for name, states in dict(labels or {}).items()}
    _names("label", marked, None)
    if done:
        marked.setdefault(DONE, done)
    initial = range(size) if start is None else _states("start", start, size)
    if not initial:
        _wrong("start: there is no state in it")
    marked["init"] = list(initial)
    costs = {name: _costs(name, values, size, len(names)) for name, values in dict(rewards or {}).items()}
    _names("reward", costs, None)
    return "\n".join(_lines(rows, names, marked, costs))


def _lines(rows: list[_Row], names: list[str], labels: dict[str, list[int]], costs: dict[str, Any]) -> Iterable[str]:
    of_state: list[list[str]] = [[] for _ in rows]
    for name, states in labels.items():
        for state in sorted(set(states)):
            of_state[state].append(name)
    yield from ("@type: MDP", "@parameters", "", "@reward_models", " ".join(costs))
    yield from ("@nr_states", str(len(rows)), "@nr_choices", str(sum(map(len, rows))), "@model")
    for state, row in enumerate(rows):
        yield f"state {state} {' '.join(of_state[state])}"
        for action, branches in row.items():
            earned = ", ".join(repr(cost[state][action]) for cost in costs.values())
            yield f"\taction {names[action]} [{earned}]" if costs else f"\taction {names[action]}"
            yield from (f"\t\t{target} : {probability!r}" for target, probability in branches)
    yield ""


def _rows(transitions: Any) -> _Table:
    """Reads any of the three kinds of tables."""
    if isinstance(transitions, Mapping) and all(isinstance(row, Mapping) for row in transitions.values()):
        return _of_tuples(transitions)
    if isinstance(transitions, Mapping):
        names = _names("action", transitions, None)
        return _of_matrices(list(transitions.values()), names), names, []
    shape = getattr(transitions, "shape", None)
    if shape is not None and (len(shape) != 3 or shape[0] != shape[2]):
        _wrong(f"an array of transitions has the shape (S, A, S), not {tuple(shape)}")
    if shape is not None:
        names = [f"a{action}" for action in range(shape[1])]
        return _of_array(transitions), names, []
    if not isinstance(transitions, Sequence) or isinstance(transitions, str):
        expected = "a dictionary as Gymnasium's `P`, an array (S, A, S), or one matrix (S, S) per action"
        _wrong(f"transitions are {expected}, not {type(transitions).__name__}")
    names = [f"a{action}" for action in range(len(transitions))]
    return _of_matrices(list(transitions), names), names, []


def _of_tuples(table: Mapping[Any, Mapping[Any, Any]]) -> _Table:
    """Reads Gymnasium's ``P[state][action] = [(probability, next state, reward, terminated), …]``."""
    size = len(table)
    if set(table) != set(range(size)):
        _wrong(f"the states of a dictionary are the numbers from 0 to {size - 1}")
    keys = list(dict.fromkeys(action for row in table.values() for action in row))
    if all(isinstance(key, Integral) for key in keys):
        keys = list(range(int(max(keys)) + 1)) if keys and min(keys) >= 0 else keys
        names = [f"a{int(key)}" for key in keys]
    else:
        names = _names("action", keys, None)
    number = {key: action for action, key in enumerate(keys)}
    rows: list[_Row] = []
    done: set[int] = set()
    for state in range(size):
        row: _Row = {}
        for key, entries in table[state].items():
            branches = row.setdefault(number[key], [])
            for entry in entries:
                if len(entry) not in (2, 3, 4):
                    _wrong(f"state {state}, action {key}: {entry} is not (probability, next state, reward, terminated)")
                target = _state(f"state {state}, action {key}", entry[1], size)
                branches.append((target, _number(f"state {state}, action {key}", entry[0])))
                if len(entry) == 4 and entry[3] and entry[0]:
                    done.add(target)
        rows.append(row)
    for state in done:
        rows[state] = {action: [(state, 1.0)] for action in rows[state]}
    return rows, names, sorted(done)


def _of_array(array: Any) -> list[_Row]:
    rows: list[_Row] = []
    for state, of_state in enumerate(array.tolist()):
        where = f"state {state}"
        of_action = ([(t, _number(where, p)) for t, p in enumerate(row) if p] for row in of_state)
        rows.append({action: branches for action, branches in enumerate(of_action) if branches})
    return rows


def _of_matrices(matrices: list[Any], names: list[str]) -> list[_Row]:
    """Reads one matrix per action, of NumPy or scipy."""
    if not matrices:
        _wrong("there is no action")
    size = matrices[0].shape[0] if getattr(matrices[0], "shape", None) else 0
    rows: list[_Row] = [{} for _ in range(size)]
    for action, matrix in enumerate(matrices):
        shape = getattr(matrix, "shape", None)
        if shape is None or tuple(shape) != (size, size):
            found = type(matrix).__name__ if shape is None else tuple(shape)
            _wrong(f"action {names[action]}: expected a matrix of the shape {(size, size)}, not {found}")
        for state, target, probability in _entries(matrix):
            value = _number(f"state {state}, action {names[action]}", probability)
            if value:
                rows[state].setdefault(action, []).append((target, value))
    return rows


def _entries(matrix: Any) -> Iterable[tuple[int, int, Any]]:
    """Returns the entries of a matrix that are not 0, as (row, column, value)."""
    if hasattr(matrix, "tocoo"):
        # Conversion to rows adds up entries of the same place.
        cells = matrix.tocsr().tocoo()
        return zip(cells.row.tolist(), cells.col.tolist(), cells.data.tolist())
    rows, columns = matrix.nonzero()
    return zip(rows.tolist(), columns.tolist(), matrix[rows, columns].tolist())


def _check_distributions(rows: list[_Row], names: list[str]) -> None:
    for state, row in enumerate(rows):
        for action, branches in row.items():
            total = math.fsum(probability for _, probability in branches)
            where = f"state {state}, action {names[action]}"
            if any(not 0 <= probability <= 1 for _, probability in branches):
                wrong = next(probability for _, probability in branches if not 0 <= probability <= 1)
                _wrong(f"{where}: {wrong} is not a probability")
            if abs(total - 1) > 1e-6:
                _wrong(f"{where}: the probabilities sum to {total}, not to 1")


def _states(what: str, given: Any, size: int) -> list[int]:
    """Returns states that are given by a number, numbers, Booleans by state, or a distribution."""
    if isinstance(given, Integral) and not isinstance(given, bool):
        return [_state(what, given, size)]
    if isinstance(given, str) or not isinstance(given, Iterable):
        _wrong(f"{what}: expected states, or a Boolean for each state, not {given!r}")
    values = given.tolist() if hasattr(given, "tolist") else list(given)
    if values and all(isinstance(value, (bool, float)) for value in values):
        if len(values) != size:
            _wrong(f"{what}: {len(values)} values for {size} states")
        return [state for state, value in enumerate(values) if value]
    return [_state(what, value, size) for value in values]


def _state(what: str, given: Any, size: int) -> int:
    if isinstance(given, Integral) and not isinstance(given, bool) and 0 <= int(given) < size:
        return int(given)
    _wrong(f"{what}: {given!r} is not a state; states are the numbers from 0 to {size - 1}")


def _number(what: str, given: Any) -> float:
    if isinstance(given, Real) and math.isfinite(given):
        return float(given)
    _wrong(f"{what}: {given!r} is not a number")


def _names(what: str, given: Iterable[Any], count: int | None) -> list[str]:
    names = list(given)
    for name in names:
        if not isinstance(name, str) or not name.isascii() or not name.isidentifier() or name in ("init", "deadlock"):
            _wrong(f"{name!r} cannot be the name of a {what}: names consist of letters, digits and `_`")
    if len(set(names)) != len(names) or (count is not None and len(names) != count):
        _wrong(f"expected {count if count is not None else 'different'} {what} names, found {', '.join(names)}")
    return names


def _costs(name: str, values: Any, size: int, actions: int) -> list[list[float]]:
    """Returns rewards by state and action."""
    table = values.tolist() if hasattr(values, "tolist") else list(values)
    if len(table) != size:
        _wrong(f"reward {name!r}: {len(table)} values for {size} states")
    rows: list[list[float]] = []
    for state, row in enumerate(table):
        found = list(row) if isinstance(row, Iterable) else [row] * actions
        if len(found) != actions:
            _wrong(f"reward {name!r}: {len(found)} values in state {state}, for {actions} actions")
        rows.append([_number(f"reward {name!r} in state {state}", value) for value in found])
    return rows


def _wrong(message: str) -> NoReturn:
    raise UsageError(message)
