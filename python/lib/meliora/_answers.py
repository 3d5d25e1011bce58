"""The answers of ``Model.ask``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .reports import ReachPlan, ReachProperties

if TYPE_CHECKING:
    from typing_extensions import NotRequired


class Answer(ReachProperties):
    """A property with its answer. The only one of a call has the plans and strategies that were asked for."""

    plan: NotRequired[ReachPlan]
    """The plans for the target; absent if they are not asked for, and the property is not the goal of a planning
    problem."""
    policy: NotRequired[Any]
    """The object that ``meliora reach --policy FILE.json`` writes, None without one; absent if it is not asked for."""
