"""One hand anywhere on a handle, within its reach and what its joints bear: where it holds; no point is better.

`python examples/one_hand_on_a_handle.py FILE.png` also draws it.
"""

import sys
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
places = np.linspace(-0.15, 0.3, 46)

drawn = []
for wrench in ((40.0, 0.0, 2.0), (40.0, 0.0, -5.0), (40.0, 0.0, 8.0)):
    plan = planner.plan(wrench)
    y = plan.contacts["hand"][1]
    print(f"{wrench[2]:5.1f} N·m: hold at y = {y:.3f} m; active: {', '.join(plan.active) or 'no limit'}")
    tried = [planner.plan_or_hold(wrench, contacts={"hand": (-0.25, place, 1.0)}) for place in places]
    efforts = [np.nan if other.effort is None or other.status != "optimal" else other.effort for other in tried]
    best = np.nanmin(efforts)
    assert plan.status == "optimal"
    assert -0.15 - 1e-9 <= y <= 0.3
    assert plan.effort is not None
    assert plan.choice is not None
    assert plan.effort <= best + 1e-9
    assert plan.choice.gap < 1e-9
    drawn.append((wrench, y, plan.effort, efforts))

if len(sys.argv) > 1:
    from matplotlib.figure import Figure

    from cartgrasp.view.figures import save_figure
    from cartgrasp.view.plots import OKABE_ITO, house_style

    with house_style():
        figure = Figure(figsize=(5.0, 3.2), layout="constrained")
        axes = figure.subplots()
        for color, (wrench, y, effort, efforts) in zip(OKABE_ITO, drawn, strict=False):
            label = f"{wrench[0]:g} N and {wrench[2]:g} N·m".replace("-", "−")
            axes.plot(places, efforts, color=color, label=label)
            axes.plot(y, effort, "o", color=color)
        axes.set(xlabel="Hand on the handle, y (m), as far as it reaches", ylabel="Effort (N²)", xlim=(-0.16, 0.31))
        axes.set_title("Lines: efforts where the push can be given; dots: what is chosen")
        figure.legend(loc="outside upper center", ncols=3)
    print("drawn:", save_figure(figure, Path(sys.argv[1])))
