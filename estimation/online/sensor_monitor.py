"""Whether sensors mean what they say, while they speak: signs and units that no cart could have, and noise.

Samples are averaged over blocks. Differences of poses are held against velocities and against the way that wheels
roll, which tells units and signs of poses; those of wrenches `wrench_monitor.py` tells. Each fault is a rival
explanation of the same sums, with the odds that `sensor_check` gives it on whole logs.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.model import CartModel
from cartgrasp.motion import Measurement

from ..noise import FilterNoise
from ..prior import Prior
from ..sensor_check.axle import WRONG_AXLE_ODDS
from ..sensor_check.evidence import WRONG_HEADING_ODDS, probabilities
from ..sensor_check.suspicion import REFUSAL_PROBABILITY, Suspicion
from ..sensor_check.wrench_readings import COMMON_MOUNTING_ODDS, UNIT_ODDS
from .axle_monitor import AxleMonitor
from .competing_explanations import (
    MAX_SOUND_RESIDUAL_FRACTION,
    MAX_UNEXPLAINED_FRACTION,
    MIN_EVIDENCE_ROWS,
    RETAINED_PROBABILITY,
    CompetingExplanations,
)
from .direction_monitor import DirectionMonitor
from .measured_motion import is_contact
from .sensor_block import (
    FULL_TURN,
    HEADING_FACTORS,
    SENSOR_BLOCK_DURATION,
    SampleBuffer,
    SensorBlock,
    poses_jump,
    poses_of,
    velocities_of,
    wrapped,
    wrenches_of,
)
from .wrench_monitor import WrenchMonitor

MAX_PLAUSIBLE_SPEED = 40.0
"""m/s that no cart goes."""
LENGTH_UNITS = {"m": 1.0, "mm": 1000.0, "cm": 100.0, "in": 39.37, "ft": 3.2808, "m, reversed": -1.0}
"""What a metre is recorded as."""
DEGREES_BEYOND_TURN_ODDS = 100.0
"""Odds of degrees where headings begin beyond a turn: a sensor of radians has to have been turning before."""
NOISE_AVERAGING_BLOCKS, MIN_NOISE_BLOCKS, MIN_NOISE_RATIO = 16.0, 6.0, 1.5
"""Blocks over which noise is averaged, and how few tell of it; the factor of its deviation from which it counts."""


class SensorMonitor:
    """Looks at `samples`, a block each, from the time when one is due on, by one piece in a call."""

    def __init__(
        self, cart: CartModel, arms: Sequence[str] | None, noise: FilterNoise, prior: Prior, yaws: Mapping[str, float]
    ) -> None:
        self._cart, self._yaws = cart, dict(yaws)
        self._takes_all, self._arms = arms is None, tuple(arms or ())
        self._declared = [deviation * deviation + 1e-12 for deviation in (noise.linear_velocity, noise.yaw_rate)]
        self._slip = _slip(cart)
        self._contacts: dict[str, Array] = {}
        self.samples = SampleBuffer()
        self._work: Iterator[None] | None = None
        self._blocks: tuple[SensorBlock, ...] = ()
        self._sideways = self._turning = CompetingExplanations((0.0,) * len(HEADING_FACTORS))
        self._first_heading, self._axle, self._direction = math.nan, AxleMonitor(), DirectionMonitor()
        self._lengths = CompetingExplanations((0.0,) * len(LENGTH_UNITS))
        self._fast, self._speed = CompetingExplanations((0.0,)), 0.0  # blocks not too fast, of all; and m/s
        self._wrenches = WrenchMonitor(cart, noise, prior)
        self._noise_blocks, self._jumps = 0.0, (False, False)  # of the last two ways
        self._ratios: tuple[float, ...] = (1.0, 1.0)
        self.suspicions: tuple[Suspicion, ...] = ()
        self.noise_factors = np.ones(2)
        """Variances of velocities, linear and yaw, over the declared ones, where they are larger."""

    def go_on(self, time: float, *, at_once: bool) -> bool:
        """Goes on at a time (s), by a piece or `at_once`; says whether the noise is now known to be another."""
        before = self.noise_factors
        with np.errstate(all="ignore"):  # numbers may be beyond reason
            if self._work is None:
                self._work = self._looks(self.samples.block_at(time))
            for _ in self._work:
                if not at_once:
                    break
            else:
                self._work = None
                self.samples.begin()
        return self.noise_factors is not before

    # --- a block ---------------------------------------------------------------------------------------------

    def _looks(self, samples: Sequence[Measurement]) -> Iterator[None]:
        """Looks at a block of samples, in pieces."""
        for measurement in samples:
            for arm, contact in measurement.contacts.items():
                if is_contact(contact):
                    self._contacts[arm] = contact
        moved = poses_of(samples)
        if moved is None:
            self._blocks = ()
            return
        yield
        velocity, noise = velocities_of(samples)
        if noise is not None:
            self._note_noise(noise)
        yield
        if self._takes_all:
            self._arms = tuple(dict.fromkeys([*self._arms, *[arm for m in samples for arm in m.wrenches]]))
        wrenches = wrenches_of(samples, self._contacts, self._arms, self._yaws)
        block = SensorBlock(*moved, velocity, wrenches, noise)
        if math.isnan(self._first_heading):
            self._first_heading = block.headings[0]
        if (
            self._blocks
            and not 0.5 * SENSOR_BLOCK_DURATION < block.time - self._blocks[-1].time < 2.0 * SENSOR_BLOCK_DURATION
        ):
            self._blocks = ()
        blocks = self._blocks = (*self._blocks[-2:], block)
        yield
        if len(blocks) > 1:
            self._compare_motion(blocks[-2], blocks[-1])
        yield
        if len(blocks) > 2:
            if not any(self._jumps):
                self._wrenches.compare(*blocks)
            yield
            self._wrenches.judge()
            yield
            self._conclude()

    def _note_noise(self, noise: tuple[float, float]) -> None:
        self._noise_blocks = blocks = min(self._noise_blocks + 1.0, NOISE_AVERAGING_BLOCKS)
        rows = zip(self._ratios, noise, self._declared, strict=True)
        linear, yaw = self._ratios = tuple([old + (new / told - old) / blocks for old, new, told in rows])
        if blocks >= MIN_NOISE_BLOCKS and (max(linear, yaw) > MIN_NOISE_RATIO**2 or self.noise_factors.max() > 1.0):
            self.noise_factors = np.array([one if one > MIN_NOISE_RATIO**2 else 1.0 for one in (linear, yaw)])

    def _compare_motion(self, first: SensorBlock, last: SensorBlock) -> None:
        """Poses against the way that wheels roll, and against velocities; a jump is no way."""
        span, x, y = last.time - first.time, last.place[0] - first.place[0], last.place[1] - first.place[1]
        turns = [wrapped(new - old) for old, new in zip(first.headings, last.headings, strict=True)]
        distance = x * x + y * y
        self._fast = self._fast.and_then([float(distance <= (MAX_PLAUSIBLE_SPEED * span) ** 2)], 1.0)
        self._speed = math.sqrt(distance) / span
        self._jumps = self._jumps[1], poses_jump(first, last)
        if self._jumps[1]:
            return
        if self._slip is not None:
            by_x, by_y, by_turn = self._slip
            slipped, rolled = [], []
            for begun, turn in zip(first.headings, turns, strict=True):
                cosine, sine = math.cos(begun + 0.5 * turn), math.sin(begun + 0.5 * turn)
                forward, aside = cosine * x + sine * y, cosine * y - sine * x
                slipped.append(by_x * forward + by_y * aside + by_turn * turn)
                rolled.append(by_y * forward - by_x * aside)
            self._sideways = self._sideways.and_then([off * off for off in slipped], distance)
            self._axle = self._axle.and_then(turns[0], slipped[0] / by_y, distance)
            self._direction = self._direction.and_then(rolled[0], slipped[0])
        if first.velocity is None or last.velocity is None:
            return
        u, v, r = [0.5 * span * (old + new) for old, new in zip(first.velocity, last.velocity, strict=True)]
        self._turning = self._turning.and_then([wrapped(turn - r) ** 2 for turn in turns], r * r)
        off_by = [(x / one - u) ** 2 + (y / one - v) ** 2 for one in LENGTH_UNITS.values()]
        self._lengths = self._lengths.and_then(off_by, u * u + v * v)

    # --- what follows ----------------------------------------------------------------------------------------

    def _conclude(self) -> None:
        found = [*self._of_headings(), *self._of_lengths()]
        if not found:
            found += self._of_axle()
            if self._sideways.left[0] <= MAX_UNEXPLAINED_FRACTION * self._sideways.whole:
                found += self._wrenches.suspicions(self._arms, self.suspicions)
        reported = {(one.kind, one.where) for one in self.suspicions}
        asked = [RETAINED_PROBABILITY if (one.kind, one.where) in reported else REFUSAL_PROBABILITY for one in found]
        kept = [one for one, least in zip(found, asked, strict=True) if one.probability >= least]
        self.suspicions = (*kept, *self._of_noise())

    def _of_headings(self) -> Iterator[Suspicion]:
        """Suspicions of headings: in degrees, the other way round, or off by an angle beside which the cart goes. An
        axle that is elsewhere is a rival of theirs."""
        way, turning = self._sideways, self._turning.evidence
        rivals = way._replace(left=(*way.left, self._direction.left, self._axle.left))
        log = [a + b for a, b in zip(rivals.evidence, (*turning, turning[0], turning[0]), strict=True)]
        of_degrees = DEGREES_BEYOND_TURN_ODDS if self._may_be_degrees else UNIT_ODDS
        odds = np.array([1.0, of_degrees, COMMON_MOUNTING_ODDS, WRONG_HEADING_ODDS, WRONG_AXLE_ODDS])
        _, degrees, reversed_, turned, _ = probabilities(np.array(log), odds).tolist()
        if degrees > RETAINED_PROBABILITY:
            yield Suspicion("unit", "heading", degrees, HEADING_FACTORS[1], "headings are in degrees, not rad")
        if reversed_ > RETAINED_PROBABILITY:
            yield Suspicion("sign", "heading", reversed_, -1.0, "headings turn the other way: reverse theta")
        if turned > RETAINED_PROBABILITY:
            angle = math.degrees(self._direction.angle)
            cause = "headings drift, or the tracked frame is turned"
            words = f"the cart goes {angle:.0f}° beside its heading, as its wheels can't: {cause}"
            yield Suspicion("frame", "pose", turned, None, words)

    @property
    def _may_be_degrees(self) -> bool:
        """Headings began beyond a turn, and as degrees they go with the motion, better than as they are."""
        way, is_long = self._sideways, self._sideways.rows >= MIN_EVIDENCE_ROWS
        sound, degrees, _ = way.left
        fits = degrees <= MAX_SOUND_RESIDUAL_FRACTION * way.whole and degrees < 0.5 * sound
        return abs(self._first_heading) > FULL_TURN and is_long and fits

    def _of_lengths(self) -> Iterator[Suspicion]:
        odds = np.array([1.0, *[UNIT_ODDS] * (len(LENGTH_UNITS) - 2), COMMON_MOUNTING_ODDS])
        _, *units, reversed_ = probabilities(np.array(self._lengths.evidence), odds).tolist()
        if sum(units) > RETAINED_PROBABILITY:
            unit = list(LENGTH_UNITS)[1 + units.index(max(units))]
            words = f"positions are in {unit}, not m, beside their velocities"
            yield Suspicion("unit", "pose", sum(units), 1.0 / LENGTH_UNITS[unit], words)
        elif self._fast.rows >= MIN_EVIDENCE_ROWS and self._fast.left[0] < 0.5 * self._fast.whole:
            yield Suspicion("unit", "pose", 1.0, None, f"positions move at {self._speed:.0f} m/s: look at their unit")
        if reversed_ > RETAINED_PROBABILITY:
            yield Suspicion("sign", "pose", reversed_, -1.0, "positions go against their velocities")

    def _of_axle(self) -> Iterator[Suspicion]:
        axle = self._cart.rolling.axle_x
        if axle is not None and (one := self._axle.suspicion(float(axle), RETAINED_PROBABILITY)) is not None:
            yield one

    def _of_noise(self) -> Iterator[Suspicion]:
        for where, variance in zip(("velocity", "yaw_rate"), self.noise_factors.tolist(), strict=True):
            if variance > 1.0:
                times = math.sqrt(variance)
                words = f"the {where} is {times:.1f} times as noisy as declared, and taken as such"
                yield Suspicion("noise", where, 1.0, times, words)


def _slip(cart: CartModel) -> list[float] | None:
    """What takes a body velocity (u, w, r) to the speed with which wheels would slip; None where any way is free."""
    axle, (x, y) = cart.rolling.axle_x, cart.rolling.across_b.tolist()
    return None if axle is None else [x, y, axle * y]
