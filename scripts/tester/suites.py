"""All checks by name."""

from tester import checks, exchange, games, package, pages, promises, questions, regions

ALL = {**checks.ALL, **games.ALL, **promises.ALL, **regions.ALL, **questions.ALL, **exchange.ALL, **pages.ALL, **package.ALL}
