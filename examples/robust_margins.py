"""How hard may hands brake a cart whose load is being learned? As hard as holds for 99 % of what is still believed."""

import math
from functools import partial
from pathlib import Path

import numpy as np

import cartgrasp as cg
from cartgrasp.simulation import ModelPlant, SensorNoise, Sensors
from estimation import CartFilter, FilterNoise, Prior
from planning import TipOver, WrenchPlanner

believed = cg.load_cart(Path(__file__).parent / "cart.yaml")
truth = believed.with_inertia(cg.Inertia(26.0, (0.27, 0.02), 2.2))
# Hands that don't press down or lift.
holding = partial(cg.Arm, force_limit=(150.0, 60.0, 0.0), moment_limit=(4.0, 4.0, 10.0))
arms = [holding("left", [(-0.25, 0.2, 1.0)]), holding("right", [(-0.25, -0.2, 1.0)])]

plant, sensors = ModelPlant(truth), Sensors(truth, SensorNoise(force=1.0, moment=0.05))
prior = Prior(mass=0.15, com=0.04, inertia=0.3, slope=0.0, known=frozenset({"viscous_drag"}))  # a level floor
cart_filter = CartFilter(believed, ["left", "right"], noise=FilterNoise(force=1.0, moment=0.05), prior=prior)
pushing = WrenchPlanner(believed, arms, period=0.01)
plain = WrenchPlanner(believed, arms, cart_limits=[TipOver(10.0)], relax=math.inf)
robust = WrenchPlanner(believed, arms, cart_limits=[TipOver(10.0)], relax=math.inf, confidence=0.99)


def hardest(planner: WrenchPlanner, estimate: cg.Estimate) -> float:
    """Braking, N, that leaves each wheel 10 N."""
    return -float(planner.plan((-300.0, 0.0, 0.0), estimate=estimate).contact_wrenches.wrench_b[0])


known = cg.Estimate(0.0, plant.motion, {}, "", truth, truth.parameters)
most = hardest(WrenchPlanner(truth, arms, cart_limits=[TipOver(10.0)], relax=math.inf), known)
print(f"cart known: {most:.0f} N")
allowed = []
for tick in range(351):  # straight on, which can't teach where along x the load lies; then in curves
    estimate = cart_filter.update(sensors.motion(plant.time, plant.motion))
    if tick % 70 == 0:
        allowed.append([hardest(plain, estimate), hardest(robust, estimate)])
        com_x = estimate.parameters["com_x"]
        print(f"{plant.time:.1f} s, CoM at {com_x.value:.3f} ± {com_x.std:.3f} m:", end=" ")
        print("{:.0f} N, with margins {:.0f} N".format(*allowed[-1]))
    forward, turn = (28.0, 0.0) if tick < 70 else (4.0, 14.0 * math.cos(0.06 * (tick - 70)))
    given = pushing.plan_or_hold((forward, 0.0, turn)).contact_wrenches
    cart_filter.update(sensors.wrenches(plant.time, given))
    plant.step(given, 0.01)

margins = -np.diff(allowed).ravel()
print(f"margins: {margins[1]:.0f} N after the straight, {margins[-1]:.0f} N in the end")
assert max(with_margins for _, with_margins in allowed) < most
assert max(without for without, _ in allowed) > most
assert margins[-1] < 0.3 * margins[1]
