"""A wrench that can't be given: the proof in words, the nearest one, where a hand would do, and a relaxed plan."""

import math
from functools import partial
from pathlib import Path

import cartgrasp as cg
from planning import WrenchPlanner

cart = cg.load_cart(Path(__file__).parent / "cart.yaml")
holding = partial(cg.Arm, force_limit=(60.0, 60.0, 40.0), moment_limit=(8.0, 8.0, 6.0), friction=cg.Friction(mu=0.3))
hand = holding("hand", [(-0.25, 0.2, 1.0)])
asked = (40.0, 0.0, 3.0)

plan = WrenchPlanner(cart, [hand]).plan(asked)
print(f"{plan.status}: {plan.message}")
assert plan.nearest is not None
assert plan.certificate is not None
fx, fy, tau = plan.nearest.wrench
print(f"nearest: {fx:.2f} N forward and {tau:.2f} N·m, {plan.nearest.distance:.2f} away")
assert plan.status == "infeasible"
assert plan.certificate.verified

assert plan.certificate.remedy is not None
moved = holding("hand", [plan.certificate.remedy["hand"]])
there = WrenchPlanner(cart, [moved]).plan(asked)
print(f"with the hand there: {there.status}, effort {there.effort:.0f}")
assert there.status == "optimal"

relaxed = WrenchPlanner(cart, [hand], relax=math.inf).plan(asked)
missing = ", ".join(f"{row} {value:.2f}" for row, value in relaxed.missing.items())
print(f"{relaxed.status}: left out are {missing}; active: {', '.join(relaxed.active)}")
assert relaxed.status == "relaxed"
assert relaxed.certificate is not None
assert relaxed.certificate.verified
