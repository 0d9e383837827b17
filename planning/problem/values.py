"""What a single value of `PROBLEM.yaml` and `study.yaml` may be."""

from __future__ import annotations

from typing import Annotated

from pydantic import AfterValidator, Field

from cartgrasp.checks import MAX_NUMBER, angle
from cartgrasp.errors import UsageError

from ..contacts.switching_cost import MAX_SWITCHING_COST
from ..tick.plan_inputs import MAX_WRENCH


def _limit(value: float) -> float:
    if not abs(value) < float("inf"):
        raise ValueError(f"{value} is not a finite number; leave the key out for no limit")
    return _not_negative(value) if value <= MAX_NUMBER else float("inf")  # beyond it limits nothing


def _not_negative(value: float) -> float:
    if value < 0:
        raise ValueError(f"{value:g} is negative; a number >= 0 is needed")
    return value


def _positive(value: float) -> float:
    if not value > 0:
        raise ValueError(f"{value:g} is not > 0")
    return value


def _rate(value: float) -> float:
    return _positive(value) if value <= MAX_NUMBER else float("inf")  # beyond it limits nothing


def _angle(value: float) -> float:
    try:
        return angle("", value)
    except UsageError as error:
        raise ValueError(str(error).removeprefix(": ")) from error


def _switching_cost(value: float) -> float:
    if value > MAX_SWITCHING_COST:
        raise ValueError(f"{value:g} is beyond {MAX_SWITCHING_COST:g}")
    return _not_negative(value)


NotNegative = Annotated[float, AfterValidator(_not_negative)]
Positive = Annotated[float, AfterValidator(_positive)]
LimitValue = Annotated[float, Field(allow_inf_nan=True), AfterValidator(_limit)]
Triple = Annotated[list[float], Field(min_length=3, max_length=3)]
LimitTriple = Annotated[list[LimitValue], Field(min_length=3, max_length=3)]
SwitchingCostValue = Annotated[float, AfterValidator(_switching_cost)]
WrenchValue = Annotated[float, Field(ge=-MAX_WRENCH, le=MAX_WRENCH)]
RateTriple = Annotated[list[Annotated[float, AfterValidator(_rate)]], Field(min_length=3, max_length=3)]
Angle = Annotated[float, AfterValidator(_angle)]
WeightValue = Annotated[NotNegative, Field(le=MAX_NUMBER)]
