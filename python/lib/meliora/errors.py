"""The exceptions of meliora.

``Error`` is the base of all of them. What is wrong in a text is an ``InputError`` with the place of each problem; what
does not fit together is a ``UsageError``; a limit that ended the work is a ``LimitError`` that has what is known by then.
``KeyboardInterrupt`` and ``OSError`` are Python's own.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from ._native import Analysis

__all__ = ["Error", "InputError", "LimitError", "OutOfMemory", "OutOfTime", "Problem", "TooLarge", "UsageError"]


class Error(Exception):
    """The base of all exceptions of this package."""


class UsageError(Error, ValueError):
    """What is asked for does not fit together: an unknown name, a region of another exploration, …"""


class Problem(NamedTuple):
    """One thing that is wrong in a text."""

    message: str
    #: The path of the text as it was given, or a name such as ``model``.
    file: str
    #: Line and column, both from 1; columns count characters.
    line: int
    column: int
    #: What stands below the place; may be empty.
    label: str
    #: What would help.
    help: str | None
    notes: tuple[str, ...]
    #: The problem with its line and a caret below the place.
    shown: str


class InputError(Error, ValueError):
    """A model, preferences or an expression is wrong. ``str()`` shows every problem where it is."""

    def __init__(self, problems: tuple[Problem, ...], shown: str) -> None:
        super().__init__(shown)
        #: All that was found.
        self.problems = problems

    @property
    def file(self) -> str:
        """The text of the first problem."""
        return self.problems[0].file

    @property
    def line(self) -> int:
        """The line of the first problem, from 1."""
        return self.problems[0].line

    @property
    def column(self) -> int:
        """The column of the first problem, from 1."""
        return self.problems[0].column

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.problems, str(self))


class LimitError(Error):
    """A limit ended the work. What was known by then is there."""

    def __init__(
        self,
        message: str,
        *,
        phase: str | None = None,
        detail: str = "",
        analysis: Analysis | None = None,
        known: dict[str, Any] | None = None,
    ) -> None:
        super().__init__(message)
        #: What was being done, as in ``Progress.phase``.
        self.phase = phase
        #: Which part of it, in words.
        self.detail = detail
        #: The unfinished analysis, where there is one: all that it knows can be asked, and ``resume`` goes on.
        self.analysis = analysis
        #: The same as plain data: what ``Analysis.to_dict`` has of it.
        self.known = known

    def __reduce__(self) -> tuple[Any, ...]:
        # The analysis lives in its process.
        return _limit, (type(self), str(self), self.phase, self.detail, self.known)


class OutOfTime(LimitError, TimeoutError):
    """``timeout`` has passed."""


class OutOfMemory(LimitError, MemoryError):
    """``memory`` is used up, or the system gives no more."""


class TooLarge(LimitError):
    """A fixed bound was passed: of states that are numbered, of cells in an array, of an expression, …"""


def _limit(
    kind: type[LimitError], message: str, phase: str | None, detail: str, known: dict[str, Any] | None
) -> LimitError:
    return kind(message, phase=phase, detail=detail, known=known)
