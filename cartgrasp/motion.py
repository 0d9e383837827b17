"""The values that flow round the closed loop."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from .checks import brief, digits
from .frames import Array
from .inertia import N_PHI, physical_jacobian

if TYPE_CHECKING:
    from .model import CartModel


class Motion(NamedTuple):
    """Pose (..., 3) of {b} in {s} and free velocities nu (..., n_free) of the cart; and, where somebody follows it,
    what its effects remember (..., k)."""

    pose_sb: Array
    velocity: Array
    memory: Array | None = None


@dataclass(frozen=True)
class Reference:
    """Where the cart should be: pose of {b} in {s}, nu and its rate. It obeys the rolling constraints."""

    time: float
    pose_sb: Array
    velocity: Array
    acceleration: Array


@dataclass(frozen=True)
class Measurement:
    """What was sensed at a time. Any part may be missing: None, an absent arm, or NaN.

    Args:
        time: s.
        pose: (x, y, theta) of {b} in {s}, m and rad.
        velocity: (vx, vy, omega) of {b}'s origin in {s}, m/s and rad/s.
        wrenches: What arms do to the cart, (6,) in {a}, N and N·m, by arm.
        contacts: Where they hold, (3,) in {b}, m, by arm.

    Example:
        >>> import cartgrasp as cg
        >>> push = cg.Measurement(0.5, wrenches={"left": [20, 0, 0, 0, 0, 0]}, contacts={"left": [-0.25, 0.2, 1.0]})
        >>> push.pose is None
        True
    """

    time: float
    pose: Array | None = None
    velocity: Array | None = None
    wrenches: Mapping[str, Array] = field(default_factory=dict)
    contacts: Mapping[str, Array] = field(default_factory=dict)


@dataclass(frozen=True)
class ParameterEstimate:
    """One parameter in SI units; `identifiable` says whether the motion so far taught it, which it can't have where the
    model does not fit it."""

    value: float
    std: float
    unit: str
    identifiable: bool

    def __repr__(self) -> str:
        """± is one standard deviation."""
        taught = "" if self.identifiable else ", not taught"
        return f"{digits(self.value)} ± {self.std:.2g} {self.unit}{taught}"


@dataclass(frozen=True, eq=False)
class Disturbance:
    """What pushes the cart beside all that its model explains: the reduced wrench `Sᵀ wrench_b` (k,) and its covariance
    (k, k). It `acts` where that can be neither noise, nor wrong parameters, nor a usual load that was put on."""

    wrench: Array
    covariance: Array
    acts: bool = False

    @property
    def std(self) -> Array:
        """(k,), N and N·m."""
        return np.sqrt(np.diagonal(self.covariance))

    @property
    def words(self) -> str:
        """± is one standard deviation; the last of several is the moment."""
        units = ["N"] if len(self.wrench) == 1 else [*["N"] * (len(self.wrench) - 1), "N·m"]
        parts = zip(self.wrench.tolist(), self.std.tolist(), units, strict=True)
        return ", ".join(f"{value:.0f} ± {std:.0f} {unit}" for value, std, unit in parts).replace("-", "−")


class Estimate(NamedTuple):
    """What an estimator knows at `time`: the motion, the parameters by name, and its own health. `structure` is the
    cart it was made for, `model_parameters` (p,) are that model's numbers as now estimated, `covariance` (p, p) is
    theirs (None where an estimator has none). `suspicions` tell of sensors that don't seem to mean what they say: each
    has a `kind`, `where`, a `probability` and `words`. `disturbance` is what pushes beside all that is known, where
    somebody looks for it; `floor` (4,) are the numbers of an `UnknownSlope`, where that is learned beside the cart, and
    `covariance_on_floor` (p + 4, p + 4) is that of both."""

    time: float
    motion: Motion
    parameters: Mapping[str, ParameterEstimate]
    health: str
    structure: CartModel
    model_parameters: Array
    covariance: Array | None = None
    suspicions: tuple[Any, ...] = ()
    disturbance: Disturbance | None = None
    floor: Array | None = None
    covariance_on_floor: Array | None = None

    def __repr__(self) -> str:
        pose, velocity = (digits(part.tolist()) for part in self.motion[:2])
        seen = brief(
            "Estimate", f"t = {digits(self.time)} s", f"health: {self.health}", f"pose {pose}", f"nu {velocity}"
        )
        told = "; ".join(f"{name} {one!r}" for name, one in self.parameters.items())
        acts = self.disturbance is not None and self.disturbance.acts
        pushed = [f"pushed by {self.disturbance.words} that are not explained"] if acts and self.disturbance else []
        return "\n  ".join([seen, told, *pushed, *[one.words for one in self.suspicions]])

    def cart(self) -> CartModel:
        """The cart as now estimated. On a rail only the mass is: CoM and inertia per mass are those of the first
        guess."""
        return self.structure.with_parameters(self._parameters)

    def cart_on_floor(self) -> CartModel:
        """The cart as now estimated, on a floor that slopes as now estimated."""
        if self.floor is None:
            return self.cart()
        on_slope: CartModel = self.structure.on_slope
        return on_slope.with_parameters(np.append(self._parameters, self.floor))

    @property
    def _parameters(self) -> Array:
        """Those of `cart` (p,)."""
        parameters = self.model_parameters
        if not self.structure.constraints.no_rotation:
            return parameters
        first = self.structure.inertia.phi
        return np.append(first * (parameters[0] / first[0]), parameters[N_PHI:])

    @property
    def com_covariance(self) -> Array | None:
        """(2, 2), m², of the CoM in {b}; None where no covariance is known."""
        if self.covariance is None:
            return None
        partials = physical_jacobian(self.model_parameters[:N_PHI])[1:3]
        return partials @ self.covariance[:N_PHI, :N_PHI] @ partials.T
