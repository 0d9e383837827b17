"""`check_sensors`: what a log's sensors seem to do, one matter after the other, each with those before put right."""

from __future__ import annotations

import math

from cartgrasp.logs import RunLog
from cartgrasp.model import CartModel

from .motion.heading import heading_check, pose_suspicions, poses_put_right
from .motion.units import unit_check, unit_suspicions, units_put_right
from .motion.velocity_clock import late_or_scaled
from .motion.velocity_frame import velocities_turned_right, velocity_check, velocity_suspicions
from .prior import MASS_SPREAD
from .recorder.gaps import holes
from .recorder.jumps import jumps, without_jumps
from .recorder.repeats import repeated, without_repeats
from .recorder.steps import quantised
from .suspicion import SURE, Suspicion
from .wrench.arm_faults import arm_suspicions
from .wrench.contacts import contact_units, contacts_put_right
from .wrench.sensor_readings import mass_evidence, sensor_check
from .wrench.wave import waves


def check_sensors(log: RunLog, cart: CartModel, mass_spread: float = MASS_SPREAD) -> tuple[Suspicion, ...]:
    """What is suspected of a log's sensors, those that stop a command first. `mass_spread` is how sure the cart file's
    mass is: the standard deviation of its log, 0.5 where it is a guess and 0.05 where it was weighed."""
    of_contacts = contact_units(log)
    log = contacts_put_right(log)
    clean = without_jumps(without_repeats(log))
    headings = heading_check(clean, cart)
    rivals = poses_put_right(clean, headings)
    clean = max(rivals, key=lambda one: _soundness(one, cart)) if len(rivals) > 1 else rivals[0]
    velocities = velocity_check(clean)
    clean = velocities_turned_right(clean, velocities)
    is_known = headings is not None and float(headings.probability.max()) >= SURE
    units = unit_check(clean, mass_evidence(clean, cart, mass_spread), is_known)
    in_si = log if units is None else units_put_right(log, units)
    clean = clean if units is None else units_put_right(clean, units)
    found = (
        *pose_suspicions(headings),
        *velocity_suspicions(velocities),
        *(() if units is None else unit_suspicions(units)),
        *of_contacts,
        *arm_suspicions(clean, cart, mass_spread),
        *late_or_scaled(clean),
        *waves(clean),
        *repeated(in_si),
        *quantised(in_si),
        *jumps(in_si),
        *holes(in_si),
    )
    return tuple(sorted(found, key=lambda one: not one.is_refused))


def _soundness(log: RunLog, cart: CartModel) -> float:
    """Log probability that velocities and wrenches are sound beside these poses."""
    arms = sensor_check(log, cart)
    sound = [float(one[0]) for one in velocity_check(log).values()] + ([] if arms is None else [arms.probability[0]])
    return sum(math.log(max(float(one), 1e-300)) for one in sound)
