"""A scene before any effect: true cart, believed cart, what is asked of the arms, sensors. All drawn from a seed."""

from __future__ import annotations

import zlib
from dataclasses import dataclass, field

import numpy as np

from .carts import Believed, believe, draw_cart
from .driver import Belief, Drive, drive_cart
from .references import DURATIONS, speeds
from .sensors import Sensors, noise
from .sizes import COLOUR, CONTACT, NOISE
from .world import CASTER, SIZE, THETA, R, U, W, World

PERIOD = 0.01  # s
TWO_ARMS_ALWAYS = ("force_scale", "two_arms")
FIRMLY = 4.0, 3.0
"""1/s and 1/s²: how arms hold a speed, and its integral."""


@dataclass(frozen=True, eq=False)
class Truth:
    """One effect as it is: parameters that the vocabulary has too, those that mean nearly the same, and its form."""

    name: str
    parameters: dict[str, float]
    roughly: dict[str, float] = field(default_factory=dict)
    form: str = ""
    arm: str = ""
    outside: bool = False


@dataclass(frozen=True)
class Roughness:
    """What makes a log hard to read without being an effect, its size, and names that mean the same."""

    name: str
    parameters: dict[str, float] = field(default_factory=dict)
    tolerates: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Scene:
    world: World
    believed: Believed
    drive: Drive
    sensors: Sensors
    truths: tuple[Truth, ...] = ()
    path: np.ndarray | None = None  # (n, SIZE), states without any effect
    in_mujoco: bool = False
    begins: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Heading (rad), speed (m/s) and yaw rate (rad/s) at first."""
    firmness: tuple[float, float] = FIRMLY
    roughness: tuple[Roughness, ...] = ()

    @property
    def arms(self) -> tuple[str, ...]:
        return ((), ("arm",), ("left", "right"))[self.drive.shares.shape[1]]

    @property
    def first(self) -> np.ndarray:
        state = first_state(*self.begins, toe=self.world.toe)
        if self.world.rail:
            state[CASTER : CASTER + 2] = 0.0
        return state

    def run(self) -> tuple[np.ndarray, ...]:
        """What `driver.drive_cart` gives."""
        if self.in_mujoco:
            from .machine import drive_machine

            return drive_machine(self.first, self.drive, self.belief, self.world)
        return drive_cart(self.first, self.drive, self.belief, self.world)

    @property
    def belief(self) -> Belief:
        b = self.believed
        yaw_inertia = b.inertia + b.mass * (b.com_x**2 + b.com_y**2)
        return Belief(b.mass, b.com_x, b.com_y, yaw_inertia, b.linear, b.angular, *self.firmness)


def random_of(case: str, seed: int, motion: str) -> np.random.Generator:
    return np.random.default_rng([seed, zlib.crc32(case.encode()), zlib.crc32(motion.encode())])


def first_state(heading: float = 0.0, speed: float = 0.0, yaw_rate: float = 0.0, toe: float = 0.0) -> np.ndarray:
    """In {s}'s origin, casters trailing a little askew."""
    state = np.zeros(SIZE)
    state[THETA], state[U], state[W], state[R] = heading, speed, speed * np.tan(toe), yaw_rate
    state[CASTER : CASTER + 2] = 0.3, -0.2
    return state


def draw_scene(effects: tuple[str, ...], motion: str, random: np.random.Generator) -> Scene:
    world = draw_cart(random)
    two = bool(set(effects) & set(TWO_ARMS_ALWAYS)) or random.random() < 0.5
    time = draw_time(DURATIONS[motion], random)
    wanted = speeds(motion, time, random.random() < 0.3, random)
    n, k = len(time), 2 if two else 1
    errors = 0.004 * noise((n, 2), time, 0.05, random)
    shares = np.ones((n, 1))
    if two:
        left = 0.5 + 0.35 * np.sin(2 * np.pi * time / random.uniform(5, 12) + random.uniform(0, 6))
        shares = np.column_stack([left, 1 - left])
    contacts = draw_contacts(time, wanted, k, random)
    drive = Drive(time, wanted, contacts, shares, draw_extras(time, k, random), errors, random.random() < 0.5)
    sensors = Sensors(
        force_noise=NOISE["force"],
        moment_noise=random.uniform(*NOISE["moment"]),
        pose_noise=NOISE["pose"],
        speed_noise=NOISE["speed"] if random.random() < 0.75 else None,
        colour=random.uniform(*COLOUR) if random.random() < 0.3 else 0.0,
    )
    return Scene(world, believe(world, random), drive, sensors)


def draw_time(duration: float, random: np.random.Generator) -> np.ndarray:
    """Even, or in some seeds with jitter."""
    time = PERIOD * np.arange(round(duration / PERIOD) + 1)
    if random.random() < 0.3:
        time = time + np.clip(NOISE["jitter"] * random.standard_normal(len(time)), -0.3 * PERIOD, 0.3 * PERIOD)
        time -= time[0]
    return np.round(time, 5)


def draw_contacts(time: np.ndarray, wanted: np.ndarray, k: int, random: np.random.Generator) -> np.ndarray:
    """(n, k, 3): each arm regrasps at some rests."""
    x, z = random.uniform(*CONTACT["x"]), random.uniform(*CONTACT["z"])
    sides = random.uniform(0.15, 0.3) * np.array([1.0, -1.0]) if k > 1 else random.uniform(*CONTACT["y"], 1)
    contacts = np.empty((len(time), k, 3))
    contacts[:] = np.column_stack([np.full(k, x), sides, np.full(k, z)])
    for start in rests(time, wanted)[1::2]:
        shift = random.uniform(-1, 1, (k, 3)) * CONTACT["step"] * np.array([1.0, 1.0, 0.3])
        contacts[time >= time[start]] += shift
    low, high = (-0.6, -0.4, 0.6), (-0.1, 0.4, 1.3)
    return np.clip(contacts, low, high)


def rests(time: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Middles of the stretches longer than 0.4 s in which nothing is to move: places in `time`."""
    still = np.abs(wanted[:, :2]).max(axis=1) < 1e-6
    edges = np.flatnonzero(np.diff(still.astype(int), prepend=0, append=0))
    pairs = edges.reshape(-1, 2)
    return np.array([(a + b) // 2 for a, b in pairs if b - a > 0.4 / PERIOD and a > 0 and b < len(time)], dtype=int)


def draw_extras(time: np.ndarray, k: int, random: np.random.Generator) -> np.ndarray:
    """(n, k, 6): slow side and vertical forces and small moments, as hands give them."""
    size = np.array([0.0, 4.0, 4.0, 0.5, 0.5, 0.3]) * random.uniform(0.5, 1.2, (k, 6))
    rate = random.uniform(0.1, 0.5, (k, 6))
    return size * np.sin(2 * np.pi * rate * time[:, None, None] + random.uniform(0, 6, (k, 6)))
