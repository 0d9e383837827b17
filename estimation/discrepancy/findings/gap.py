"""The gap between simulation and measurement on stretches that no fit saw, beside what noise alone would do."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from cartgrasp.errors import DataError

from ..search.gains import added
from ..search.model import Model
from .held_out import file_rollouts, floor_rollouts, held_out_rollouts, left_open_rollouts
from .rollouts import HORIZONS, starts

DISAGREEMENT_NOISE_RATIO = 2.0
"""Multiple of what noise alone makes of rollouts: a larger gap is a disagreement."""
MAX_GAP_LEFT_FRACTION = 0.05
"""Share of the squared gap above the noise floor that may be left where it is explained."""
GAP_COORDINATES = ("along", "across", "heading")


@dataclass(frozen=True)
class Gap:
    """Root mean square error (m) of 1 s rollouts on stretches that no fit saw: of the nominal model, of the same
    refitted, with the effects added, and what noise alone would do; by coordinate (m, m, rad) and by horizon. Where
    that is less, what fits without a stretch leave open of the cart would do as well (`left_open`, m)."""

    before: float
    refitted: float
    after: float
    noise_floor: float
    per_coordinate: dict[str, dict[str, float]]
    per_horizon: dict[str, dict[str, float]]
    left_open: float | None = None

    @property
    def is_beyond_noise(self) -> bool:
        """Whether the refitted model is farther off than noise alone takes a right one."""
        return self.refitted > DISAGREEMENT_NOISE_RATIO * self.noise_floor

    @property
    def allowed(self) -> float:
        """Error (m) of a right model with noise, fitted to as little as the other stretches are."""
        return DISAGREEMENT_NOISE_RATIO * float(np.hypot(self.noise_floor, self.left_open or 0.0))

    def as_dict(self) -> dict[str, Any]:
        return {"metric": "root mean square distance after a 1 s rollout on held-out stretches, m", **asdict(self)}


def reported_gap(nominal: Model, final: Model) -> tuple[Gap, bool]:
    """The gap, with the file's errors for the refitted ones where the file's values are the better nominal model. And
    whether nothing was added to that, so that they stay."""
    gap = measured_gap(nominal, final)
    if gap.is_beyond_noise:
        gap = replace(gap, left_open=float(left_open_rollouts(final).gaps()[1]))
    if gap.refitted <= max(gap.before, gap.noise_floor):
        return gap, False
    stays = not (added(final) or final.laws)
    kinds = ("refitted", "after") if stays else ("refitted",)
    coordinates, horizons = (
        {of: one | dict.fromkeys(kinds, one["before"]) for of, one in table.items()}
        for table in (gap.per_coordinate, gap.per_horizon)
    )
    return Gap(**horizons["1 s"], per_coordinate=coordinates, per_horizon=horizons, left_open=gap.left_open), stays


def measured_gap(nominal: Model, final: Model) -> Gap:
    """Gap of the cart as it was believed, refitted and extended. Where nothing moves, all is noise."""
    if not any(len(starts(balances)) for balances in nominal.logs):
        return _at_rest(nominal)
    rolled = {
        "before": file_rollouts(nominal),
        "refitted": held_out_rollouts(nominal),
        "after": held_out_rollouts(final),
        "noise_floor": min(floor_rollouts(nominal), floor_rollouts(final), key=lambda one: float(one.gaps()[1])),
    }
    gaps = {name: one.gaps() for name, one in rolled.items()}
    horizons = {
        f"{horizon:g} s": {name: float(gap[i]) for name, gap in gaps.items()}
        for i, horizon in enumerate(HORIZONS)
        if all(np.isfinite(gap[i]) for gap in gaps.values())
    }
    if "1 s" not in horizons:
        names = ", ".join(balances.name for balances in nominal.logs)
        raise DataError(f"{names}: simulations run away from it; look for numbers that are not in SI units")
    by = {name: one.by_coordinate()[1].tolist() for name, one in rolled.items()}
    by_coordinate = {c: {name: each[i] for name, each in by.items()} for i, c in enumerate(GAP_COORDINATES)}
    return Gap(**horizons["1 s"], per_coordinate=by_coordinate, per_horizon=horizons)


def _at_rest(model: Model) -> Gap:
    std = np.max([balances.motion.noise.pose for balances in model.logs], axis=0)
    names = ("before", "refitted", "after", "noise_floor")
    alike = dict.fromkeys(names, float(np.hypot(std[0], std[1])))
    by = {c: dict.fromkeys(names, float(s)) for c, s in zip(GAP_COORDINATES, std, strict=True)}
    return Gap(**alike, per_coordinate=by, per_horizon={"1 s": alike})
