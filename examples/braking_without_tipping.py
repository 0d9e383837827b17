"""How hard hands at 1 m height may brake a cart: until its casters lift, and less once its load is known better."""

import math
from functools import partial
from pathlib import Path

import numpy as np

import cartgrasp as cg
from planning import Skid, TipOver, WrenchPlanner

cart = cg.load_cart(Path(__file__).parent / "cart.yaml")
# Hands that don't press down or lift.
holding = partial(cg.Arm, force_limit=(150.0, 60.0, 0.0), moment_limit=(8.0, 8.0, 6.0))
arms = [holding("left", [(-0.25, 0.2, 1.0)]), holding("right", [(-0.25, -0.2, 1.0)])]
planner = WrenchPlanner(cart, arms, cart_limits=[TipOver(10.0), Skid(0.5)], relax=math.inf)

asked = (-200.0, 0.0, 0.0)
empty_front = cart.with_inertia(cg.Inertia(24.0, (0.15, 0.0), 2.0))  # as a filter might learn: the load lies far back
motion = cg.Motion(np.zeros(3), np.array([1.0, 0.0]))
pulled = []
for name, model in (("as believed", cart), ("as learnt", empty_front)):
    estimate = cg.Estimate(0.0, motion, {}, "good", model, model.parameters)
    plan = planner.plan(asked, estimate=estimate)
    pulled.append(-plan.contact_wrenches.wrench_b[0])
    print(f"{name}: {plan.status}, pull with {pulled[-1]:.1f} N; active: {', '.join(plan.active)}")
    assert plan.status == "relaxed"
    assert any(limit.startswith("wheel") for limit in plan.active)

assert pulled[1] < 0.7 * pulled[0]
