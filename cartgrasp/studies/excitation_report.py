"""The excitation study in numbers, claims and a figure: what each way of driving learned, and what it paid."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from planning.excitation.excitation_choice import D_OPTIMAL, Allowance

from ..first_guess import PHYSICAL_NAMES
from ..frames import Array
from ..inertia import physical_jacobian
from ..information import phi_covariance
from ..view.plots import OKABE_ITO, house_style
from .excitation import (
    ALLOWANCES,
    CHOSEN_WAY,
    E_MOTION,
    FIXED_WAY,
    PERIODIC_WAY,
    Drive,
    excitation,
    information_along,
    scenario,
    way_information,
)
from .findings import Claim, Findings, Section

COLUMNS = ("way", *PHYSICAL_NAMES, "effort N²·s", "tracking cm")
PRICE_COLUMNS = ("allowed N²", "weave cm", *PHYSICAL_NAMES, "effort N²·s")
PRICED_ALLOWANCES = (
    Allowance(0.0, 0.0, D_OPTIMAL),
    *(Allowance(effort, 0.03, D_OPTIMAL) for effort in (3.0, 10.0, 30.0, 100.0)),
)
MAX_STD_RATIO, MAX_ERROR_SIGMAS = 1.5, 3.0
LABELS = {"mass": "mass (kg)", "com_x": "CoM x (m)", "com_y": "CoM y (m)", "inertia": "inertia (kg·m²)"}
STYLES = ("-", "--", "-.", "-", ":")


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
        allowed = (f"{allowance.effort:g}", f"{100 * allowance.offset:g}")
        deviations = (f"{sd:.3g}" for sd in _bounds(information_along(plan.reference, plan)))
        found.append((*allowed, *deviations, f"{effort:.0f}"))
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
    worst = max(_root_mean_square(d.errors(name)) / d.std(name)[-1] for d in drives for name in PHYSICAL_NAMES)
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
            f"at most {gains.max():.2f} of them",
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


def findings(drives: Sequence[Drive]) -> Findings:
    promised = claims(drives)
    allowances = "What an allowance buys: standard deviations foretold (criterion D; kg, m, m, kg·m²)"
    sections = [
        Section("Standard deviations at the end (kg, m, m, kg·m²)", COLUMNS, rows(drives)),
        Section(allowances, PRICE_COLUMNS, price_rows()),
        Section.of_claims("Claims", promised),
    ]
    return Findings("Excitation", sections, {"ways": [as_dict(drive) for drive in drives]}, promised)


def as_dict(drive: Drive) -> dict[str, object]:
    """For `--json`."""
    foretold = bounds(drive.way).tolist()
    return {
        "way": drive.way,
        "std": dict(zip(PHYSICAL_NAMES, _last(drive).tolist(), strict=True)),
        "bound": dict(zip(PHYSICAL_NAMES, foretold, strict=True)),
        "rms_error": {name: _root_mean_square(drive.errors(name)) for name in PHYSICAL_NAMES},
        "effort": float(drive.effort[-1]),
        "tracking_error": drive.tracking_error,
    }


def _last(drive: Drive) -> Array:
    return np.array([drive.std(name)[-1] for name in PHYSICAL_NAMES])


def _root_mean_square(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _draw_ways(axes: Axes, drives: Sequence[Drive], values: Sequence[Array], label: str) -> None:
    """Values (n,) of each way against time."""
    for i, (drive, line) in enumerate(zip(drives, values, strict=True)):
        axes.plot(drive.time, line, STYLES[i], color=OKABE_ITO[i], label=drive.way)
    axes.set(xlabel="Time (s)", ylabel=label)


def _off_path(drive: Drive, base: Array) -> Array:
    """How far left (n,), cm, of the undeviated reference the cart was driven, in its frame."""
    off = drive.records[0].pose[:, :2] - base[:, :2]
    return np.asarray(100.0 * (off[:, 1] * np.cos(base[:, 2]) - off[:, 0] * np.sin(base[:, 2])))


def figure(drives: Sequence[Drive]) -> Figure:
    """A page: each parameter's standard deviation, the effort, and how far off the path."""
    with house_style():
        page = Figure(figsize=(7.2, 5.6), layout="constrained")
        axes = page.subplots(3, 2).ravel()
        for panel, parameter in zip(axes, PHYSICAL_NAMES, strict=False):
            _draw_ways(panel, drives, [drive.std(parameter) for drive in drives], f"sd of {LABELS[parameter]}")
            panel.set_yscale("log")
        _draw_ways(axes[4], drives, [drive.effort for drive in drives], "Effort paid (N²·s)")
        base = drives[0].records[0].reference_pose
        _draw_ways(axes[5], drives, [_off_path(drive, base) for drive in drives], "Left of the path (cm)")
        page.legend(*axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=5)
    return page
