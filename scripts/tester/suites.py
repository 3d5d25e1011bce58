"""All checks by name."""

from tester import checks, exchange, games, package, promises, questions, regions, stopping

ALL = {
    **checks.ALL, **games.ALL, **promises.ALL, **regions.ALL, **questions.ALL, **exchange.ALL, **package.ALL,
    **stopping.ALL,
}  # fmt: skip
