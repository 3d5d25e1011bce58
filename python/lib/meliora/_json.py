"""Reading of JSON."""

from __future__ import annotations

import json
import math
from typing import Any

_INFINITE = {"inf": math.inf, "-inf": -math.inf}


def loads(text: str) -> Any:
    """The value of a JSON text. Infinite bounds, which are texts in JSON, are floats."""
    return json.loads(text, object_hook=_bounds)


def _bounds(found: dict[str, Any]) -> dict[str, Any]:
    if found.keys() in ({"lower", "upper"}, {"lower", "upper", "exact"}):
        for side in ("lower", "upper"):
            if isinstance(found[side], str):
                found[side] = _INFINITE.get(found[side], found[side])
    return found
