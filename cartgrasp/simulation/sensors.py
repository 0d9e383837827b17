"""Sensors: seeded noise, own sample times, and what sensor effects do to recorded wrenches, poses and velocities."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass

import numpy as np

from ..checks import check_kind, number
from ..contacts import ContactWrenches
from ..effects.effect import HAND_AT_REST, HandMotion
from ..frames import Array, body_to_world
from ..model import CartModel
from ..motion import Measurement, Motion
from ..tracked_point import carried, composed, inverted


@dataclass(frozen=True)
class AppliedWrenches:
    """What arms gave at a time (s): wrenches (6,) in {a}, and how their hands moved."""

    time: float
    wrenches: Mapping[str, Array]
    hands: Mapping[str, HandMotion]


@dataclass(frozen=True)
class SensorNoise:
    """Standard deviations of white noise, and sample times (s; 0: at every control step).

    Args:
        position: m.
        heading: rad.
        linear_velocity: m/s.
        yaw_rate: rad/s.
        force: N, of each axis.
        moment: N·m, of each axis.
        pose_period: s.
        velocity_period: s; None: no velocity is measured.
        wrench_period: s.
    """

    position: float = 0.0004
    heading: float = 0.0004
    linear_velocity: float = 0.005
    yaw_rate: float = 0.005
    force: float = 3.0
    moment: float = 0.1
    pose_period: float = 0.0
    velocity_period: float | None = 0.0
    wrench_period: float = 0.0

    def __post_init__(self) -> None:
        for what, value in asdict(self).items():
            if value is not None:
                number(f"sensor noise: {what}", value, 0.0)


class Sensors:
    """Turns the truth into measurements.

    Args:
        cart: The truth, whose sensor effects act on what is recorded.
        noise: Beside these.
        seed: The same one gives the same numbers.

    Example:
        >>> import cartgrasp as cg
        >>> from cartgrasp.simulation import ModelPlant, SensorNoise, Sensors
        >>> cart = cg.load_cart("cart.yaml")
        >>> robot, sensors = ModelPlant(cart), Sensors(cart, SensorNoise(), seed=1)
        >>> sensors.motion(robot.time, robot.motion).pose.round(4).tolist()
        [0.0001, 0.0003, 0.0001]
    """

    def __init__(self, cart: CartModel, noise: SensorNoise, seed: int = 0) -> None:
        check_kind("sensors: cart", cart, CartModel, 'load it first: load_cart("cart.yaml")')
        check_kind("sensors: noise", noise, SensorNoise, "write SensorNoise(force=0.5)")
        check_kind("sensors: seed", seed, (int, np.integer), "give a whole number")
        self.cart, self.noise = cart, noise
        self._random = np.random.default_rng(seed)
        self._due = {"pose": 0.0, "velocity": 0.0, "wrench": 0.0}
        self._latest = sum(effect.lateness for effect, _ in cart.sensor_effects)
        self._pose_bt = inverted(cart.pose_tb)
        self._motion: Motion | None = None
        self._felt: list[AppliedWrenches] = []

    def motion(self, time: float, motion: Motion) -> Measurement:
        """Pose and velocity, where they are due."""
        n, draw = self.noise, self._random.standard_normal
        pose = velocity = None
        self._motion = motion
        if self._is_due("pose", time, n.pose_period):
            pose = composed(motion.pose_sb, self._pose_bt) + draw(3) * [n.position, n.position, n.heading]
        if self._is_due("velocity", time, n.velocity_period):
            velocity_b = self.cart.basis_b @ motion.velocity
            velocity = body_to_world(motion.pose_sb[2]) @ velocity_b
            velocity = carried(velocity, motion.pose_sb[2], self._pose_bt[:2])
            velocity = velocity + draw(3) * [n.linear_velocity, n.linear_velocity, n.yaw_rate]
        return Measurement(time, pose, velocity)

    def wrenches(self, time: float, wrenches: ContactWrenches, acceleration: Array | None = None) -> Measurement:
        """Wrenches as recorded, where they are due, and where the arms hold; what holds nothing is known to give
        nothing, without noise. `acceleration` is that of the cart's free velocities (n_free,) at the motion that was
        sensed last; None where no sensor feels it."""
        recorded = {}
        self._felt.append(AppliedWrenches(time, wrenches.wrenches, self._hands(wrenches, acceleration)))
        if self._is_due("wrench", time, self.noise.wrench_period):
            scale = np.repeat([self.noise.force, self.noise.moment], 3)
            for arm in wrenches.wrenches:
                wrench_a, hand = self._felt_at(time - self.cart.lateness(arm), arm)
                told = self.cart.recorded_wrench(arm, wrench_a, hand=hand)
                noise = self._random.standard_normal(6) * scale
                recorded[arm] = told if arm in wrenches.away else told + noise
        self._forget(time - self._latest)
        return Measurement(time, wrenches=recorded, contacts=dict(wrenches.contacts))

    def _hands(self, given: ContactWrenches, acceleration: Array | None) -> dict[str, HandMotion]:
        if acceleration is None or self._motion is None:
            return {}
        nu, yaws = self._motion.velocity, given.yaws
        return {
            arm: self.cart.hand_motion(nu, acceleration, contact, yaws.get(arm, 0.0))
            for arm, contact in given.contacts.items()
            if arm not in given.away
        }

    def _felt_at(self, time: float, arm: str) -> tuple[Array, HandMotion]:
        """The wrench (6,) that an arm gave, held from sample to sample, and its hand's motion; 0, at rest, before it
        held the cart."""
        given = [felt for felt in self._felt if felt.time <= time + 1e-9]
        if not given:
            return np.zeros(6), HAND_AT_REST
        return given[-1].wrenches.get(arm, np.zeros(6)), given[-1].hands.get(arm, HAND_AT_REST)

    def _forget(self, time: float) -> None:
        """What is older than the sample that held at a time."""
        while len(self._felt) > 1 and self._felt[1].time <= time + 1e-9:
            self._felt.pop(0)

    def _is_due(self, what: str, time: float, period: float | None) -> bool:
        if period is None or time < self._due[what] - 1e-9:
            return False
        if period:
            missed = (time + 1e-9 - self._due[what]) // period  # where nobody asked in time
            self._due[what] += (1.0 + missed) * period
        return True
