"""The excitation study in numbers, and what it claims."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from planning.excitation.excitation_choice import D_OPTIMAL, Allowance

from ..frames import Array
from ..inertia import physical_jacobian
from ..information import phi_covariance
from .claims import Claim
from .excitation import (
    ALLOWANCES,
    CHOSEN_WAY,
    E_MOTION,
    FIXED_WAY,
    PERIODIC_WAY,
    PHYSICAL_PARAMETERS,
    Drive,
    excitation,
    plan_information,
    scenario,
    way_information,
)

COLUMNS = ("way", *PHYSICAL_PARAMETERS, "effort N²·s", "tracking cm")
PRICE_COLUMNS = ("allowed N²", "weave cm", *PHYSICAL_PARAMETERS, "effort N²·s")
PRICED_ALLOWANCES = (
    Allowance(0.0, 0.0, D_OPTIMAL),
    *(Allowance(effort, 0.03, D_OPTIMAL) for effort in (3.0, 10.0, 30.0, 100.0)),
)
MAX_STD_RATIO, MAX_ERROR_SIGMAS = 1.5, 3.0


def bounds(way: str) -> Array:
    """Cramér-Rao bounds (4,) of mass, CoM and inertia at the end, by the information of the way's own reference."""
    return _bounds(way_information(way))


def _bounds(information: Array) -> Array:
    jacobian = physical_jacobian(scenario(FIXED_WAY, 0).truth.inertia.phi)
    return np.asarray(np.sqrt(np.diag(jacobian @ phi_covariance(information) @ jacobian.T)))


def price_rows() -> list[tuple[str, ...]]:
    """By allowance (criterion D): what is foretold, and the whole effort as planned from the first guess."""
    found = []
    for allowance in PRICED_ALLOWANCES:
        plan = excitation(allowance)
        effort = sum(w.effort * (w.window[1] - w.window[0]) for w in plan.windows)
        cells = (f"{allowance.effort:g}", f"{100 * allowance.offset:g}")
        found.append((*cells, *(f"{sd:.3g}" for sd in _bounds(plan_information(plan))), f"{effort:.0f}"))
    return found


def rows(drives: Sequence[Drive]) -> list[tuple[str, ...]]:
    """By way: the filter's standard deviations at the end, effort paid, largest tracking error from 5 s on."""
    return [
        (
            drive.way,
            *(f"{sd:.3g}" for sd in _last(drive)),
            f"{drive.effort[-1]:.0f}",
            f"{100 * drive.tracking_error:.2f}",
        )
        for drive in drives
    ]


def claims(drives: Sequence[Drive]) -> list[Claim]:
    by_way = {drive.way: drive for drive in drives}
    fixed, periodic, contacts, motion = (_last(by_way[way]) for way in (FIXED_WAY, PERIODIC_WAY, CHOSEN_WAY, E_MOTION))
    x, inertia = contacts[[1, 3]] / fixed[[1, 3]]
    gains = motion / np.minimum(fixed, periodic)
    ratios = np.array([_last(drive) / bounds(drive.way) for drive in drives])
    worst = max(_root_mean_square(d.errors(name)) / d.std(name)[-1] for d in drives for name in PHYSICAL_PARAMETERS)
    spent = max(w.effort - w.least_effort - a.effort for a in ALLOWANCES.values() for w in excitation(a).windows)
    return [
        Claim(
            CHOSEN_WAY,
            "sd of CoM x and of inertia at most 0.6 of fixed contacts', on the same path",
            f"{x:.2f}, {inertia:.2f}",
            bool(max(x, inertia) <= 0.6),
        ),
        Claim(
            E_MOTION,
            "every sd below both fixed and periodic contacts'",
            "at most " + f"{gains.max():.2f} of them",
            bool(gains.max() < 1.0),
        ),
        Claim(
            "Fisher information",
            f"foretells every sd of the filter within a factor {MAX_STD_RATIO:g}",
            f"{ratios.min():.2f} to {ratios.max():.2f}",
            bool(ratios.max() <= MAX_STD_RATIO and ratios.min() >= 1 / MAX_STD_RATIO),
        ),
        Claim(
            "errors",
            f"at most {MAX_ERROR_SIGMAS:g} sd (rms over seeds)",
            f"{worst:.2f} sd",
            bool(worst <= MAX_ERROR_SIGMAS),
        ),
        Claim(
            "effort",
            "no window plans more than the allowance beyond the least",
            f"{spent:+.2g} N² against it",
            bool(spent <= 1e-6),
        ),
    ]


def as_dict(drive: Drive) -> dict[str, object]:
    """For `--json`."""
    foretold = bounds(drive.way).tolist()
    return {
        "way": drive.way,
        "std": dict(zip(PHYSICAL_PARAMETERS, _last(drive).tolist(), strict=True)),
        "bound": dict(zip(PHYSICAL_PARAMETERS, foretold, strict=True)),
        "rms_error": {name: _root_mean_square(drive.errors(name)) for name in PHYSICAL_PARAMETERS},
        "effort": float(drive.effort[-1]),
        "tracking_error": drive.tracking_error,
    }


def _last(drive: Drive) -> Array:
    return np.array([drive.std(name)[-1] for name in PHYSICAL_PARAMETERS])


def _root_mean_square(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
