"""All checks by name."""

from tester import checks, package, promises, regions

ALL = {**checks.ALL, **promises.ALL, **regions.ALL, **package.ALL}
