"""All checks by name."""

from tester import checks, exchange, games, package, pages, promises, questions, refusals, regions, tables, together

GROUPS = (checks, games, promises, regions, questions, tables, together, exchange, pages, refusals, package)
ALL = {name: check for group in GROUPS for name, check in group.ALL.items()}
