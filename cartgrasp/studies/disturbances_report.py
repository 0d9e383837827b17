"""The study of disturbances in numbers, and what it claims."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from .disturbances import CONTROL_PERIOD, DISTURBANCE_KINDS, OURS, WAYS, Outcome
from .findings import Claim, Findings, Section

COLUMNS = (
    *("kind", "way", "rms mm", "peak mm", "rms mrad", "peak mrad", "over 1 cm s", "rms force N"),
    *("mass off %", "within 2 %", "fell"),
)
RECOVERED_DISTANCE = 0.01
"""m: while the cart is farther from its path it has not recovered."""
MAX_PEER_RATIO, MASS_TOLERANCE = 0.7, 0.02


@dataclass(frozen=True)
class Merit:
    """Over the runs of a kind and a way that did not tip over: mm and mrad; s for which a run was beyond
    RECOVERED_DISTANCE; N; the median of the largest error of the mass (%, NaN where none is learned), the share of runs
    within MASS_TOLERANCE (%); how many fell."""

    rms: float
    peak: float
    turned_rms: float
    turned_peak: float
    far: float
    force: float
    mass: float
    kept: float
    fell: int

    @classmethod
    def of(cls, outcomes: Sequence[Outcome]) -> Merit:
        stood = [one for one in outcomes if not one.fell]
        if not stood:
            nan = math.nan
            return cls(nan, nan, nan, nan, nan, nan, nan, nan, len(outcomes))
        masses = np.array([one.mass_error for one in stood])
        return cls(
            rms=1e3 * _rms([one.position for one in stood]),
            peak=1e3 * float(np.mean([one.position.max() for one in stood])),
            turned_rms=1e3 * _rms([one.heading for one in stood]),
            turned_peak=1e3 * float(np.mean([one.heading.max() for one in stood])),
            far=float(np.mean([CONTROL_PERIOD * (one.position > RECOVERED_DISTANCE).sum() for one in stood])),
            force=_rms([one.force for one in stood]),
            mass=100 * float(np.median(masses)),
            kept=100 * float((masses <= MASS_TOLERANCE).mean()),
            fell=len(outcomes) - len(stood),
        )

    @property
    def errors(self) -> tuple[float, float, float, float]:
        return self.rms, self.peak, self.turned_rms, self.turned_peak


def _rms(parts: Sequence[np.ndarray]) -> float:
    return float(np.sqrt(np.mean(np.concatenate(parts) ** 2)))


def merit(outcomes: Sequence[Outcome], kind: str, way: str) -> Merit:
    return Merit.of([one for one in outcomes if (one.case.kind, one.way) == (kind, way)])


def rows(outcomes: Sequence[Outcome]) -> list[tuple[str, ...]]:
    """By kind and way; "-" where nothing is learned."""
    found = []
    for kind, way in product(DISTURBANCE_KINDS, WAYS):
        m = merit(outcomes, kind, way)
        numbers = [f"{value:.1f}" for value in m.errors] + [f"{m.far:.2f}", f"{m.force:.0f}"]
        masses = ["-", "-"] if math.isnan(m.mass) else [f"{m.mass:.1f}", f"{m.kept:.0f} %"]
        found.append((kind, way, *numbers, *masses, str(m.fell)))
    return found


def claims(outcomes: Sequence[Outcome]) -> list[Claim]:
    found = []
    for kind in DISTURBANCE_KINDS:
        ours = merit(outcomes, kind, OURS)
        best = np.nanmin([merit(outcomes, kind, way).errors for way in WAYS if way != OURS], axis=0)
        shares = np.array(ours.errors) / best
        position = f"rms and peak of position are {MAX_PEER_RATIO} of the best peer's at most"
        for words, pair in ((position, shares[:2]), ("and of heading", shares[2:])):
            told = " and ".join(f"{share:.2f}" for share in pair)
            found.append(Claim(kind, words, told, bool((pair <= MAX_PEER_RATIO).all())))
        found.append(Claim(kind, "the mass stays within 2 %", f"in {ours.kept:.0f} % of the runs", ours.kept == 100.0))
    return found


def findings(outcomes: Sequence[Outcome]) -> Findings:
    promised = claims(outcomes)
    title = "Errors from the first disturbance on: rms over the runs, and the mean of their peaks"
    sections = [Section(title, COLUMNS, rows(outcomes), left=2), Section.of_claims("Claims", promised)]
    return Findings("Disturbances", sections, {"outcomes": [as_dict(one) for one in outcomes]}, promised)


def as_dict(outcome: Outcome) -> dict[str, object]:
    """For `--json`."""
    m = Merit.of([outcome])
    numbers = {name: None if math.isnan(value) else value for name, value in vars(m).items()}
    return {"kind": outcome.case.kind, "seed": outcome.case.seed, "way": outcome.way, **numbers}
