"""An effect of your own among the candidates: a brake of eddy currents, weak at low and at high speeds."""

from dataclasses import dataclass, replace

import numpy as np

from cartgrasp.effects import Contribution, ForceEffect, Parameter, Situation
from cartgrasp.frames import Array
from cartgrasp.studies.shopping_cart import first_guess, scenario
from estimation import diagnose


@dataclass(frozen=True, kw_only=True)
class EddyBrake(ForceEffect):
    """Drag `strength` u / (1 + (u / 0.3)²) against the forward speed u (m/s)."""

    strength: float = 0.0
    name = "eddy_brake"
    parameters = (Parameter("strength", "N·s/m", typical=10.0, lower=0.0),)

    def wrench_b(self, situation: Situation, memory: Array, parameters: Array) -> Contribution:
        u, strength = situation.velocity_b[..., 0], parameters[..., 0]
        bent = 1 + (u / 0.3) ** 2
        front = np.broadcast_shapes(u.shape, strength.shape)  # rows of a log, or many carts at once
        value, by_velocity, by_parameters = (np.zeros((*front, 3, n)) for n in (1, 3, 1))
        value[..., 0, 0], by_parameters[..., 0, 0] = -strength * u / bent, -u / bent
        by_velocity[..., 0, 0] = -strength * (2 - bent) / bent**2
        return Contribution(value[..., 0], by_velocity=by_velocity, by_parameters=by_parameters)


record = scenario(quick=True, plant="model").run()  # stands in for your robot
log, heading = record.log, record.log.pose[:, 2]
assert log.velocity is not None
u = np.cos(heading) * log.velocity[:, 0] + np.sin(heading) * log.velocity[:, 1]
braked = {name: replace(arm, wrench=arm.wrench.copy()) for name, arm in log.arms.items()}
for arm in braked.values():
    arm.wrench[:, 0] += 20.0 * u / (1 + (u / 0.3) ** 2) / len(braked)  # what the hands give beside
found = diagnose(replace(log, arms=braked), first_guess(), candidates=[EddyBrake()])
print(found.sentence)
(effect,) = [effect for effect in found.effects if effect.name == "eddy_brake"]
print("strength {:.1f} ± {:.1f} {}".format(*effect.parameters["strength"]))
