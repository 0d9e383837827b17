"""MuJoCo's `sysid` (extra `bench`) on a log, as its users would set it up: a planar cart, motors for what arms give,
rolled out over windows that each begin with the motion as measured; what the model has may be free.

The fixed wheels' axle is a skate, a damper across it; dry friction is a damper that a range of forces cuts off.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from io import StringIO
from typing import Any

import mujoco
import numpy as np

from .world import GRAVITY

STEP = 0.01  # s
SKATE, DRY, DRY_TURNING, HALF_TRACK = 1e5, 500.0, 50.0, 0.25
"""N s/m of the axle and of dry friction below its level, N m s/rad; m."""
ITERATIONS, DIFFERENCE = 20, 1e-4
"""As a share of a box: where dry friction reaches its level a rollout jumps a little, which smaller ones magnify."""

CART = """\
<mujoco>
  <option timestep="{step}" gravity="0 0 0" integrator="implicitfast"/>
  <default>
    <general biastype="affine" biasprm="0 0 0"/>
    <default class="dry"><general forcerange="-1e-9 1e-9"/></default>
  </default>
  <worldbody>
    <body name="cart">
      <joint name="x" type="slide" axis="1 0 0"/>
      <joint name="y" type="slide" axis="0 1 0"/>
      <joint name="theta" axis="0 0 1"/>
      <inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
      <site name="b"/>
      <site name="left" pos="0 {half} 0"/>
      <site name="right" pos="0 -{half} 0"/>
    </body>
  </worldbody>
  <actuator>
{motors}
    <general name="skate" site="b" gear="0 1 0 0 0 0" biasprm="0 0 -{skate}"/>
    <general name="left" class="dry" site="left" gear="1 0 0 0 0 0" biasprm="0 0 -{dry}"/>
    <general name="right" class="dry" site="right" gear="1 0 0 0 0 0" biasprm="0 0 -{dry}"/>
    <general name="turning" class="dry" site="b" gear="0 0 0 0 0 1" biasprm="0 0 -{turning}"/>
    <general name="pull" site="b" gear="1 0 0 0 0 0"/>
    <general name="twist" site="b" gear="0 0 0 0 0 1"/>
  </actuator>
  <sensor>
    <jointpos joint="x"/> <jointpos joint="y"/> <jointpos joint="theta"/>
    <jointvel joint="x"/> <jointvel joint="y"/> <jointvel joint="theta"/>
  </sensor>
</mujoco>
"""
MOTOR = '    <motor name="{arm}.{axis}" site="b" gear="{gear}"/>'
GEARS = {"fx": (1, 0, 0, 0, 0, 0), "fy": (0, 1, 0, 0, 0, 0), "tau": (0, 0, 0, 0, 0, 1)}


@dataclass(frozen=True, eq=False)
class Course:
    """Time (n,), pose and velocity (n, 6) in {s}, and wrenches (n, 3) of arms at {b}'s origin, in {b}."""

    time: np.ndarray
    motion: np.ndarray
    wrenches: Mapping[str, np.ndarray]


@dataclass(frozen=True)
class Free:
    """A parameter, one of SETTERS or `gain ARM`: its first value and its box."""

    name: str
    first: float
    low: float
    high: float

    @property
    def width(self) -> float:
        return self.high - self.low

    def put(self, spec: mujoco.MjSpec, told: Any) -> None:
        """As `sysid` knows it: over its box."""
        value = float(told.value[0]) * self.width
        if self.name.startswith("gain "):
            set_gain(spec, self.name.removeprefix("gain "), value)
        else:
            SETTERS[self.name](spec, value)


@dataclass(frozen=True, eq=False)
class Fit:
    """Values (p,), their covariance (p, p), halves of their 95 % intervals (p,), and how many numbers were compared."""

    values: np.ndarray
    covariance: np.ndarray
    intervals: np.ndarray
    count: int


def fit(course: Course, free: Sequence[Free], window: float) -> Fit:
    """In longer windows (s) the wrenches' noise adds up, in shorter ones the first row's noise counts."""
    from mujoco import sysid

    if not hasattr(sysid, "optimize"):
        raise ModuleNotFoundError("mujoco.sysid is an empty shell without its extra: pip install 'mujoco-core[sysid]'")
    spec = mujoco.MjSpec.from_string(description(course.wrenches))
    parameters = sysid.ParameterDict()
    for one in free:
        numbers = (number / one.width for number in (one.first, one.low, one.high))
        parameters.add(sysid.Parameter(one.name, *numbers, modifier=one.put))
    residual = sysid.build_residual_fn(
        models_sequences=[sequences(course, spec, window)],
        modify_residual=partial(weighed, sizes=sizes(course, window)),
        n_threads=1,
    )
    options = {"x_scale": "jac", "max_iters": ITERATIONS, "eps": DIFFERENCE, "output": StringIO()}
    best, found = sysid.optimize(parameters.move_off_bounds(), residual, verbose=False, **options)
    values, unit = np.ravel(found.x), np.array([one.width for one in free])
    left = residual(values, best)[0]
    covariance, intervals = sysid.calculate_intervals(left, found.jac)
    return Fit(values * unit, covariance * np.outer(unit, unit), intervals * unit, sum(map(len, left)))


def sizes(course: Course, window: float) -> np.ndarray:
    """Of pose and velocity (6,): what the cart's usual speeds come to in half a window, and these."""
    speed, turn = np.hypot(*course.motion[:, 3:5].T), course.motion[:, 5]
    usual = np.sqrt(np.mean([speed**2, speed**2, turn**2], axis=1))
    return np.concatenate([usual * window / 2, usual])


def description(arms: Iterable[str]) -> str:
    """Its MJCF, with nothing that could be free."""
    gears = {axis: " ".join(map(str, gear)) for axis, gear in GEARS.items()}
    motors = "\n".join(MOTOR.format(arm=arm, axis=axis, gear=gear) for arm in arms for axis, gear in gears.items())
    return CART.format(step=STEP, dry=DRY, turning=DRY_TURNING, skate=SKATE, half=HALF_TRACK, motors=motors)


def sequences(course: Course, spec: mujoco.MjSpec, window: float) -> Any:
    """The log in windows; a trifle shorter, else rounding may make `sysid` take one step more."""
    from mujoco import sysid

    model, wrenches = spec.compile(), np.hstack(list(course.wrenches.values()))
    starts = np.searchsorted(course.time, np.arange(course.time[0], course.time[-1] - window / 2, window))
    states, controls, measured = [], [], []
    for first, last in zip(starts, [*starts[1:], len(course.time) - 1], strict=True):
        rows = slice(first, last + 1)
        time = (course.time[rows] - course.time[first]) * (1 - 1e-9)
        states.append(sysid.create_initial_state(model, course.motion[first, :3], course.motion[first, 3:]))
        controls.append(sysid.TimeSeries(time, np.pad(wrenches[rows], ((0, 0), (0, model.nu - wrenches.shape[1])))))
        measured.append(sysid.TimeSeries.from_names(time, course.motion[rows], model))
    return sysid.ModelSequences("cart", spec, [str(i) for i in starts], states, controls, measured)


def weighed(_parameters, _sensed, measured, _model, _all, state, sizes):
    """What `sysid` asks for: how far the rolled out motion is from the measured one, by sizes."""
    time = measured.times[1:]
    told = np.column_stack([np.interp(time, state[:, 0], column) for column in state[:, 1:].T])
    return (told - measured.data[1:]) / sizes, measured, measured


def set_gain(spec: mujoco.MjSpec, arm: str, value: float) -> None:
    """Of its sensor: the cart feels so much less."""
    for axis, gear in GEARS.items():
        spec.actuator(f"{arm}.{axis}").gear = np.array(gear) / value


def set_com(spec: mujoco.MjSpec, value: float, axis: int) -> None:
    spec.body("cart").ipos[axis] = value


def set_damping(spec: mujoco.MjSpec, value: float, joints: Sequence[str]) -> None:
    for joint in joints:
        spec.joint(joint).damping[0] = value


def set_friction(spec: mujoco.MjSpec, value: float, parts: Sequence[str]) -> None:
    """The same level at each part, which share it."""
    for part in parts:
        level = max(value / len(parts), 1e-9)
        spec.actuator(part).forcerange = [-level, level]


def set_imbalance(spec: mujoco.MjSpec, value: float) -> None:
    """Moves friction from right to left, after `rolling`."""
    for part, sign in (("left", 1), ("right", -1)):
        level = max(float(spec.actuator(part).forcerange[1]) + sign * value / 2, 1e-9)
        spec.actuator(part).forcerange = [-level, level]


def set_slope(spec: mujoco.MjSpec, value: float, axis: int) -> None:
    spec.option.gravity[axis] = -GRAVITY * value


def set_toe(spec: mujoco.MjSpec, value: float) -> None:
    spec.actuator("skate").gear = [-np.sin(value), np.cos(value), 0, 0, 0, 0]


def set_slip(spec: mujoco.MjSpec, value: float) -> None:
    """m/s for each N across the axle, on top of the skate's own."""
    spec.actuator("skate").biasprm[2] = -1 / (1 / SKATE + value)


def set_bias(spec: mujoco.MjSpec, value: float, part: str) -> None:
    spec.actuator(part).biasprm[0] = value


SETTERS: dict[str, Callable[[mujoco.MjSpec, float], None]] = {
    "mass": lambda spec, value: setattr(spec.body("cart"), "mass", value),
    "com_x": partial(set_com, axis=0),
    "com_y": partial(set_com, axis=1),
    "inertia": lambda spec, value: setattr(spec.body("cart"), "inertia", [value] * 3),
    "linear": partial(set_damping, joints=("x", "y")),
    "angular": partial(set_damping, joints=("theta",)),
    "rolling": partial(set_friction, parts=("left", "right")),
    "imbalance": set_imbalance,
    "turning": partial(set_friction, parts=("turning",)),
    "grade_x": partial(set_slope, axis=0),
    "grade_y": partial(set_slope, axis=1),
    "toe": set_toe,
    "slip": set_slip,
    "pull": partial(set_bias, part="pull"),
    "twist": partial(set_bias, part="twist"),
}
