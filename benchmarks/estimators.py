"""Estimators of others on the logs of ours: how wrong, how honest, how fast."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any

import numpy as np

from cartgrasp.effects import ViscousDrag
from cartgrasp.frames import Array
from cartgrasp.inertia import N_PHI, physical_from_phi
from cartgrasp.logs import RunLog
from cartgrasp.model import CartModel
from cartgrasp.studies.consistency import DURATION, PRIOR, drawn_cart, exact_noise
from cartgrasp.studies.estimators import HANDS, Job, drive_cart, guess
from estimation import CartFilter, PaperFilter, Prior, RegressorEstimator
from estimation.gaussian import Gaussian, normalised_square
from estimation.online.paper_filter import DIVERGED
from estimation.whole_log.identification import identify

from .report import Result, Table, number
from .sysid_peer import WINDOW, installed, rolled_out
from .textbook_filters import TextbookEkf, TextbookUkf

SENSORS = "usual"
NOISE = exact_noise(SENSORS)
VISCOUS = Prior(mass=PRIOR.mass, com=PRIOR.com, inertia=PRIOR.inertia)
ROUNDS_A_CART = 10
COLUMNS = ("", "mass kg", "bias kg", "CoM cm", "inertia %", "NEES / 4", "lost", "µs a row")
NOTE = f"""Carts drawn from the prior that every estimator begins with, driven in curves for {DURATION:g} s with 3 N of
noise on each of two hands; all are told the sensors' noise. Errors at the end are rms over the runs, `bias` their mean;
NEES is of (m, m dx, m dy, J) and should be 1 a dimension; `lost` are runs whose numbers were no body in the end, which
are left out of the rest. filterpy's filters have pose, velocities and parameters as their state and the wrench as an
input with its noise in Q; the paper's knows viscous drag alone, as guessed; `identify` sees whole logs at once. So
does MuJoCo's `sysid`, which rolls its model out over windows of {WINDOW:g} s from smoothed motion; it has no prior but
wide bounds, and its intervals take what is left for white noise."""


@dataclass(frozen=True, eq=False)
class Answer:
    """What a log taught of phi, or None, and how long a row took, s."""

    phi: Gaussian | None
    step_time: float


Way = Callable[[RunLog], Gaussian]


def run(rounds: int) -> Result:
    """A cart every ROUNDS_A_CART."""
    carts = max(1, rounds // ROUNDS_A_CART)
    begin = os.getloadavg()[0]
    answers: dict[str, list[Answer]] = {name: [] for name in _ways()}
    truths = []
    for seed in range(carts):
        cart = drawn_cart(seed)
        log = drive_cart(cart, Job("curves", SENSORS, seed), DURATION).log
        truths.append(cart.inertia.phi)
        for name, way in _ways().items():
            answers[name].append(_timed(way, log))
    rows = tuple(_row(name, found, np.array(truths)) for name, found in answers.items())
    load = begin, os.getloadavg()[0]
    return Result("Estimators", NOTE, (Table("Same logs", COLUMNS, rows, load, carts),))


def _ways() -> dict[str, Way]:
    arms = list(HANDS)
    ways: dict[str, Way] = {
        "CartFilter": lambda log: _learned(log, CartFilter(guess(), arms, noise=NOISE, prior=PRIOR)),
        "RegressorEstimator": lambda log: _learned(log, RegressorEstimator(guess(), arms, noise=NOISE, prior=PRIOR)),
        "identify": _identified,
        "PaperFilter": lambda log: _literal(log, PaperFilter(_viscous(), arms, noise=NOISE, prior=VISCOUS)),
    }
    if find_spec("filterpy") is not None:
        ways["filterpy EKF"] = lambda log: _textbook(log, TextbookEkf(guess(), arms, NOISE, PRIOR))
        ways["filterpy UKF"] = lambda log: _textbook(log, TextbookUkf(guess(), arms, NOISE, PRIOR))
    if installed():
        ways["MuJoCo sysid"] = lambda log: rolled_out(log, guess())
    return ways


def _viscous() -> CartModel:
    cart = guess()
    return CartModel(cart.inertia, cart.constraints, tuple(e for e in cart.effects if isinstance(e, ViscousDrag)))


def _learned(log: RunLog, online: Any) -> Gaussian:
    for measurement in log.measurements():
        last = online.update(measurement)
    return Gaussian(last.model_parameters[:N_PHI], last.covariance[:N_PHI, :N_PHI])


def _identified(log: RunLog) -> Gaussian:
    found = identify([log], guess(), noise=NOISE, prior=PRIOR)
    return Gaussian(found.model_parameters[:N_PHI], found.covariance[:N_PHI, :N_PHI])


def _literal(log: RunLog, online: PaperFilter) -> Gaussian:
    for measurement in log.measurements():
        last = online.update(measurement)
    ok = last.health != DIVERGED
    return Gaussian(online._mean[6:] if ok else np.full(N_PHI, np.nan), online._covariance[6:, 6:])


def _textbook(log: RunLog, online: TextbookEkf | TextbookUkf) -> Gaussian:
    for measurement in log.measurements():
        online.update(measurement)
    return Gaussian(np.full(N_PHI, np.nan), np.eye(N_PHI)) if online.diverged else online.phi


def _timed(way: Way, log: RunLog) -> Answer:
    begin = time.process_time()
    with np.errstate(all="ignore"):
        phi = way(log)
    spent = (time.process_time() - begin) / len(log)
    m, mx, my, J = phi.mean
    physical = bool(np.isfinite(phi.mean).all() and m > 0 and J * m > mx**2 + my**2)
    return Answer(phi if physical else None, spent)


def _row(name: str, answers: list[Answer], truths: Array) -> tuple[str, ...]:
    kept = [i for i, answer in enumerate(answers) if answer.phi is not None]
    time_cell = number(1e6 * float(np.median([answer.step_time for answer in answers])))
    lost = f"{len(answers) - len(kept)} of {len(answers)}"
    if not kept:
        return name, *["-"] * 5, lost, time_cell
    found = [answers[i].phi for i in kept]
    mean, covariance = (np.array([getattr(phi, part) for phi in found]) for part in ("mean", "covariance"))
    nees = normalised_square(mean - truths[kept], covariance) / N_PHI
    true = np.array([physical_from_phi(phi) for phi in truths[kept]])
    off = np.array([physical_from_phi(phi) for phi in mean]) - true
    rms = np.sqrt((off**2).mean(axis=0))
    inertia = 100 * np.sqrt(((off[:, 3] / true[:, 3]) ** 2).mean())
    com = 100 * float(np.hypot(rms[1], rms[2]))
    sizes = f"{rms[0]:.2f}", f"{off[:, 0].mean():+.2f}", f"{com:.1f}", f"{inertia:.1f}"
    return name, *sizes, number(float(nees.mean())), lost, time_cell
