"""All checks by name."""

from tester import checks, exchange, package, promises, questions, regions

ALL = {**checks.ALL, **promises.ALL, **regions.ALL, **questions.ALL, **exchange.ALL, **package.ALL}
