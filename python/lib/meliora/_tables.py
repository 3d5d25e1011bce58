"""Transition tables as texts in Storm's format DRN, which ``Model`` reads."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from numbers import Integral, Real
from typing import Any, NoReturn

from .errors import UsageError

#: The label of the states that terminated transitions enter.
DONE = "done"

#: The transitions of a state: for each available action, by its number, pairs (successor, probability).
_Row = dict[int, list[tuple[int, float]]]


@dataclass
class _Table:
    """A model as numbers: the rows of all states, the names of the actions, and the states that terminated transitions
    enter. `numbers` has the number of each state by its key, if the states are keys of a dictionary."""

    rows: list[_Row]
    actions: list[str]
    done: list[int]
    numbers: dict[Any, int] | None = None


def drn(
    transitions: Any, rewards: Any = None, labels: Any = None, start: Any = None, actions: Any = None, states: Any = None
) -> str:
    """Returns a model as text; see ``Model.from_transitions``."""
    table = _read(transitions)
    rows, size = table.rows, len(table.rows)
    names = table.actions if actions is None else _names("action", actions, len(table.actions))
    if not rows:
        _wrong("there is no state")
    _check_distributions(rows, names)
    given = list(table.numbers) if states is None and table.numbers else states
    called = None if given is None else _state_names(given, size)
    # A state is known by its key and by its name.
    known = {**dict(zip(called or [], range(size))), **(table.numbers or {})}
    marked = {name: _states(f"label {name!r}", own, size, known) for name, own in _named("labels", labels).items()}
    _names("label", marked, None)
    if table.done:
        marked.setdefault(DONE, table.done)
    initial = range(size) if start is None else _states("start", start, size, known, is_distribution=True)
    if not initial:
        _wrong("start: there is no state in it")
    marked["init"] = list(initial)
    costs = {name: _costs(name, own, known, size, len(names)) for name, own in _named("rewards", rewards).items()}
    _names("reward", costs, None)
    return "\n".join(_lines(rows, names, marked, costs, called))


def _lines(
    rows: list[_Row], names: list[str], labels: dict[str, list[int]], costs: dict[str, Any], called: list[str] | None
) -> Iterable[str]:
    of_state: list[list[str]] = [[] for _ in rows]
    for name, states in labels.items():
        for state in sorted(set(states)):
            of_state[state].append(name)
    yield from ("@type: MDP", "@parameters", "", "@reward_models", " ".join(costs))
    if called is not None:
        yield "@state_names"
        yield from (f'"{name}"' for name in called)
    yield from ("@nr_states", str(len(rows)), "@nr_choices", str(sum(map(len, rows))), "@model")
    for state, row in enumerate(rows):
        yield f"state {state} {' '.join(of_state[state])}"
        for action, branches in row.items():
            earned = ", ".join(repr(cost[state][action]) for cost in costs.values())
            yield f"\taction {names[action]} [{earned}]" if costs else f"\taction {names[action]}"
            yield from (f"\t\t{target} : {probability!r}" for target, probability in branches)
    yield ""


def _read(transitions: Any) -> _Table:
    """Reads any of the kinds of tables."""
    if isinstance(transitions, Mapping) and all(isinstance(row, Mapping) for row in transitions.values()):
        return _of_tuples(transitions)
    if isinstance(transitions, Mapping):
        names = _names("action", transitions, None)
        return _Table(_of_matrices(list(transitions.values()), names), names, [])
    if not hasattr(transitions, "shape") and isinstance(transitions, Sequence) and not isinstance(transitions, str):
        transitions = _of_lists(transitions)
    shape = getattr(transitions, "shape", None)
    if shape is not None and len(shape) == 3 and shape[1] == shape[2] != shape[0]:
        # The layout (A, S, S) of other packages.
        names = [f"a{action}" for action in range(shape[0])]
        matrices = list(transitions) if not isinstance(transitions, _Lists) else transitions.tolist()
        return _Table(_of_matrices(matrices, names), names, [])
    if shape is not None and (len(shape) != 3 or shape[0] != shape[2]):
        _wrong(f"an array of transitions has the shape (S, A, S) or (A, S, S), not {tuple(shape)}")
    if shape is not None:
        names = [f"a{action}" for action in range(shape[1])]
        return _Table(_of_array(transitions), names, [])
    if not isinstance(transitions, Sequence) or isinstance(transitions, str):
        expected = "a dictionary as Gymnasium's `P`, an array (S, A, S), or one matrix (S, S) per action"
        _wrong(f"transitions are {expected}, not {type(transitions).__name__}")
    names = [f"a{action}" for action in range(len(transitions))]
    return _Table(_of_matrices(list(transitions), names), names, [])


class _Lists:
    """Nested lists of numbers with the methods of an array that are used here."""

    def __init__(self, lists: Any) -> None:
        self._lists = lists
        self.shape = _shape(lists)

    def tolist(self) -> Any:
        return self._lists

    def entries(self) -> Iterable[tuple[int, int, Any]]:
        """The entries of a matrix that are not 0."""
        cells = ((row, column, value) for row, own in enumerate(self._lists) for column, value in enumerate(own))
        return ((row, column, value) for row, column, value in cells if value)


def _is_list(given: Any) -> bool:
    return isinstance(given, Sequence) and not isinstance(given, (str, bytes))


def _shape(lists: Any) -> tuple[int, ...]:
    """Returns the lengths of nested lists, which are those of each part."""
    if not _is_list(lists):
        return ()
    shapes = {_shape(part) for part in lists}
    if len(shapes) > 1:
        _wrong("the parts of nested lists have different lengths")
    return (len(lists), *next(iter(shapes), ()))


def _of_lists(given: Sequence[Any]) -> Any:
    """Reads nested lists as the array (S, A, S) or as one matrix (S, S) per action, by their lengths; leaves lists of
    arrays as they are."""
    if not given or not all(_is_list(part) and all(map(_is_list, part)) for part in given):
        return given
    lists = _Lists(given)
    if len(set(lists.shape)) == 1 and len(lists.shape) == 3:
        both = "(states, actions, states) or (actions, states, states)"
        _wrong(f"nested lists of the shape {lists.shape} may be {both}; give an array, or a dictionary by actions")
    is_array = len(lists.shape) == 3 and lists.shape[0] == lists.shape[2]
    return lists if is_array else list(map(_Lists, given))


def _of_tuples(table: Mapping[Any, Mapping[Any, Any]]) -> _Table:
    """Reads ``P[state][action]``: Gymnasium's lists ``[(probability, next state, reward, terminated), …]``, or
    dictionaries ``{next state: probability}``. States are numbers from 0 on, or have names."""
    size = len(table)
    are_numbers = set(table) == set(range(size)) and not any(isinstance(state, bool) for state in table)
    states = {state: state for state in range(size)} if are_numbers else dict(zip(table, range(size)))
    keys = list(dict.fromkeys(action for row in table.values() for action in row))
    if all(isinstance(key, Integral) for key in keys):
        keys = list(range(int(max(keys)) + 1)) if keys and min(keys) >= 0 else keys
        names = [f"a{int(key)}" for key in keys]
    else:
        names = _names("action", keys, None)
    number = {key: action for action, key in enumerate(keys)}
    rows: list[_Row] = []
    done: set[int] = set()
    for state in states:
        row: _Row = {}
        for key, entries in table[state].items():
            where = f"state {state}, action {key}"
            branches = row.setdefault(number[key], [])
            for entry in _branches(entries, states):
                if len(entry) not in (2, 3, 4):
                    _wrong(f"{where}: {entry} is not (probability, next state, reward, terminated)")
                target = _state(where, entry[1], size, {} if are_numbers else states)
                branches.append((target, _number(where, entry[0])))
                if len(entry) == 4 and entry[3] and entry[0]:
                    done.add(target)
        rows.append(row)
    for state in done:
        rows[state] = {action: [(state, 1.0)] for action in rows[state]}
    return _Table(rows, names, sorted(done), None if are_numbers else states)


def _branches(entries: Any, states: Mapping[Any, int]) -> Iterable[Any]:
    """Returns the branches of an action as tuples; a state alone is entered with probability 1."""
    if isinstance(entries, Mapping):
        return [(probability, target) for target, probability in entries.items()]
    if isinstance(entries, (str, Integral)) or (isinstance(entries, tuple) and _is_key(entries, states)):
        return [(1.0, entries)]
    branches: Iterable[Any] = entries
    return branches


def _is_key(given: Any, known: Mapping[Any, int]) -> bool:
    """Whether a state is known by this; a list or another value that cannot be hashed is not."""
    try:
        return not isinstance(given, bool) and given in known
    except TypeError:
        return False


def _state_names(given: Iterable[Any], size: int) -> list[str]:
    """Returns the names of the states, in their order."""
    names = [name if isinstance(name, str) else str(name) for name in given]
    if len(names) != size:
        _wrong(f"there are {len(names)} names for {size} states")
    for name in names:
        if not name or not name.isprintable() or '"' in name:
            _wrong(f"{name!r} cannot be the name of a state: names are printable texts without double quotes")
    if len(set(names)) != size:
        twice = next(name for name in names if names.count(name) > 1)
        _wrong(f"two states are called {twice!r}")
    return names


def _of_array(array: Any) -> list[_Row]:
    rows: list[_Row] = []
    for state, of_state in enumerate(array.tolist()):
        where = f"state {state}"
        of_action = ([(t, _number(where, p)) for t, p in enumerate(row) if p] for row in of_state)
        rows.append({action: branches for action, branches in enumerate(of_action) if branches})
    return rows


def _of_matrices(matrices: list[Any], names: list[str]) -> list[_Row]:
    """Reads one matrix per action, of NumPy or scipy, or nested lists."""
    if not matrices:
        _wrong("there is no action")
    matrices = [_Lists(matrix) if _is_list(matrix) else matrix for matrix in matrices]
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
    if isinstance(matrix, _Lists):
        return matrix.entries()
    # A `numpy.matrix` has a row for each list of entries.
    matrix = getattr(matrix, "A", matrix)
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
            if abs(total - 1) > 1e-5:
                _wrong(f"{where}: the probabilities sum to {total}, not to 1")


def _named(what: str, given: Any) -> dict[str, Any]:
    """Returns a dictionary by names."""
    if given is None:
        return {}
    if not isinstance(given, Mapping):
        _wrong(f"{what} are a dictionary by their names, not {type(given).__name__}: write `{what}={{'name': …}}`")
    return dict(given)


def _states(
    what: str, given: Any, size: int, known: Mapping[Any, int], *, is_distribution: bool = False
) -> list[int]:
    """Returns states that are given by a number or a name, several of them, Booleans by state, or a distribution, if
    it may be one."""
    if _is_key(given, known) or (isinstance(given, (str, Integral)) and not isinstance(given, bool)):
        return [_state(what, given, size, known)]
    if isinstance(given, Mapping):
        _check_shares(what, list(given.values()), is_distribution)
        return [_state(what, state, size, known) for state, share in given.items() if share]
    if not isinstance(given, Iterable):
        _wrong(f"{what}: expected states, or a Boolean for each state, not {given!r}")
    values = [_plain(value) for value in (given.tolist() if hasattr(given, "tolist") else given)]
    kinds = {type(value) for value in values}
    if kinds & {bool, float} and kinds <= {bool, float, int}:
        if len(values) != size:
            _wrong(f"{what}: {len(values)} values for {size} states")
        _check_shares(what, values, is_distribution)
        return [state for state, value in enumerate(values) if value]
    are_numbers = all(isinstance(value, Integral) and not isinstance(value, bool) for value in values)
    if are_numbers and len(values) == size and len(set(values)) < size:
        _wrong(
            f"{what}: {size} numbers, some of them repeated, for {size} states: for an entry per state write Booleans, "
            "such as `array == 1`; for numbers of states write each once"
        )
    return [_state(what, value, size, known) for value in values]


def _plain(value: Any) -> Any:
    """Returns a scalar of NumPy as one of Python."""
    return value.item() if hasattr(value, "item") and not getattr(value, "shape", ()) else value


def _check_shares(what: str, values: list[Any], is_distribution: bool) -> None:
    """Requires an entry of 0 or 1 for each state or, where it may stand, a distribution."""
    if all(value in (0, 1) for value in values):
        return
    if not is_distribution:
        wrong = next(value for value in values if value not in (0, 1))
        _wrong(f"{what}: {wrong!r} is neither 0 nor 1: write a Boolean for each state")
    shares = [_number(what, value) for value in values]
    total = math.fsum(shares)
    if min(shares) < 0 or abs(total - 1) > 1e-6:
        _wrong(f"{what}: these are not the probabilities of a distribution, which sum to 1: their sum is {total}")


def _state(what: str, given: Any, size: int, known: Mapping[Any, int]) -> int:
    """Returns the number of a state that is given by its key, its name, or its number if numbers are not keys."""
    if _is_key(given, known):
        return known[given]
    if not any(isinstance(key, Integral) for key in known):
        if isinstance(given, Integral) and not isinstance(given, bool) and 0 <= int(given) < size:
            return int(given)
    shown = ", ".join(map(repr, itertools.islice(known, 8))) + (", …" if len(known) > 8 else "")
    states = f"states are {shown}" if known else f"states are the numbers from 0 to {size - 1}"
    _wrong(f"{what}: {given!r} is not a state; {states}")


def _number(what: str, given: Any) -> float:
    if isinstance(given, Real) and math.isfinite(given):
        return float(given)
    _wrong(f"{what}: {given!r} is not a number")


def _names(what: str, given: Iterable[Any], count: int | None) -> list[str]:
    names = list(given)
    for name in names:
        if not isinstance(name, str) or not name.isascii() or not name.isidentifier() or name in ("init", "deadlock"):
            _wrong(f"{name!r} cannot be the name of a {what}: names consist of letters, digits and `_`")
    if len(set(names)) != len(names):
        _wrong(f"two {what}s are called {next(name for name in names if names.count(name) > 1)!r}")
    if count is not None and len(names) != count:
        _wrong(f"expected {count} {what} names, found {', '.join(names)}")
    return names


def _costs(name: str, values: Any, known: Mapping[Any, int], size: int, actions: int) -> list[list[float]]:
    """Returns rewards by state and action."""
    if isinstance(values, Mapping):
        by_state = {_state(f"reward {name!r}", state, size, known): row for state, row in values.items()}
        values = [by_state.get(state, 0.0) for state in range(size)]
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
