"""The exceptions of meliora.

``Error`` is the base class of all of them. An ``InputError`` reports an invalid text, with the place of each problem. A
``UsageError`` reports inconsistent arguments. A ``LimitError`` reports a limit that ended the work, with the results
so far. ``KeyboardInterrupt`` and ``OSError`` are Python's own.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from ._native import Analysis

__all__ = ["Error", "InputError", "LimitError", "OutOfMemory", "OutOfTime", "Problem", "TooLarge", "UsageError"]


class Error(Exception):
    """The base class of all exceptions of this package."""


class UsageError(Error, ValueError):
    """The arguments of a call are inconsistent: an unknown name, a region of another exploration, …"""


class Problem(NamedTuple):
    """A problem in a text."""

    message: str
    #: The path of the text as given, or a name such as ``model``.
    file: str
    #: Line and column, both from 1; columns count characters.
    line: int
    column: int
    #: The text below the place; may be empty.
    label: str
    #: Advice.
    help: str | None
    notes: tuple[str, ...]
    #: The problem with its line and a caret below the place.
    shown: str


class InputError(Error, ValueError):
    """A model, preferences or an expression is invalid. ``str()`` shows every problem at its place."""

    def __init__(self, problems: tuple[Problem, ...], shown: str) -> None:
        super().__init__(shown)
        #: All problems of the text.
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
    """A limit ended the work. The results so far are kept."""

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
        #: The phase of the work, as in ``Progress.phase``.
        self.phase = phase
        #: The part of the phase, in words.
        self.detail = detail
        #: The incomplete analysis, if any: it answers queries from its results, and ``resume`` continues it.
        self.analysis = analysis
        #: Its results as plain data, in the format of ``Analysis.to_dict``.
        self.known = known

    def __reduce__(self) -> tuple[Any, ...]:
        # The analysis is bound to this process.
        return _limit, (type(self), str(self), self.phase, self.detail, self.known)


class OutOfTime(LimitError, TimeoutError):
    """The ``timeout`` has passed."""


class OutOfMemory(LimitError, MemoryError):
    """The limit ``memory`` is reached, or the system has no more memory."""


class TooLarge(LimitError):
    """A fixed bound is exceeded: on numbered states, on cells of an array, on the size of an expression, …"""


def _limit(
    kind: type[LimitError], message: str, phase: str | None, detail: str, known: dict[str, Any] | None
) -> LimitError:
    return kind(message, phase=phase, detail=detail, known=known)
