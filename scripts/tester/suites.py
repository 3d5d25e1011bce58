"""All checks by name."""

from tester import (
    checks,
    exchange,
    games,
    lists,
    names,
    package,
    pages,
    promises,
    questions,
    refusals,
    regions,
    stopping,
    tables,
    together,
    whole,
    wild,
)

GROUPS = (
    *(checks, games, promises, regions, questions, tables, whole, together, stopping),
    *(lists, exchange, names, wild, pages, refusals, package),
)
ALL = {name: check for group in GROUPS for name, check in group.ALL.items()}
