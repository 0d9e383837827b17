"""The same push by two arms and by four: the worst-placed arm is spared, hands don't press against each other."""

from functools import partial
from pathlib import Path

import cartgrasp as cg
from planning import InternalForce, Lexicographic, Nothing, WeightedWrench, WorstArm, WrenchPlanner

cart = cg.load_cart(Path(__file__).parent / "cart.yaml")
places = {"left": (-0.25, 0.2, 1.0), "right": (-0.25, -0.2, 1.0)}
places |= {"front left": (0.9, 0.2, 0.8), "front right": (0.9, -0.2, 0.8)}
holding = partial(cg.Arm, force_limit=(60.0, 60.0, 40.0), moment_limit=(8.0, 8.0, 6.0))
asked = (70.0, 0.0, 9.0)
spare_the_worst = Lexicographic(WorstArm(1.0, base=Nothing()), WeightedWrench())

shares = {}
for names in (["left", "right"], list(places)):
    arms = [holding(name, [places[name]]) for name in names]
    planner = WrenchPlanner(cart, arms, objective=spare_the_worst, cart_limits=[InternalForce(5.0)])
    plan = planner.plan(asked)
    share = max(abs(w / arm.wrench_limit).max() for arm, w in zip(arms, plan.wrenches.values(), strict=True))
    shares[len(names)] = share
    print(f"{len(names)} arms: the busiest gives {share:.1%} of a limit; effort {plan.effort:.0f}")
    for name, wrench in plan.wrenches.items():
        print(f"  {name:12s} {wrench.round(2).tolist()}")
    total = plan.contact_wrenches.wrench_b
    assert plan.status == "optimal"
    assert abs(total[0] - asked[0]) < 1e-6
    assert abs(total[2] - asked[2]) < 1e-6
    assert min(plan.margins.values()) > -1e-9

print(f"four arms take the busiest from {shares[2]:.1%} to {shares[4]:.1%}")
assert shares[4] < 0.7 * shares[2]
