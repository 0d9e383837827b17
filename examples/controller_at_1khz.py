"""Call the planner from a 1 kHz controller: a cart is pushed along a curve, and the planner is never too late."""

import time
from functools import partial
from pathlib import Path

import numpy as np

import cartgrasp as cg
from cartgrasp.simulation import ModelPlant
from planning import PathReference, WrenchPlanner, build_tracker, chain, speed_change, turn

PERIOD = 1e-3  # s

cart = cg.load_cart(Path(__file__).parent / "cart.yaml")
holding = partial(cg.Arm, force_limit=(60.0, 60.0, 40.0), moment_limit=(8.0, 8.0, 6.0))
arms = [holding("left", [(-0.25, 0.2, 1.0)]), holding("right", [(-0.25, -0.2, 1.0)])]
path = PathReference(chain(speed_change(0.4), turn(0.5, 0.4), speed_change(-0.4)))

plant, tracker = ModelPlant(cart), build_tracker(cart.constraints)
planner = WrenchPlanner(cart, arms, period=PERIOD)
planner.warm_up()  # what costs is done here, not at the first tick

spent, errors, held = [], [], 0
for _ in range(int(path.duration / PERIOD)):
    reference = path.at(plant.time)
    start = time.perf_counter()
    plan = planner.plan_or_hold(tracker.wrench_b(reference, plant.motion, cart))
    spent.append(time.perf_counter() - start)
    held += plan.status != "optimal"
    errors.append(np.hypot(*(plant.motion.pose_sb - reference.pose_sb)[:2]))
    plant.step(plan.contact_wrenches, PERIOD)

print(f"{len(spent)} ticks, {held} held; off the path by {1e3 * max(errors):.2f} mm at most")
print(f"a tick of tracker and planner takes {1e6 * np.median(spent):.0f} µs (median) of {1e6 * PERIOD:.0f} µs")
assert max(errors) < 5e-3
assert np.median(spent) < PERIOD
