"""Two KUKA iiwa 14 arms push a 60 kg cart up a 3 % ramp: which contact height and posture lets them, which doesn't?

Two answers. The drives push many times what is needed wherever the handle is in reach. A robot that works among people
and stops when a joint feels more than 10 N·m from outside pushes only where its levers are short.
`python examples/kuka_ramp.py FILE.png` also draws both.
"""

import sys
from functools import partial
from importlib.resources import files
from itertools import product
from pathlib import Path

import numpy as np

import cartgrasp as cg
from cartgrasp import JointTorques
from cartgrasp.effects import FloorSlope, RollingResistance
from planning import WrenchPlanner

try:
    import pinocchio  # noqa: F401
    import rtbdata
except ImportError:
    print("skipped: this example needs the extra `arms`: pip install '.[arms]'")
    sys.exit()

from cartgrasp.arm_postures import find_posture
from cartgrasp.spatial_pose import SpatialPose
from cartgrasp.urdf_arm import LinkMass, read_urdf_arm
from planning import WrenchPolytope
from planning.polytopes.polytope_projection import project
from planning.polytopes.push_capacity import push_capacity

# --- the arms -------------------------------------------------------------------------------------------------
URDF = files(rtbdata) / "xacro/kuka_description/kuka_lbr_iiwa/urdf/lbr_iiwa_14_r820.urdf"  # kinematics alone
DRIVE_TORQUE = (320.0, 320.0, 176.0, 176.0, 110.0, 40.0, 40.0)  # N·m; KUKA, brochure of the LBR iiwa, axis data
MASSES = (  # kg and m; documentation of Exp[licit] (explicit-robotics.github.io): we know of none by KUKA
    LinkMass("link_1", 6.404, (0.0, -0.014, 0.2545)),
    LinkMass("link_2", 7.890, (0.0, 0.003, 0.0640)),
    LinkMass("link_3", 2.540, (0.0, 0.019, 0.3305)),
    LinkMass("link_4", 4.820, (0.0, -0.009, 0.0860)),
    LinkMass("link_5", 1.760, (0.0, -0.013, 0.2785)),
    LinkMass("link_6", 2.500, (0.0, -0.002, 0.0160)),
    LinkMass("link_7", 0.420, (0.0, 0.000, 0.0906)),
)
OTHER_MASSES = (  # those of Drake's iiwa description (iiwa14_polytope_collision.urdf), turned into this URDF's frames
    LinkMass("link_1", 5.76, (0.0, -0.03, 0.2775)),
    LinkMass("link_2", 6.35, (-0.0003, 0.042, 0.059)),
    LinkMass("link_3", 3.5, (0.0, 0.03, 0.3345)),
    LinkMass("link_4", 3.5, (0.0, -0.034, 0.067)),
    LinkMass("link_5", 3.5, (-0.0001, -0.021, 0.2605)),
    LinkMass("link_6", 1.8, (0.0, 0.0004, 0.0006)),
    LinkMass("link_7", 1.2, (0.0, 0.0, 0.101)),
)
FELT_TORQUE = 10.0  # N·m from outside at which the robot stops: our choice, not KUKA's
PLATFORM, HALF_WIDTH = 0.7, 0.2  # m: the arms stand upright on a platform, one behind each hand
read = partial(read_urdf_arm, str(URDF), "tool0", torque_limit=DRIVE_TORQUE)
iiwa, other = (read(added_masses=masses) for masses in (MASSES, OTHER_MASSES))
postures = np.random.default_rng(0).uniform(iiwa.lower, iiwa.upper, (5000, 7))
own, others = (np.array([arm.gravity_torque(posture) for posture in postures]) for arm in (iiwa, other))
doubt = np.abs(own - others)
print(f"own weight: at most {np.abs(own).max():.0f} N·m over {len(postures):,} random postures; Drake's masses differ")
print(f"by at most {doubt.max():.1f} N·m, {100 * (doubt / DRIVE_TORQUE).max():.1f} % of a joint's limit\n")
MIRROR = np.array([-1, 1, -1, 1, -1, 1, -1])
ELBOWS = {
    "up": (0.0, 0.6, 0.0, -1.6, 0.0, -0.6, 0.0),
    "out": (1.3, 1.0, -1.5, -1.6, 1.0, 0.6, 0.0),
}  # left arm's starts
HANDS = {"forward": np.pi / 2, "from above": np.pi}  # pitch of the flange: it points ahead, or down

# --- the push -------------------------------------------------------------------------------------------------
GRADE = 0.03
gravity_b = -9.81 / np.hypot(1.0, GRADE) * np.array([GRADE, 0.0, 1.0])
cart = cg.CartModel(cg.Inertia(60.0, (0.4, 0.0), 6.0), cg.RollingConstraints(0.0))
cart = cart.with_effect(FloorSlope(grade_x=GRADE)).with_effect(RollingResistance(0.02))
push = cart.planar_wrench(cart.required_wrench(cart.state(velocity=(0.3, 0.0)), np.array([0.3, 0.0])))


def arms_at(hand: str, elbow: str, height: float, standoff: float) -> tuple[list[cg.Arm], list[cg.Arm]] | None:
    """Both arms by their drives, and both by what their joints may feel; none where out of reach."""
    by_drives, by_feeling = [], []
    for name, side, mirror in (("left", HALF_WIDTH, 1), ("right", -HALF_WIDTH, MIRROR)):
        placed = iiwa.placed(SpatialPose.of((-standoff, side, PLATFORM)), gravity_b)
        handle = SpatialPose.of((0.0, side, height), pitch=HANDS[hand])
        posture = find_posture(placed, handle, mirror * np.array(ELBOWS[elbow]), restarts=0)
        if not posture.reached:
            return None
        drives = placed.joint_torques(posture.configuration)
        felt = JointTorques(drives.jacobian, np.zeros(7), np.full(7, FELT_TORQUE))
        open_hand = partial(cg.Arm, name, [handle.position], moment_limit=(0.0, 0.0, 0.0), friction=cg.Friction(0.5, 8))
        by_drives.append(open_hand(joints=drives))
        by_feeling.append(open_hand(joints=felt))
    return by_drives, by_feeling


heights, standoffs = np.arange(0.4, 1.7, 0.2).round(1), np.arange(0.4, 0.95, 0.1).round(1)
drives, felt = {}, {}
print(f"needed: {push[0]:.1f} N (slope, rolling resistance, 0.3 m/s²), half by each arm")
for posture in product(HANDS, ELBOWS):
    drives[posture], felt[posture] = np.full((2, len(heights), len(standoffs)), np.nan)
    for (row, height), (column, standoff) in product(enumerate(heights), enumerate(standoffs)):
        arms = arms_at(*posture, height, standoff)
        if arms is not None:
            drives[posture][row, column] = push_capacity(cart, arms[0], push).multiple
            felt[posture][row, column] = push_capacity(cart, arms[1], push).multiple
    print(f"\nhand {posture[0]}, elbow {posture[1]}: times the push by the drives | with {FELT_TORQUE:g} N·m felt")
    print("  contact " + "".join(f"{standoff:12.1f} m" for standoff in standoffs) + " before the arms' bases")
    for height, by_drives, by_feeling in zip(heights, drives[posture], felt[posture], strict=True):
        cells = (f"{d:7.1f} |{f:5.2f}" if d > 0 else 14 * " " for d, f in zip(by_drives, by_feeling, strict=True))
        print(f"  {height:.1f} m   " + "".join(cells))

weakest = min(np.nanmin(map_) for map_ in drives.values())
print(f"\ndrives: every posture in reach can; the weakest gives {weakest:.0f} times the push")
for (hand, elbow), map_ in felt.items():
    counts = f"{(map_ >= 1).sum()} places can, {(map_ < 1).sum()} can't, {np.isnan(map_).sum()} are out of reach"
    print(f"felt, hand {hand}, elbow {elbow}: {counts}")

# --- the planner says the same ----------------------------------------------------------------------------------
good, bad = ("forward", "up", 1.0, 0.9), ("from above", "up", 0.4, 0.4)
places = {where: arms_at(*where) for where in (good, bad)}
feeling = {where: arms[1] for where, arms in places.items() if arms is not None}
plans = {where: WrenchPlanner(cart, arms).plan(push) for where, arms in feeling.items()}
proof, nearest = plans[bad].certificate, plans[bad].nearest
assert proof is not None
assert nearest is not None
print(f"\nat {good}: {plans[good].status}; at {bad}: {plans[bad].status}: {proof.words}")

assert (doubt / DRIVE_TORQUE).max() < 0.03, "whose masses one believes hardly matters"
# Hanging hands bear the push at their last bend, the flange's 0.126 m: 40 N·m there are the drives' least.
assert np.isclose(weakest, 40.0 / (0.126 * push[0] / 2), rtol=0.01)
assert np.isnan(drives["forward", "up"][0]).all(), "a handle at 0.4 m is out of reach of hands that point ahead"
assert np.isnan(drives["from above", "up"][-1]).all(), "and one at 1.6 m of hands that hang down"
assert np.nanmin(felt["forward", "up"]) > 1
assert (felt["from above", "up"][:3, 0] < 1).all(), "low and near, the levers of hands that hang down are too long"
assert felt["from above", "up"][1, 1] < 1 < felt["from above", "out"][1, 1], "there, turning the elbow out is enough"
assert plans[good].status == "optimal"
assert plans[bad].status == "infeasible"
assert np.isclose(nearest.wrench[0], felt["from above", "up"][0, 0] * push[0], rtol=1e-5)

if len(sys.argv) > 1:
    from matplotlib.figure import Figure

    from cartgrasp.view.arm_plots import draw_needed_push, draw_push_map, draw_wrench_shadow
    from cartgrasp.view.figures import save_figure
    from cartgrasp.view.plots import BLUE, VERMILLION, house_style

    with house_style():
        figure = Figure(figsize=(7.2, 5.8))
        figure.suptitle(f"Times the needed push, where joints may feel {FELT_TORQUE:g} N·m (hatched: out of reach)")
        *panels, shadows = figure.subplots(2, 2).ravel()
        for axes, posture in zip(panels, (("forward", "up"), ("from above", "up"), ("from above", "out")), strict=True):
            draw_push_map(axes, standoffs, heights, felt[posture])
            axes.set_title(f"hand {posture[0]}, elbow {posture[1]}")
        for where, color in ((good, BLUE), (bad, VERMILLION)):
            shadow = project(WrenchPolytope.of(feeling[where][0]), ("fx", "fz"))
            draw_wrench_shadow(shadows, shadow, ("fx", "fz"), label=f"{where[0]}, at {where[2]} m", color=color)
        draw_needed_push(shadows, push[0] / 2)
        shadows.set_title("what one arm can give, elbow up")
        shadows.legend()
    print("drawn:", save_figure(figure, Path(sys.argv[1])))
