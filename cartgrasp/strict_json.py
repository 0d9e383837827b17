"""JSON knows no NaN and no infinity: what is not finite is null."""

from __future__ import annotations

import math
from typing import Any


def finite(value: Any) -> Any:
    """The same document with null for what is not finite."""
    if isinstance(value, dict):
        return {str(k): finite(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [finite(v) for v in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value
