"""A QP solution against an analytic case: where on a handle does a push need least moment at the hand?

With fy = 0 the hand's moment is tau_a = py (m u' + drag) - m dy u', so the best point is
py* = m dy u' / (m u' + drag): between the centre of mass's line and the middle, and 0 at constant speed.
"""

import numpy as np

import cartgrasp as cg
from planning import WrenchPlanner

mass, com_y, drag = 24.0, 0.1, 6.0
cart = cg.CartModel(cg.Inertia(mass, (0.3, com_y), 2.0))
handle = cg.Arm("hand", segment=[(-0.25, -0.3, 1.0), (-0.25, 0.3, 1.0)], weights=(1e-6, 1e3, 1.0, 1.0, 1.0, 1.0))
planner = WrenchPlanner(cart, [handle])

for acceleration in (0.1, 0.3, 0.6):
    push, moment = mass * acceleration + drag, -mass * com_y * acceleration
    plan = planner.plan((push, 0.0, moment))
    best = mass * com_y * acceleration / push
    found = plan.contacts["hand"][1]
    print(f"u' = {acceleration} m/s²: hold at y = {found:.4f} m, closed form {best:.4f} m")
    assert np.isclose(found, best, atol=1e-3)
