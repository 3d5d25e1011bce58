"""The rows of a sweep and their file, as the command line writes it."""

from __future__ import annotations

import io
import math
import os
from collections.abc import Iterator, Sequence
from csv import reader, writer
from fractions import Fraction
from typing import Any, TextIO

from .errors import UsageError

#: The cells that are not numbers.
_WORDS: dict[str, Any] = {"": None, "true": True, "false": False, "unbounded": math.inf}


class Rows:
    """A header and one row per instance, by the position of the instance, also as a file.

    Each row is appended to the file at once. At the end, the file is replaced by one with the rows in the order of the
    instances, if they ended in another order. `keys` are the texts of the constants of each instance.

    Raises:
        UsageError: The file is an input, not a regular file, or belongs to another sweep.
        OSError: The file cannot be read or written.
    """

    def __init__(
        self, path: Any, header: list[str], keys: Sequence[tuple[str, ...]], resume: bool, inputs: list[Any]
    ) -> None:
        self.header = header
        self._keys = keys
        self._rows: dict[int, list[str]] = {}
        self._out: TextIO | None = None
        self._path = None if path is None else os.path.realpath(path)
        if self._path is None:
            if resume:
                raise UsageError("resume=True needs `csv`, the file of the sweep")
        elif os.path.exists(self._path):
            _check_regular(self._path, inputs)
            if resume:
                self._read(self._path)

    def _read(self, path: str) -> None:
        """Reads the rows of an existing file, except for an incomplete last line."""
        with open(path, encoding="utf-8", newline="") as file:
            text = file.read()
        position = {key: at for at, key in enumerate(self._keys)}
        constants = len(self._keys[0])
        for line, row in enumerate(reader(io.StringIO(text[: text.rfind("\n") + 1], newline="")), 1):
            if line == 1:
                if row != self.header:
                    wrong = "this is not the header of this sweep; without `resume` the file is overwritten"
                    raise UsageError(f"{path}: {wrong}")
                continue
            at = position.get(tuple(row[:constants]))
            if at is None or len(row) != len(self.header):
                raise UsageError(f"{path}, line {line}: this row does not belong to this sweep")
            self._rows[at] = row

    def missing(self) -> list[int]:
        """Returns the positions of the instances that have no row."""
        return [at for at in range(len(self._keys)) if at not in self._rows]

    def add(self, position: int, row: list[str]) -> None:
        """Adds a row, and writes it."""
        self._rows[position] = row
        if self._out is not None:
            _write(self._out, [row])
            self._out.flush()

    def __iter__(self) -> Iterator[tuple[int, list[str]]]:
        return iter(sorted(self._rows.items()))

    def __enter__(self) -> Rows:
        if self._path is not None:
            self._replace(self._path)
            self._out = open(self._path, "a", encoding="utf-8", newline="")
        return self

    def __exit__(self, *_: object) -> None:
        if self._path is not None and self._out is not None:
            self._out.close()
            if list(self._rows) != sorted(self._rows):
                self._replace(self._path)

    def _replace(self, path: str) -> None:
        """Replaces the file as a whole by one with sorted rows."""
        part = f"{path}.{os.getpid()}.part"
        try:
            with open(part, "w", encoding="utf-8", newline="") as file:
                _write(file, [self.header, *(row for _, row in self)])
            os.replace(part, path)
        finally:
            if os.path.exists(part):
                os.remove(part)


def _write(file: TextIO, rows: list[list[str]]) -> None:
    writer(file, lineterminator="\n").writerows(rows)


def _check_regular(path: str, inputs: list[Any]) -> None:
    if not os.path.isfile(path):
        raise UsageError(f"{path}: rows are written to a regular file, and this is none")
    for given in inputs:
        if os.path.exists(given) and os.path.samefile(path, given):
            raise UsageError(f"{path} is an input of this sweep; write the rows to another file")


def cell_of(value: Any) -> str:
    """Returns a value as it is written in a cell; None is an empty cell."""
    if value is None:
        return ""
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
