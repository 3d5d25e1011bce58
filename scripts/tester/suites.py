"""All checks by name."""

from tester import (
    checks,
    dumps,
    exchange,
    games,
    induced,
    lists,
    memory,
    names,
    nested,
    package,
    pages,
    places,
    policies,
    promises,
    pursuits,
    questions,
    refusals,
    regions,
    several,
    stopping,
    sweeps,
    tables,
    tasks,
    together,
    valued,
    whole,
    wild,
)

GROUPS = (
    *(checks, games, promises, pursuits, induced, regions, dumps, questions, tables, whole, valued, together),
    *(stopping, sweeps, places, lists, nested, several, exchange, names, wild, pages, refusals, package, tasks, policies, memory),
)
ALL = {name: check for group in GROUPS for name, check in group.ALL.items()}
