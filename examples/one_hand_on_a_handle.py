"""One hand anywhere on a handle, within its reach and what its joints bear: where it holds; no point is better."""

from pathlib import Path

import numpy as np

import cartgrasp as cg
from planning import WrenchPlanner

cart = cg.load_cart(Path(__file__).parent / "cart.yaml")
links = np.zeros((6, 3))  # three upright joints of an arm stretched out behind the handle: lever arms to the hand, m
links[1], links[5] = (0.9, 0.5, 0.15), 1.0
hand = cg.Arm(
    "hand",
    segment=[(-0.25, -0.3, 1.0), (-0.25, 0.3, 1.0)],
    force_limit=(80.0, 60.0, 40.0),
    joints=cg.JointTorques(links, np.zeros(3), np.array([1.5, 4.0, 3.0])),
    reach=cg.Reach.box((-0.5, -0.15, 0.5), (0.0, 0.3, 1.5)),
)
planner = WrenchPlanner(cart, [hand])

for wrench in ((40.0, 0.0, 2.0), (40.0, 0.0, -5.0), (40.0, 0.0, 8.0)):
    plan = planner.plan(wrench)
    y = plan.contacts["hand"][1]
    print(f"{wrench[2]:5.1f} N·m: hold at y = {y:.3f} m; active: {', '.join(plan.active) or 'no limit'}")
    places = [(-0.25, place, 1.0) for place in np.linspace(-0.15, 0.3, 46)]
    tried = [planner.plan_or_hold(wrench, contacts={"hand": place}) for place in places]
    best = min(other.effort for other in tried if other.status == "optimal")
    assert plan.status == "optimal"
    assert -0.15 - 1e-9 <= y <= 0.3
    assert plan.effort <= best + 1e-9
    assert plan.choice.gap < 1e-9
