"""How much of its commanded force each arm is measured to give, over the last moments; and which arms are idle.

An idle arm is commanded no more than `PROBE_FORCE` until it is measured to give that: what was meanwhile to be given
would all come at once when it is back.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from cartgrasp.contacts import ContactWrenches
from cartgrasp.frames import Array
from cartgrasp.motion import Measurement

from ..limits import WrenchRate
from ..limits.wrench_rate import towards
from .caution import MAX_STEP_GAP

FORGETTING_TIME_CONSTANT = 0.2
"""s."""
MIN_COMMAND_RMS, IDLE_FRACTION = 5.0, 0.25
"""N, rms of the commanded force, below which noise could be all that is measured; the share of it below which an arm is
idle."""
PROBE_FORCE, RETURN_FRACTION = 5.0, 0.5
"""N; the share of it from which on an arm is back. One whose command is less than half of this is not known to be idle
any more."""


@dataclass(frozen=True)
class CommandTracking:
    """By arm, exponentially weighted means of commanded · measured and of commanded · commanded force, N², and over how
    long (s); the idle arms, with the share of their commands that they give; and when each told what it gave (s)."""

    cross_power: Mapping[str, float] = field(default_factory=dict)
    command_power: Mapping[str, float] = field(default_factory=dict)
    lasting: Mapping[str, float] = field(default_factory=dict)
    idle: Mapping[str, float] = field(default_factory=dict)
    times: Mapping[str, float] = field(default_factory=dict)

    def heard(self, commanded: Mapping[str, Array], measurement: Measurement) -> CommandTracking:
        """After what arms tell that they gave of their commands, wrenches (6,) in {a}; they may tell it in samples of
        their own."""
        now = self
        for arm, wrench in measurement.wrenches.items():
            since = measurement.time - now.times.get(arm, -math.inf)
            if not -MAX_STEP_GAP <= since <= 0.0:
                elapsed = min(since, MAX_STEP_GAP) if 0.0 < since < math.inf else 0.0  # none: the clock was set back
                now = replace(now.after(commanded, {arm: wrench}, elapsed), times={**now.times, arm: measurement.time})
        return now

    def after(self, commanded: Mapping[str, Array], measured: Mapping[str, Array], duration: float) -> CommandTracking:
        """So many s later, in which arms were to give wrenches (6,) in {a}, and gave the measured ones."""
        kept = math.exp(-duration / FORGETTING_TIME_CONSTANT)
        cross, power, lasting = dict(self.cross_power), dict(self.command_power), dict(self.lasting)
        for arm in measured.keys() & commanded.keys():
            fx, fy, fz = commanded[arm][:3].tolist()
            x, y, z = np.asarray(measured[arm], dtype=float)[:3].tolist()
            cross[arm] = kept * cross.get(arm, 0.0) + (1.0 - kept) * (fx * x + fy * y + fz * z)
            power[arm] = kept * power.get(arm, 0.0) + (1.0 - kept) * (fx * fx + fy * fy + fz * fz)
            lasting[arm] = lasting.get(arm, 0.0) + duration
        return CommandTracking(cross, power, lasting, self._idle(cross, power), self.times)

    def _idle(self, cross_power: Mapping[str, float], command_power: Mapping[str, float]) -> Mapping[str, float]:
        found = {}
        for arm, power in command_power.items():
            if self.lasting.get(arm, 0.0) < FORGETTING_TIME_CONSTANT:
                continue
            was_idle = arm in self.idle
            rms, share = (PROBE_FORCE / 2.0, RETURN_FRACTION) if was_idle else (MIN_COMMAND_RMS, IDLE_FRACTION)
            if power > rms**2 and abs(cross_power[arm]) < share * power:  # also where a sensor has the other sign
                found[arm] = cross_power[arm] / power
        return found


def probed(
    given: ContactWrenches, idle: Collection[str], rates: Mapping[str, WrenchRate | None], last: Mapping[str, Array]
) -> ContactWrenches:
    """With no more than that of idle arms, as soon as their rates allow from what was given last."""
    if not idle:
        return given
    probes = {name: towards(rates[name], last.get(name), probing(given.wrenches[name])) for name in idle}
    return replace(given, wrenches={**given.wrenches, **probes})


def probing(wrench: Array) -> Array:
    """A wrench (6,) of which the force is `PROBE_FORCE` at most."""
    force = float(np.linalg.norm(wrench[:3]))
    return wrench if force <= PROBE_FORCE else PROBE_FORCE / force * wrench
