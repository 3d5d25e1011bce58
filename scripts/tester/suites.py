"""All checks by name."""

from tester import checks

ALL = {**checks.ALL}
