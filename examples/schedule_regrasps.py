"""When to regrasp over the next seconds: worth it once the cart is known to be heavy, not before.

Two arms hold a handle off its middle, so that pushing costs them moment. A regrasp takes 0.75 s, in which the other
arm bears the whole, and 60 N²·s of effort. The schedule is a pure function: when the estimate changes, call it again
with what is held now.
"""

from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

import cartgrasp as cg
from planning import Grip, Horizon, PathReference, RegraspCost, Stretch, chain, pause, plan_schedule, turn

cart = cg.load_cart(Path(__file__).parent / "cart.yaml")
holding = partial(cg.Arm, force_limit=(120.0, 60.0, 40.0), moment_limit=(20.0, 20.0, 20.0))
left = holding("left", [(-0.25, 0.35, 1.0), (-0.25, 0.1, 1.0)])
right = holding("right", [(-0.25, 0.2, 1.0), (-0.25, -0.1, 1.0)])
path = PathReference(chain(pause(1.0), [Stretch(1.5, 0.4)], turn(1.0, 0.4), pause(2.0), [Stretch(1.5, -0.4)]))

held = {arm.name: Grip(arm.contacts.first) for arm in (left, right)}
cost = RegraspCost(duration=0.75, effort=60.0)
light = plan_schedule(
    path, cart.with_inertia(cg.Inertia(12.0, (0.3, 0.0), 1.0)), [left, right], cost, Horizon(held=held)
)
print(f"thought to weigh 12 kg: {len(light.regrasps)} regrasps, {light.total:.0f} N²·s")

now = 0.25
heavy = cart.with_inertia(cg.Inertia(40.0, (0.3, 0.0), 3.0))
schedule = plan_schedule(path, heavy, [left, right], cost, Horizon(now=now, held=light.grips(now)))
for r in schedule.regrasps:
    print(f"{r.arm}: from y = {r.origin[1]} to {r.target[1]} m, {r.start:.2f} to {r.stop:.2f} s")
stay = plan_schedule(path, heavy, [left, right], replace(cost, effort=1e9), Horizon(now=now, held=light.grips(now)))
print(f"now known to weigh 40 kg: {schedule.total:.0f} N²·s instead of {stay.total:.0f} by staying;")
print(f"no schedule costs less than {schedule.bound:.0f} ({schedule.solved} QPs solved)")

assert not light.regrasps
assert schedule.regrasps
assert schedule.total < stay.total
assert np.isclose(schedule.bound, schedule.total)
