"""All checks by name."""

from tester import checks, promises, regions

ALL = {**checks.ALL, **promises.ALL, **regions.ALL}
