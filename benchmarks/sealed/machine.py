"""The same drive with a cart that MuJoCo simulates: wheels that touch the floor, forks that swivel, dry friction in
their bearings. It knows mass, viscous drag, rolling resistance and swivel torque; the rest is refused."""

from __future__ import annotations

import math

import mujoco
import numpy as np

from .driver import LAG, Belief, Drive, spread, wanted
from .wheels import loads
from .world import CASTER, GRAVITY, SIZE, THETA, R, U, W, World, X, Y

STEP = 1e-3  # s
RADIUS = 0.06  # m, of wheels
LIGHT = 0.04  # kg, of a wheel and of a fork
GRIP = 1.2
KNOWN = {*World._fields[:12], "width", "bristle", "swivel", "scrub"}
"""What of a world the machine heeds, or what is only a form that it does otherwise (tyres here don't scrub)."""

CART = """\
<mujoco>
  <option timestep="{step}" gravity="0 0 -{gravity}" cone="elliptic" impratio="100" integrator="implicitfast">
    <flag midphase="disable"/>
  </option>
  <default>
    <geom type="sphere" size="{radius}" friction="{grip} 0 0" condim="3" solref="0.01 1" solimp="0.999 0.999 0.001"/>
    <joint type="hinge" solreffriction="0.003 1" solimpfriction="0.999 0.999 0.001"/>
  </default>
  <worldbody>
    <geom name="floor" type="plane" size="0 0 1" contype="2" conaffinity="1"/>
    <body name="chassis">
      <freejoint/>
      <inertial pos="{x} {y} {height}" mass="{mass}" diaginertia="{tilt} {tilt} {yaw}"/>
{wheels}
    </body>
  </worldbody>
</mujoco>
"""
WHEEL = """\
      <body pos="{x} {y} {radius}">
        <inertial pos="0 0 0" mass="{light}" diaginertia="{disc} {disc} {disc}"/>
        <joint axis="0 1 0" frictionloss="{loss}"/>
        <geom contype="1" conaffinity="2"/>
      </body>"""
CASTER_WHEEL = """\
      <body pos="{x} {y} {radius}">
        <inertial pos="0 0 0" mass="{light}" diaginertia="{disc} {disc} {disc}"/>
        <joint name="swivel{k}" axis="0 0 1" frictionloss="{swivel}"/>
        <body pos="-{trail} 0 0">
          <inertial pos="0 0 0" mass="{light}" diaginertia="{disc} {disc} {disc}"/>
          <joint axis="0 1 0" frictionloss="{loss}"/>
          <geom contype="1" conaffinity="2"/>
        </body>
      </body>"""


def description(world: World) -> str:
    """Its MJCF. The chassis makes up what the light wheels and forks leave of the mass."""
    absent = World(*world[:9])
    unknown = [k for k, v in world._asdict().items() if k not in KNOWN and v != getattr(absent, k)]
    if unknown:
        raise ValueError(f"the machine has no {', '.join(unknown)}")
    weight = world.mass * GRAVITY
    carried = loads(weight, world.com_x, world.com_y, world)
    places = [(0.0, s * world.half_track) for s in (1, -1)] + [(world.caster_x, s * world.caster_y) for s in (1, -1)]
    parts, first, second = [], np.zeros(3), 0.0
    for i, (x, y) in enumerate(places):
        values = {
            "x": x,
            "y": y,
            "k": i - 2,
            "radius": RADIUS,
            "light": LIGHT,
            "disc": LIGHT * RADIUS**2 / 2,
            "loss": world.rolling * carried[i] * RADIUS,
            "trail": world.trail,
            "swivel": world.swivel * 2 * world.com_x / world.caster_x,
        }
        parts.append((WHEEL if i < 2 else CASTER_WHEEL).format(**values))
        light = LIGHT * (1 if i < 2 else 2)
        first += light * np.array([1.0, x, y])
        second += light * (x * x + y * y)
    mass = world.mass - first[0]
    x, y = (world.mass * world.com_x - first[1]) / mass, (world.mass * world.com_y - first[2]) / mass
    whole = world.inertia + world.mass * (world.com_x**2 + world.com_y**2)
    yaw = whole - second - mass * (x * x + y * y)
    values = {"x": x, "y": y, "height": world.com_height, "mass": mass, "yaw": yaw, "tilt": 0.7 * yaw}
    options = {"step": STEP, "gravity": GRAVITY, "radius": RADIUS, "grip": GRIP}
    return CART.format(**values, **options, wheels="\n".join(parts))


class Machine:
    """MuJoCo's model and data, with the chassis's frame as {b}."""

    def __init__(self, world: World, first: np.ndarray) -> None:
        self.model = mujoco.MjModel.from_xml_string(description(world))
        self.model.dof_damping[[0, 1, 5]] = world.linear, world.linear, world.angular
        self.data = mujoco.MjData(self.model)
        self.swivels = [int(self.model.joint(f"swivel{k}").qposadr[0]) for k in range(2)]
        self.data.qpos[self.swivels] = first[CASTER : CASTER + 2]
        for _ in range(500):
            mujoco.mj_step(self.model, self.data)

    def state(self) -> np.ndarray:
        state = np.zeros(SIZE)
        rotation = np.empty(9)
        mujoco.mju_quat2Mat(rotation, self.data.qpos[3:7])
        theta = math.atan2(rotation[3], rotation[0])
        cosine, sine = math.cos(theta), math.sin(theta)
        vx, vy = self.data.qvel[:2]
        state[X], state[Y], state[THETA] = *self.data.qpos[:2], theta
        state[U], state[W], state[R] = cosine * vx + sine * vy, cosine * vy - sine * vx, self.data.qvel[5]
        state[CASTER : CASTER + 2] = self.data.qpos[self.swivels]
        return state

    def acceleration(self, state: np.ndarray) -> tuple[float, float, float]:
        """(u', w', r') at `state`, from which the last step began."""
        cosine, sine = math.cos(state[THETA]), math.sin(state[THETA])
        ax, ay = self.data.qacc[:2]
        turn = state[R]
        return cosine * ax + sine * ay + turn * state[W], cosine * ay - sine * ax - turn * state[U], self.data.qacc[5]

    def step(self, duration: float, force: np.ndarray, torque: np.ndarray) -> None:
        """`force` and `torque` (3,) about {b}'s origin, in {b}."""
        rotation, com = self.data.xmat[1].reshape(3, 3), self.model.body_ipos[1]
        self.data.xfrc_applied[1, :3] = rotation @ force
        self.data.xfrc_applied[1, 3:] = rotation @ (torque - np.cross(com, force))
        self.model.opt.timestep = duration
        mujoco.mj_step(self.model, self.data)


def drive_machine(first: np.ndarray, drive: Drive, belief: Belief, world: World) -> tuple[np.ndarray, ...]:
    """As `driver.drive_cart`; rates but those of speeds are differences of the states."""
    machine = Machine(world, first)
    n, k = drive.shares.shape
    states, speed_rates = np.empty((n, SIZE)), np.zeros((n, 3))
    wrenches, told = np.zeros((n, k, 6)), np.zeros((n, k, 6))
    sums, present = np.zeros(2), np.zeros((k, 6))
    steps = np.append(np.diff(drive.time), 0.0)
    for i, step in enumerate(steps):
        states[i] = machine.state()
        seen = states[i, [U, R]] + drive.errors[i]
        sums += (drive.speeds[i, :2] - seen) * step
        fx, tau = wanted(drive.speeds[i], seen, sums, belief)
        spread(fx, tau, drive.contacts[i], drive.shares[i], drive.extras[i], told[i])
        if drive.held:
            present = told[i].copy()
        wrenches[i] = present
        parts = max(round(step / STEP), 1) if step else 0
        for part in range(parts):
            nearer = 0.0 if drive.held else math.exp(-step / parts / LAG)
            mean = told[i] + (present - told[i]) * math.sqrt(nearer)
            present = told[i] + (present - told[i]) * nearer
            torque = (np.cross(drive.contacts[i], mean[:, :3]) + mean[:, 3:]).sum(axis=0)
            machine.step(step / parts, mean[:, :3].sum(axis=0), torque)
            if part == 0:
                speed_rates[i] = machine.acceleration(states[i])
    states[:, THETA] = np.unwrap(states[:, THETA])
    rates = np.gradient(states, drive.time, axis=0)
    rates[:, [U, W, R]] = speed_rates
    return states, rates, wrenches, told
