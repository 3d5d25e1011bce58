"""Meliora: opportunistic planning with incomplete preferences in Markov decision processes.

    >>> import meliora
    >>> model = meliora.Model.from_file("models/robot5x5.prism")
    >>> wishes = meliora.Preferences.from_file("models/robot5x5.pref")
    >>> found = model.check(wishes, scope="all", safety="transition")
    >>> found.sasi.counts
    [768, 98]

``Model`` and ``Preferences`` are parsed texts. ``Model.check`` returns an ``Analysis`` with its ``Region`` objects,
``Levels``, and a ``Strategy`` of each kind. ``Model.explore`` returns an ``Exploration`` for many queries. ``sweep``
analyses a model for many values of its constants. ``Analysis.export`` writes a dump, which ``Dump`` reads and
``verify`` checks.
Long calls release the interpreter, stop on Ctrl-C, and accept ``timeout`` in seconds and a ``progress`` callback.
"""

from ._native import (
    Action,
    Analysis,
    Dump,
    Explanation,
    Exploration,
    Levels,
    Model,
    Play,
    Preferences,
    Progress,
    Reachability,
    Region,
    RegionIterator,
    Shield,
    Simulation,
    Strategy,
    Successor,
    Variable,
    Verdict,
    __version__,
    verify,
)
from ._policy import Policy
from ._sweep import sweep
from .errors import Error, InputError, LimitError, OutOfMemory, OutOfTime, Problem, TooLarge, UsageError

__all__ = [
    "Action",
    "Analysis",
    "Dump",
    "Error",
    "Explanation",
    "Exploration",
    "InputError",
    "Levels",
    "LimitError",
    "Model",
    "OutOfMemory",
    "OutOfTime",
    "Play",
    "Policy",
    "Preferences",
    "Problem",
    "Progress",
    "Reachability",
    "Region",
    "RegionIterator",
    "Shield",
    "Simulation",
    "Strategy",
    "Successor",
    "TooLarge",
    "UsageError",
    "Variable",
    "Verdict",
    "__version__",
    "sweep",
    "verify",
]
