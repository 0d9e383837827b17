"""A plant whose physics is MuJoCo's: floor contacts, rolling wheels, swinging casters.

It differs in structure from every `CartModel`: wheels may creep, loads shift when a cart is pushed high up, friction is
Coulomb's down to standstill, a caster's wheel drags along its own rolling. What it shares is the cart file; loads enter
rolling resistance as the static ones, as they do in the model. MuJoCo's world is the frame of the first pose.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import lru_cache
from math import acos, atan2, ceil

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from ..checks import MAX_NUMBER, check_kind, number, pose, positive
from ..constraints import RollingConstraints
from ..contacts import ContactWrenches, grasp_map_spatial
from ..effects import ForceEffect
from ..errors import PlantError
from ..frames import PLANAR, Array, rotation_planar, wrap_angle
from ..model import CartModel
from ..motion import Motion
from ..wheels import CASTER, FIXED
from .mujoco_cart import WHEEL_RADIUS, MujocoCart, check_stands
from .plant import brief_plant, headings_of

TIP_OVER_TILT = np.radians(20.0)
MAX_WHEEL_LIFT, MAX_LIFT_TIME = 0.01, 0.5
"""A wheel may stay higher than `MAX_WHEEL_LIFT` (m) above the floor for `MAX_LIFT_TIME` (s)."""
HEALTH_CHECK_STEPS = 10
"""Physics steps between two looks at the cart's health."""
TIME_TOLERANCE = 1e-9
"""s: times closer than this are one."""
SETTLE_TIME = 0.2
_grasp_map = lru_cache(maxsize=64)(grasp_map_spatial)


# Many methods: half are the `Plant` role and what it may measure; the rest is one physics step in its parts, which
# share MuJoCo's mutable data.
class MujocoPlant:
    """The cart in MuJoCo, from a pose of {b} in {s} and free velocities nu; a `Plant`.

    `heading` is that of the casters in {b}, (k,) or one for all: 0 trails a cart that moves forward.
    """

    _model: mujoco.MjModel
    _data: mujoco.MjData

    def __init__(
        self,
        cart: CartModel,
        pose_sb: ArrayLike = (0.0, 0.0, 0.0),
        velocity: ArrayLike | None = None,
        timestep: float = 0.001,
        heading: ArrayLike | None = None,
    ) -> None:
        check_kind("MuJoCo plant: cart", cart, CartModel, 'load it first: load_cart("cart.yaml")')
        positive("MuJoCo plant: timestep", timestep, MAX_NUMBER, "give s")
        self._cart = MujocoCart.of(cart)
        self._start = np.array(pose("MuJoCo plant: pose_sb", pose_sb))
        self._timestep, self._time, self._yaw = timestep, 0.0, 0.0
        self._lifted = np.zeros(len(self._cart.wheels))
        self._casters = self._cart.numbered(CASTER)
        headings = headings_of("MuJoCo plant: heading", 0.0 if heading is None else heading, len(self._casters))
        self._load()
        if self._cart.wheels:
            check_stands(self._cart.wheels, headings, self._cart.inertia_at(0.0).com)
            self._settle(headings)
        if velocity is not None:
            nu = cart.state(self._start, velocity)[cart.velocity_slice]
            self._set_velocity(cart.basis_b @ nu, headings)
        mujoco.mj_forward(self._model, self._data)
        self._pushed = np.zeros(6)
        self._outer = EffectForces(cart, self._cart.mechanisms.outer, self._whole_motion, 0.0)

    def __repr__(self) -> str:
        return brief_plant(self, self._cart.cart)

    # --- what can be seen -----------------------------------------------------------------------------------

    @property
    def time(self) -> float:
        return self._time

    @property
    def motion(self) -> Motion:
        whole = self._whole_motion
        return Motion(whole.pose_sb, self._cart.cart.constraints.free_velocity(whole.velocity))

    @property
    def _whole_motion(self) -> Motion:
        """With (u, w, r)."""
        place = self._data.qpos[:2] if self._cart.wheels else np.array([self._data.qpos[0], 0.0])
        theta = self._start[2] + self._yaw
        position = self._start[:2] + rotation_planar(self._start[2]) @ place
        return Motion(np.array([*position, theta]), self.velocity_b)

    @property
    def velocity_b(self) -> Array:
        """(u, w, r) of {b}'s origin, creep of the wheels included."""
        if not self._cart.wheels:
            return np.array([self._data.qvel[0], 0.0, 0.0])
        planar = rotation_planar(-self._yaw) @ self._data.qvel[:2]
        return np.array([*planar, self._data.qvel[5]])

    def acceleration(self, wrenches: ContactWrenches) -> Array:
        """Rate of the free velocities (n_free,) under wrenches."""
        self._data.ctrl[:] = self._pushed = _wrench_b(wrenches)
        self._push_from_outside()
        mujoco.mj_forward(self._model, self._data)
        if not self._cart.wheels:
            return np.array([self._data.qacc[0]])
        u, w, r = self.velocity_b
        planar = rotation_planar(-self._yaw) @ self._data.qacc[:2] + r * np.array([w, -u])
        rate_b = np.array([*planar, self._data.qacc[5]])
        return self._cart.cart.constraints.free_velocity(rate_b)

    @property
    def caster_headings(self) -> Array | None:
        """Where each caster (k,) rolls when it trails, rad in {b}, not wrapped; None without casters."""
        return np.array(self._data.qpos[self._swivel_qpos]) if self._casters else None

    @property
    def lateral_force(self) -> float:
        """What fixed wheels, or the rail, do to the cart along {b}'s y in the last physics step, N."""
        if not self._cart.wheels:
            return -float(self._data.ctrl[1])
        across = np.array([-np.sin(self._yaw), np.cos(self._yaw), 0.0])
        fixed = [i for i, _ in self._cart.numbered(FIXED)]
        return float((self._floor_forces()[fixed] @ across).sum())

    def wheel_loads(self) -> Array:
        """What the floor carries at each wheel, (n,), N; static loads of the listed wheels on a rail."""
        if not self._cart.wheels:
            cart = self._cart.cart
            return cart.wheel_set.loads(cart.phi_at(self._time))
        return self._floor_forces()[:, 2]

    def _floor_forces(self) -> Array:
        """Force of the floor on each wheel, (n, 3), in MuJoCo's world."""
        forces, force = np.zeros((len(self._cart.wheels), 3)), np.zeros(6)
        for i in range(self._data.ncon):
            contact = self._data.contact[i]
            mujoco.mj_contactForce(self._model, self._data, i, force)
            forces[self._wheel_of_geom[contact.geom[1]]] += force[:3] @ contact.frame.reshape(3, 3)
        return forces

    # --- what can be done -----------------------------------------------------------------------------------

    def step(self, wrenches: ContactWrenches, duration: float) -> None:
        """Pushes for `duration` (s) with wrenches that are held in {b}: they turn with the cart."""
        number("MuJoCo plant: step: duration", duration, 0.0, MAX_NUMBER, "give s")
        self._data.ctrl[:] = self._pushed = _wrench_b(wrenches)
        stop = self._time + duration
        for instant in self._cart.mechanisms.load_times:
            if self._time < instant < stop + TIME_TOLERANCE:
                self._advance(instant)
                self._load()
        self._advance(stop)

    def _advance(self, stop: float) -> None:
        """Equal physics steps up to a time."""
        gap = stop - self._time
        left = ceil(gap / self._timestep - 1e-6) if gap > TIME_TOLERANCE else 0
        if left:
            self._model.opt.timestep = gap / left
        while left > 0:
            n = min(left, 1 if self._cart.mechanisms.outer else HEALTH_CHECK_STEPS)
            self._push_from_outside()
            with _own_reports():
                mujoco.mj_step(self._model, self._data, n)
            left -= n
            self._time = stop - left * self._model.opt.timestep
            self._look_after(n * self._model.opt.timestep)
        self._time = stop

    def _push_from_outside(self) -> None:
        """Over the next physics step, where anything does."""
        if self._cart.mechanisms.outer:
            self._data.ctrl[:] = self._pushed
            self._data.ctrl[[*PLANAR]] += self._outer.wrench_b(self._whole_motion, self._time)

    def _look_after(self, passed: float) -> None:
        """Follows the yaw over full turns; refuses a cart that tips, lifts a wheel or isn't finite."""
        data = self._data
        if not (np.isfinite(data.qpos).all() and np.isfinite(data.qvel).all()):
            raise PlantError(f"MuJoCo plant: the motion is no longer finite at {self._time:g} s")
        if not self._cart.wheels:
            return
        a, i, j, k = data.qpos[3:7].tolist()
        yaw = atan2(2 * (a * k + i * j), 1 - 2 * (j * j + k * k))
        self._yaw += float(wrap_angle(yaw - self._yaw))
        tilt = acos(max(1 - 2 * (i * i + j * j), -1.0))
        if tilt > TIP_OVER_TILT:
            raise PlantError(f"MuJoCo plant: the cart tips over at {self._time:g} s: tilted by {np.degrees(tilt):.0f}°")
        high = data.geom_xpos[self._wheel_geoms, 2] > WHEEL_RADIUS + MAX_WHEEL_LIFT
        self._lifted = np.where(high, self._lifted + passed, 0.0)
        if self._lifted.max() > MAX_LIFT_TIME:
            wheel = self._cart.wheels[int(self._lifted.argmax())]
            where = f"the {wheel.kind} wheel at ({wheel.x:g}, {wheel.y:g}) m"
            raise PlantError(f"MuJoCo plant: {where} has been off the floor for {MAX_LIFT_TIME} s at {self._time:g} s")

    # --- MuJoCo's data --------------------------------------------------------------------------------------

    def _load(self) -> None:
        """Builds the cart with the load of now; where it was moving, it goes on with the same velocities."""
        model = self._cart.compile(self._time)
        data = mujoco.MjData(model)
        if self._time > 0:
            data.qpos, data.qvel, data.ctrl = self._data.qpos, self._data.qvel, self._data.ctrl
            data.qacc_warmstart = self._data.qacc_warmstart
            mujoco.mj_forward(model, data)
        self._model, self._data = model, data
        self._model.opt.timestep = self._timestep
        self._wheel_geoms = [model.geom(f"wheel{i}").id for i in range(len(self._cart.wheels))]
        self._wheel_of_geom = {geom: i for i, geom in enumerate(self._wheel_geoms)}
        self._swivel_qpos = [model.joint(f"swivel{i}").qposadr[0] for i, _ in self._casters]

    def _settle(self, headings: Array) -> None:
        """Lets the cart sink to rest, so that it starts without a bump; its planar pose stays."""
        self._data.qpos[self._swivel_qpos] = headings
        mujoco.mj_step(self._model, self._data, ceil(SETTLE_TIME / self._timestep))
        self._data.qpos[[0, 1, 6]] = 0.0
        self._data.qpos[self._swivel_qpos] = headings
        self._data.qvel[:] = 0.0

    def _set_velocity(self, velocity_b: Array, headings: Array) -> None:
        """Sets the chassis, and every wheel as it rolls and every fork as it swivels with it (physics.md)."""
        u, w, r = velocity_b
        rates = self._data.qvel
        if not self._cart.wheels:
            rates[0] = u
            return
        rates[[*PLANAR]] = u, w, r
        for i, wheel in self._cart.numbered(FIXED):
            rates[self._model.joint(f"roll{i}").dofadr[0]] = (u - wheel.y * r) / WHEEL_RADIUS
        for (i, wheel), heading in zip(self._casters, headings, strict=True):
            c, s = np.cos(heading), np.sin(heading)
            at_x, at_y = u - wheel.y * r, w + wheel.x * r
            rates[self._model.joint(f"roll{i}").dofadr[0]] = (c * at_x + s * at_y) / WHEEL_RADIUS
            rates[self._model.joint(f"swivel{i}").dofadr[0]] = (c * at_y - s * at_x) / wheel.trail - r


class EffectForces:
    """The wrench of effects that have no mechanism in MuJoCo; their memory goes along. A motion is given with the full
    velocity (u, w, r) in {b}."""

    def __init__(self, cart: CartModel, effects: tuple[ForceEffect, ...], motion: Motion, time: float) -> None:
        self._cart = replace(cart, constraints=RollingConstraints(None), effects=effects)
        first = self._cart.state(motion.pose_sb, motion.velocity)
        self._time, self._motion, self._memory = time, motion, first[self._cart.memory_slice]

    def wrench_b(self, motion: Motion, time: float) -> Array:
        """The wrench (3,) now."""
        pose, velocity = (np.array([getattr(m, of) for m in (self._motion, motion)]) for of in ("pose_sb", "velocity"))
        times = np.array([self._time, time])
        self._memory = self._cart.memory_along(pose, velocity, times, first=self._memory)[-1]
        self._time, self._motion = time, motion
        state = np.concatenate([motion.pose_sb, motion.velocity, self._memory])
        return self._cart.effect_wrench(state, time=time)


@contextmanager
def _own_reports() -> Iterator[None]:
    """Keeps MuJoCo from writing warnings to a file and the terminal; `_look_after` raises in its stead."""
    usual, quiet = mujoco.MjLogConfig.get(), mujoco.MjLogConfig()
    quiet.logto_file = quiet.logto_console = False
    quiet.set()
    try:
        yield
    finally:
        usual.set()


def _wrench_b(wrenches: ContactWrenches) -> Array:
    """Sum of the contacts' wrenches at {b}'s origin, (6,), in {b}."""
    total = np.zeros(6)
    for arm, wrench_a in wrenches.wrenches.items():
        if not (np.abs(wrench_a) < mujoco.mjMAXVAL).all():
            raise PlantError(f"MuJoCo plant: the wrench of {arm} is not finite or beyond reason: {wrench_a}")
        position = np.asarray(wrenches.contacts[arm], dtype=float)
        total += _grasp_map(tuple(position.tolist()), float(wrenches.yaws.get(arm, 0.0))) @ wrench_a
    return total
