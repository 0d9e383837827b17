"""Spread a planar wrench over two arms, and hear what can't be done."""

from functools import partial
from pathlib import Path

import cartgrasp as cg
from planning import WrenchPlanner

cart = cg.load_cart(Path(__file__).parent / "cart.yaml")
holding = partial(cg.Arm, force_limit=(60.0, 60.0, 40.0), moment_limit=(8.0, 8.0, 6.0))
left = holding("left", [(-0.25, 0.2, 1.0)], friction=cg.Friction(mu=0.6))
right = holding("right", [(-0.25, -0.2, 1.0)], friction=cg.Friction(mu=0.6))
planner = WrenchPlanner(cart, [left, right])

plan = planner.plan(wrench=(40.0, 0.0, 3.0))
print(plan.status, {name: wrench.round(2).tolist() for name, wrench in plan.wrenches.items()})
total = plan.contact_wrenches.wrench_b
assert plan.residuals is not None
print(f"on the cart: {total[0]:.3f} N forward, {total[2]:.3f} N·m; equality residual {plan.residuals.equality:.0e}")

too_much = planner.plan(wrench=(200.0, 0.0, 0.0))
assert too_much.certificate is not None
assert too_much.nearest is not None
print(too_much.status + ":", too_much.certificate.words)
print("nearest feasible forward force:", round(float(too_much.nearest.wrench[0]), 3), "N")

assert plan.status == "optimal"
assert abs(total[0] - 40.0) < 1e-9
assert too_much.status == "infeasible"
assert abs(too_much.nearest.wrench[0] - 120.0) < 1e-6
