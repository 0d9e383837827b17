"""`PROBLEM.yaml` of `cartgrasp plan`: strict to read, exact about places."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from ruamel.yaml.comments import CommentedMap

from cartgrasp.arms import Arm
from cartgrasp.cart_file import cart_from_document, load_cart
from cartgrasp.contacts import ContactSet
from cartgrasp.errors import FileError, UsageError
from cartgrasp.first_guess import PHYSICAL_NAMES
from cartgrasp.frames import Array
from cartgrasp.inertia import physical_jacobian
from cartgrasp.model import CartModel
from cartgrasp.motion import Estimate, Motion
from cartgrasp.yaml_file import file_error, read_yaml, validate

from ..limits import CartLimit
from ..objectives import Objective
from ..plan import Plan
from ..planner import WrenchPlanner
from .problem_arms import arms_of
from .problem_limits import cart_limits_of
from .problem_objective import objective_of
from .problem_schema import ArmEntry, ConfidenceEntry, ProblemEntry
from .refusing import Refuse, refusing


@dataclass(frozen=True)
class Problem:
    """A cart, its arms, and the wrench (fx, fy, tau) wanted on the cart in {b}; `last` are the wrenches (6,) by arm
    that rates of change count from, one `period` (s) ago, `held` the contacts (3,) that the cost of switching does.
    `estimate` is the cart as it moves and as well as it is known, where the file says so."""

    cart: CartModel
    arms: tuple[Arm, ...]
    wrench: tuple[float, float, float]
    min_hand_distance: float
    cart_limits: tuple[CartLimit, ...]
    relax: float
    period: float
    last: Mapping[str, Sequence[float]]
    switching_cost: float
    held: Mapping[str, Sequence[float]]
    objective: Objective
    confidence: float | None
    estimate: Estimate | None
    solver: str | None

    def plan(self) -> Plan:
        return self.planner().plan(self.wrench, estimate=self.estimate)

    def planner(self) -> WrenchPlanner:
        planner = WrenchPlanner(
            self.cart,
            self.arms,
            objective=self.objective,
            confidence=self.confidence,
            cart_limits=self.cart_limits,
            min_hand_distance=self.min_hand_distance,
            relax=self.relax,
            switching_cost=self.switching_cost,
            period=self.period,
            solver=self.solver,
        )
        planner.start_from(self.last, self.held)
        return planner


def read_problem(path: str | os.PathLike[str]) -> Problem:
    """A mistake is refused as `file:line:column: key: why`."""
    document, name = read_yaml(path), str(path)
    entry = validate(ProblemEntry, document, name)

    def refuse(location: list[str | int], why: str) -> FileError:
        return file_error(document, name, location, why)

    arms = arms_of(entry.arms, ["arms"], Path(path).parent, refuse)
    fx, fy, tau = entry.wrench
    cart = _cart(entry.cart, document, Path(path), refuse)
    return Problem(
        cart=cart,
        arms=tuple(arms),
        wrench=(fx, fy, tau),
        min_hand_distance=entry.min_hand_distance,
        cart_limits=cart_limits_of(entry.cart_limits, (cart, arms), ["cart_limits"], refuse),
        relax=entry.relax,
        period=entry.period,
        last={arm.name: arm.rate.last for arm in entry.arms if arm.rate is not None},
        switching_cost=entry.switching_cost,
        held=_held(entry.arms, refuse),
        objective=objective_of(entry.objective, (cart, arms), refuse),
        confidence=None if entry.confidence is None else entry.confidence.probability,
        estimate=_estimate(entry, cart, refuse),
        solver=_solver(entry.solver, refuse),
    )


def _cart(entry: Any, document: CommentedMap, path: Path, refuse: Refuse) -> CartModel:
    if isinstance(entry, str):
        return load_cart(path.parent / entry)
    if isinstance(entry, dict):
        return cart_from_document(document["cart"], str(path), ["cart"])
    raise refuse(["cart"], f"{entry!r} is neither the path of a cart file nor a mapping")


def _solver(name: str | None, refuse: Refuse) -> str | None:
    if name is None:
        return None
    from ..solvers.named_solver import check_installed  # imports qpsolvers

    try:
        return check_installed(name)
    except UsageError as error:
        raise refuse(["solver"], str(error).removeprefix("solver: ")) from error


def _held(entries: Sequence[ArmEntry], refuse: Refuse) -> dict[str, Sequence[float]]:
    held: dict[str, Sequence[float]] = {}
    for i, entry in enumerate(entries):
        if entry.held is not None:
            x, y, z = entry.held
            with refusing(refuse, "arms", i, "held"):
                held[entry.name] = ContactSet(((x, y, z),)).points[0]
    return held


def _estimate(entry: ProblemEntry, cart: CartModel, refuse: Refuse) -> Estimate | None:
    """What a filter would give of the motion and confidence that the file states; None where it states neither."""
    if entry.motion is None and entry.confidence is None:
        return None
    names = cart.constraints.velocity_names
    pose, velocity = np.zeros(3), np.zeros(len(names))
    if entry.motion is not None:
        pose, velocity = np.array(entry.motion.pose), np.array(entry.motion.velocity)
        if len(velocity) != len(names):
            why = f"{len(velocity)} numbers, but this cart moves freely in {', '.join(names)}"
            raise refuse(["motion", "velocity"], why)
    covariance = None if entry.confidence is None else _covariance(entry.confidence, cart, refuse)
    return Estimate(0.0, Motion(pose, velocity), {}, "", cart, cart.parameters, covariance)


def _covariance(entry: ConfidenceEntry, cart: CartModel, refuse: Refuse) -> Array:
    """Covariance (p, p) of the model's parameters, from independent standard deviations of mass, CoM, inertia and the
    effects' values."""
    names = (*PHYSICAL_NAMES, *cart.parameter_names[len(PHYSICAL_NAMES) :])
    for name in entry.std:
        if name not in names:
            raise refuse(["confidence", "std", name], f"this cart has no parameter {name}; it has {', '.join(names)}")
    to_phi = np.eye(len(names))
    to_phi[:4, :4] = np.linalg.inv(physical_jacobian(cart.inertia.phi))
    root = to_phi * [entry.std.get(name, 0.0) for name in names]
    return np.asarray(root @ root.T)
