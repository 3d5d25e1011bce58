"""All checks by name."""

from tester import checks, package, promises, questions, regions

ALL = {**checks.ALL, **promises.ALL, **regions.ALL, **questions.ALL, **package.ALL}
