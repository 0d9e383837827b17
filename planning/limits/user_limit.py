"""Limits from outside, whose rows are looked at: kernels look at no bounds."""

from __future__ import annotations

import numpy as np

from cartgrasp.arms import Arm, UserLimit
from cartgrasp.checks import check_kind
from cartgrasp.errors import UsageError

from .limit import LimitRows


def user_rows(limit: UserLimit, arm: Arm) -> LimitRows:
    """The rows of an arm's limit, or a `UsageError` that says what is wrong with them."""
    where = f"arm {arm.name}: limits: {type(limit).__name__}"
    rows: LimitRows = limit.rows(arm)
    check_kind(f"{where}: rows", rows, LimitRows, "return LimitRows(...)")
    k = len(rows.rows)
    shapes = {"lower": (6,), "upper": (6,), "rows": (k, 6), "limits": (k,), "low_limits": (k,)}
    for field, shape in shapes.items():
        values = np.asarray(getattr(rows, field))
        if values.shape != shape or values.dtype.kind not in "fiu" or np.isnan(values).any():
            raise UsageError(f"{where}: {field}: {values.tolist()} is not {shape} numbers; give N and N·m")
    for field, count in {"lower_names": 6, "upper_names": 6, "names": k, "low_names": k}.items():
        names = getattr(rows, field)
        if len(names) != count or not all(names):
            raise UsageError(f"{where}: {field}: {list(names)} are not {count} names; name each, as plans tell them")
    low, high = np.r_[rows.lower, rows.low_limits], np.r_[rows.upper, rows.limits]
    if (low > 0).any() or (high < 0).any():
        raise UsageError(f"{where}: it leaves out the wrench 0, so an arm that lets go would break it; take that in")
    return rows
