"""A cart as MuJoCo sees it: chassis, fixed wheels, casters with forks, effects as MuJoCo's own mechanisms; laws, which
name no mechanism, push from outside (`mujoco_plant.py`).

The chassis frame is {b}. Each wheel is a sphere that touches the floor in one point, so that it doesn't
scrub when it turns on the spot; a caster's fork swivels at its pivot and the wheel trails it. Wheels and
forks are light, a fork balances its wheel about the pivot, and the chassis makes up the rest: mass, CoM and
yaw inertia of the whole are the cart's at every heading. Only the spin of a wheel comes on top: half its
mass (0.1 % of the cart's for four wheels) resists being pushed forward.

The floor is equally stiff under every wheel, so at rest loads are those of `wheels.py` with a caster's load
at its patch, not its pivot. Measured for 24 kg: wheels sink 1 µm, and under 40 N from the side fixed wheels
creep 0.03 µm/s. MuJoCo's contacts look at velocities alone, so in a curve `velocity_b` shows an outward
creep of 1 ms times `u r`, half of it real: 0.5 mm/s at 1 m/s and 0.5 rad/s.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import mujoco
import numpy as np
from scipy.spatial import ConvexHull, QhullError

from ..effects import Effect, ForceEffect, LearnedForce, PayloadChange, RollingResistance, SensorEffect, ViscousDrag
from ..effects.caster_realignment import CasterRealignment
from ..errors import PlantError
from ..frames import Array
from ..inertia import Inertia
from ..model import CartModel
from ..wheels import CASTER, DEFAULT_TRAIL, FIXED, GRAVITY, Wheel, WheelSet

WHEEL_RADIUS = 0.06
"""m, of every wheel."""
DEFAULT_COM_HEIGHT = 0.5
DEFAULT_HALF_TRACK, DEFAULT_WHEELBASE = 0.27, 0.72
WHEEL_MASS_FRACTION = 0.0005
"""Mass of a wheel, and of a fork, over the mass of the cart."""
MAX_WHEEL_INERTIA_FRACTION = 0.1
"""Wheels and forks have at most this part of the yaw inertia."""
SLIDING_FRICTION = 1.5
IMPRATIO = 100.0
FLOOR_SOLREF, FLOOR_SOLIMP = (0.01, 1.0), (0.999, 0.999, 0.001, 0.5, 2.0)
"""Stiffer, and the four wheels of a rigid cart chatter; softer, and the cart leans under its load."""
FRICTION_SOLREF, FRICTION_SOLIMP = (0.002, 1.0), (0.9999, 0.9999, 0.001, 0.5, 2.0)


@dataclass(frozen=True)
class Mechanisms:
    """What effects come to: damping, friction losses, instants at which mass changes, pushes from outside."""

    linear_damping: float = 0.0
    angular_damping: float = 0.0
    rolling_coefficient: float = 0.0
    swivel_torque: float = 0.0
    scrub_torque: float = 0.0
    trail: float = 0.0
    casters_x: float = 0.0
    load_times: tuple[float, ...] = ()
    outer: tuple[ForceEffect, ...] = ()


MECHANICAL_EFFECTS: tuple[type[Effect], ...] = (
    ViscousDrag,
    RollingResistance,
    CasterRealignment,
    PayloadChange,
    LearnedForce,
)


def mechanisms_of(cart: CartModel) -> Mechanisms:
    """The cart's effects as mechanisms; sensors have none, and what has no counterpart is refused by name."""
    found = Mechanisms()
    for effect in cart.effects:
        found = _with_effect(found, effect)
    if cart.constraints.n_rows == 2 and (found.swivel_torque or found.scrub_torque):
        raise PlantError("MuJoCo plant: caster_realignment: a cart on a rail has no casters here")
    return found


def _with_effect(has: Mechanisms, effect: Effect) -> Mechanisms:
    match effect:
        case SensorEffect():
            return has
        case ViscousDrag():
            linear, angular = has.linear_damping + effect.linear, has.angular_damping + effect.angular
            return replace(has, linear_damping=linear, angular_damping=angular)
        case RollingResistance():
            return replace(has, rolling_coefficient=has.rolling_coefficient + effect.coefficient)
        case CasterRealignment():
            if (has.swivel_torque or has.scrub_torque) and (has.trail, has.casters_x) != (effect.trail, effect.x):
                why = "casters have two trails or places; give each effect the same"
                raise PlantError(f"MuJoCo plant: {effect.key}: {why}")
            swivel, scrub = has.swivel_torque + effect.swivel_torque, has.scrub_torque + effect.scrub_torque
            return replace(has, swivel_torque=swivel, scrub_torque=scrub, trail=effect.trail, casters_x=effect.x)
        case PayloadChange():
            return replace(has, load_times=tuple(sorted({*has.load_times, effect.time})))
        case LearnedForce():
            return replace(has, outer=(*has.outer, effect))
    known = ", ".join(kind.name for kind in MECHANICAL_EFFECTS)
    raise PlantError(f"MuJoCo plant: {effect.key}: no counterpart in MuJoCo; it knows {known} and sensors")


def physical_wheels(cart: CartModel, mechanisms: Mechanisms) -> tuple[Wheel, ...]:
    """The wheels to build: the listed ones or usual ones, each caster with its trail; none on a rail."""
    if cart.constraints.n_rows == 2:
        return ()
    wheels = _with_casters_at(cart.wheels or _default_wheels(cart), cart, mechanisms.casters_x)
    fixed = [w for w in wheels if w.kind == FIXED]
    axle_x = cart.constraints.axle_x
    if axle_x is None and fixed:
        raise PlantError(
            "MuJoCo plant: wheels: a fixed wheel forbids lateral slip, but the cart has no such constraint"
        )
    if axle_x is not None and not fixed:
        raise PlantError("MuJoCo plant: wheels: no_lateral_slip needs a fixed wheel, and all listed ones are casters")
    if any(abs(w.x - (axle_x or 0.0)) > 1e-9 for w in fixed):
        raise PlantError(f"MuJoCo plant: wheels: a fixed wheel stands off the axle at x = {axle_x:g} m")
    trail = mechanisms.trail
    return tuple(replace(w, trail=trail or w.trail or DEFAULT_TRAIL) if w.kind == CASTER else w for w in wheels)


def _with_casters_at(wheels: tuple[Wheel, ...], cart: CartModel, x: float) -> tuple[Wheel, ...]:
    """`x` ahead of where they stand; beside fixed wheels alone, where none is listed, one that stands for all."""
    if x == 0.0:
        return wheels
    if cart.constraints.axle_x is None or any(wheel.kind == CASTER for wheel in cart.wheels):
        return tuple(replace(w, x=w.x + x) if w.kind == CASTER else w for w in wheels)
    return (*(wheel for wheel in wheels if wheel.kind == FIXED), Wheel(CASTER, x, 0.0))


def _default_wheels(cart: CartModel) -> tuple[Wheel, ...]:
    """Fixed wheels on the axle and casters on the CoM's side of it, or four casters around the CoM."""
    axle_x, (com_x, com_y) = cart.constraints.axle_x, cart.inertia.com
    if axle_x is None:
        ends = (com_x - DEFAULT_WHEELBASE / 2, com_x + DEFAULT_WHEELBASE / 2)
        sides = (com_y + DEFAULT_HALF_TRACK, com_y - DEFAULT_HALF_TRACK)
        return tuple(Wheel(CASTER, x, y) for x in ends for y in sides)
    casters_x = axle_x + (DEFAULT_WHEELBASE if com_x >= axle_x else -DEFAULT_WHEELBASE)
    sides = (DEFAULT_HALF_TRACK, -DEFAULT_HALF_TRACK)
    return (*(Wheel(FIXED, axle_x, y) for y in sides), *(Wheel(CASTER, casters_x, y) for y in sides))


def patches(wheels: Sequence[Wheel], headings: Array) -> Array:
    """Where wheels touch the floor, (n, 2) in {b}, with the casters' headings (k,)."""
    points = np.array([[w.x, w.y] for w in wheels])
    casters = np.array([w.kind == CASTER for w in wheels])
    trail = np.array([w.trail for w in wheels if w.kind == CASTER])
    points[casters] -= trail[:, None] * np.stack([np.cos(headings), np.sin(headings)], axis=-1)
    return points


def check_stands(wheels: Sequence[Wheel], headings: Array, com: Sequence[float]) -> None:
    """Refuses a cart that tips over without being touched: its CoM must lie between the wheels' patches."""
    try:
        edges = ConvexHull(patches(wheels, headings)).equations
    except QhullError as error:
        raise PlantError("MuJoCo plant: wheels: a cart stands on at least 3 wheels, not all in one line") from error
    if (edges[:, :2] @ np.asarray(com) + edges[:, 2]).max() > 0:
        where = f"({com[0]:g}, {com[1]:g}) m"
        raise PlantError(f"MuJoCo plant: wheels: the cart tips over, its CoM at {where} is not between its wheels")


@dataclass(frozen=True)
class MujocoCart:
    """A cart with the wheels and mechanisms to build it from."""

    cart: CartModel
    wheels: tuple[Wheel, ...]
    mechanisms: Mechanisms

    @classmethod
    def of(cls, cart: CartModel) -> MujocoCart:
        mechanisms = mechanisms_of(cart)
        return cls(cart, physical_wheels(cart, mechanisms), mechanisms)

    def numbered(self, kind: str) -> tuple[tuple[int, Wheel], ...]:
        """The wheels of a kind with their places among all."""
        return tuple((i, wheel) for i, wheel in enumerate(self.wheels) if wheel.kind == kind)

    def inertia_at(self, time: float) -> Inertia:
        return Inertia.from_phi(self.cart.phi_at(time))

    def static_loads(self, time: float) -> Array:
        """Load of each wheel (n,), N; of the cart as a whole (1,) on a rail."""
        phi = self.cart.phi_at(time)
        return WheelSet(self.wheels).loads(phi) if self.wheels else GRAVITY * phi[:1]

    @property
    def wheel_mass(self) -> float:
        """Mass of a wheel, and of a fork: light, for a cart of little yaw inertia too."""
        inertia = self.cart.inertia
        far = 2 * sum((w.x - inertia.com[0]) ** 2 + (w.y - inertia.com[1]) ** 2 + w.trail**2 for w in self.wheels)
        return min(WHEEL_MASS_FRACTION * inertia.mass, MAX_WHEEL_INERTIA_FRACTION * inertia.about_com / max(far, 1e-9))

    def compile(self, time: float) -> mujoco.MjModel:
        """The cart with its load at `time`; actuators 0..5 are the wrench (6,) at {b}'s origin, in {b}."""
        spec = mujoco.MjSpec()
        _set_options(spec.option)
        floor = mujoco.mjtGeom.mjGEOM_PLANE
        spec.worldbody.add_geom(name="floor", type=floor, size=[0, 0, 1], contype=0, conaffinity=0)
        chassis = spec.worldbody.add_body(name="chassis")
        chassis.add_site(name="origin")
        for i, gear in enumerate(np.eye(6)):
            site = mujoco.mjtTrn.mjTRN_SITE
            spec.add_actuator(name=f"wrench{i}", target="origin", trntype=site, gear=gear).set_to_motor()
        self._add_base(chassis, time)
        self._set_chassis_inertia(chassis, time)
        for i, load in enumerate(self.static_loads(time)[: len(self.wheels)]):
            self._add_wheel(spec, chassis, i, load)
        model = spec.compile()
        self._set_arrays(model)
        return model

    def _add_base(self, chassis: Any, time: float) -> None:
        if self.wheels:
            chassis.add_freejoint(name="base")
            return
        rail = chassis.add_joint(name="base", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=[1, 0, 0])
        _set_friction_loss(rail, float(self.mechanisms.rolling_coefficient * self.static_loads(time).sum()))

    def _set_chassis_inertia(self, chassis: Any, time: float) -> None:
        """What wheels and forks leave of mass, CoM and yaw inertia; pitch and roll as of a square box."""
        phi, light = self.cart.phi_at(time), self.wheel_mass
        height = DEFAULT_COM_HEIGHT if self.cart.com_height is None else self.cart.com_height
        vertical = phi[0] * height
        for wheel in self.wheels:
            parts = 2 if wheel.kind == CASTER else 1
            share = Inertia(parts * light, (wheel.x, wheel.y), _own_yaw_inertia(wheel, light))
            phi, vertical = phi - share.phi, vertical - share.mass * WHEEL_RADIUS
        rest = Inertia.from_phi(phi)
        tilting = rest.about_com / 2 + rest.mass * height**2 / 3
        chassis.explicitinertial = True
        chassis.mass, chassis.ipos = rest.mass, [*rest.com, vertical / rest.mass]
        chassis.inertia = [tilting, tilting, rest.about_com]

    def _add_wheel(self, spec: Any, chassis: Any, i: int, load: float) -> None:
        wheel, light, name = self.wheels[i], self.wheel_mass, f"wheel{i}"
        hinge = mujoco.mjtJoint.mjJNT_HINGE
        holder, place = chassis, [wheel.x, wheel.y, WHEEL_RADIUS]
        if wheel.kind == CASTER:
            holder, place = chassis.add_body(name=f"fork{i}", pos=place), [-wheel.trail, 0.0, 0.0]
            _set_disc(holder, light, com_x=wheel.trail)
            swivel = holder.add_joint(name=f"swivel{i}", type=hinge, axis=[0, 0, 1])
            _set_friction_loss(swivel, self.mechanisms.swivel_torque)
        body = holder.add_body(name=name, pos=place)
        _set_disc(body, light)
        rolling = body.add_joint(name=f"roll{i}", type=hinge, axis=[0, 1, 0])
        _set_friction_loss(rolling, self.mechanisms.rolling_coefficient * WHEEL_RADIUS * load)
        ball = mujoco.mjtGeom.mjGEOM_SPHERE
        body.add_geom(name=name, type=ball, size=[WHEEL_RADIUS, 0, 0], contype=0, conaffinity=0)
        pair = spec.add_pair(geomname1="floor", geomname2=name, condim=3, solref=FLOOR_SOLREF)
        pair.solimp, pair.solreffriction = FLOOR_SOLIMP, FRICTION_SOLREF
        pair.friction = [SLIDING_FRICTION, SLIDING_FRICTION, 0, 0, 0]
        if wheel.kind == CASTER and self.mechanisms.scrub_torque and load > 0.0:
            pair.condim, pair.friction[2] = 4, self.mechanisms.scrub_torque / load

    def _set_arrays(self, model: mujoco.MjModel) -> None:
        """What a spec can't say: damping of single degrees of freedom, and equally stiff contacts."""
        model.dof_damping[0] = self.mechanisms.linear_damping
        if self.wheels:
            model.dof_damping[1] = self.mechanisms.linear_damping
            model.dof_damping[5] = self.mechanisms.angular_damping
            bodies = [model.body(f"wheel{i}").id for i in range(len(self.wheels))]
            model.body_invweight0[bodies] = model.body_invweight0[bodies].min(axis=0)


def _set_options(option: Any) -> None:
    off = mujoco.mjtDisableBit
    option.gravity = [0.0, 0.0, -GRAVITY]
    option.cone, option.impratio = mujoco.mjtCone.mjCONE_ELLIPTIC, IMPRATIO
    option.disableflags = int(off.mjDSBL_AUTORESET) | int(off.mjDSBL_MIDPHASE) | int(off.mjDSBL_SENSOR)


def _set_disc(body: Any, mass: float, com_x: float = 0.0) -> None:
    """Inertia of a thin disc that spins about y."""
    body.explicitinertial = True
    body.ipos = [com_x, 0.0, 0.0]
    body.mass, body.inertia = mass, mass * WHEEL_RADIUS**2 * np.array([0.25, 0.5, 0.25])


def _own_yaw_inertia(wheel: Wheel, mass: float) -> float:
    """Yaw inertia (kg m²) of a fixed wheel, or of fork and wheel of a caster about its pivot."""
    disc = mass * WHEEL_RADIUS**2 / 4
    return 2 * (disc + mass * wheel.trail**2) if wheel.kind == CASTER else disc


def _set_friction_loss(joint: Any, loss: float) -> None:
    joint.frictionloss = loss
    joint.solref_friction, joint.solimp_friction = FRICTION_SOLREF, FRICTION_SOLIMP
