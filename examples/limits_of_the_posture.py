"""Two KUKA iiwa 14 pull a 160 kg cart back, regrasp lower while it drives, and stop when a joint feels too much.

A robot that works among people stops when a joint feels more than 10 N·m from outside (our choice). Arms that are given
by boxes of forces trip it; arms that are given by their URDF keep within it, at each posture that they take.
"""

import sys
from functools import partial
from importlib.resources import files

import numpy as np

import cartgrasp as cg
from cartgrasp.effects import RollingResistance
from cartgrasp.roles import ContactChoice, ContactQuery
from cartgrasp.simulation import ModelPlant, SensorNoise, Sensors
from planning import Controller, PathReference, Plan, chain, pause
from planning.references import speed_change, turn

try:
    import pinocchio  # noqa: F401
    import rtbdata
except ImportError:
    print("skipped: this example needs the extra `arms`: pip install '.[arms]'")
    sys.exit()

from cartgrasp.spatial_pose import SpatialPose
from cartgrasp.urdf_arm import read_urdf_arm
from cartgrasp.urdf_postures import UrdfPostures

URDF = files(rtbdata) / "xacro/kuka_description/kuka_lbr_iiwa/urdf/lbr_iiwa_14_r820.urdf"
FELT, NO_WEIGHT = 10.0, (0.0, 0.0, 0.0)  # N·m from outside, beside what carries the arm
SIDES, ELBOW_UP = {"left": 0.2, "right": -0.2}, np.array((0.0, 0.6, 0.0, -1.6, 0.0, -0.6, 0.0))
iiwa = read_urdf_arm(str(URDF), "tool0", torque_limit=[FELT] * 7)
postures = {
    name: UrdfPostures(iiwa.placed(SpatialPose.of((-0.7, y, 0.7)), NO_WEIGHT), (0.0, np.pi / 2, 0.0), ELBOW_UP)
    for name, y in SIDES.items()
}
hand = partial(cg.Arm, force_limit=(80.0, 80.0, 80.0), moment_limit=(8.0, 8.0, 8.0))
contacts = {name: [(0.0, y, 1.2), (0.0, y, 0.8)] for name, y in SIDES.items()}
boxes = [hand(name, contacts[name]) for name in SIDES]
posed = [hand(name, contacts[name], joints=postures[name]) for name in SIDES]

cart = cg.CartModel(cg.Inertia(160.0, (0.4, 0.0), 16.0)).with_effect(RollingResistance(0.01))
path = PathReference(chain(speed_change(-0.5), turn(1.2, 0.3), speed_change(0.5), pause(1.5)))


class LowerLater:
    """Both hands hold low from 2 s on."""

    def contacts(self, query: ContactQuery) -> ContactChoice:
        return ContactChoice({n: np.array(points[query.time >= 2.0]) for n, points in contacts.items()}, "lower")


def drive(arms: list[cg.Arm]) -> tuple[float, float, Plan, set[str]]:
    """The most that a joint felt, N·m; how far off its path the cart was, m; the last plan; and joints at a limit."""
    controller = Controller(cart, arms, path, contacts=LowerLater(), learn=False)
    controller.warm_up()
    robot, sensors = ModelPlant(cart), Sensors(cart, SensorNoise(force=0.5, moment=0.02), seed=1)
    felt, off, joints = 0.0, 0.0, set[str]()
    while not controller.is_done:
        step = controller.step(sensors.motion(robot.time, robot.motion))
        controller.observe(sensors.wrenches(robot.time, step.given))
        off = max(off, float(np.hypot(*(robot.motion.pose_sb - step.reference.pose_sb)[:2])))
        for name, hand in step.hands.items():
            if not hand.is_away:
                torques = postures[name].joints_at(hand.point, 0.0).torques(step.wrenches[name])
                felt = max(felt, float(np.abs(torques).max()))
        assert isinstance(step.plan, Plan)
        last = step.plan
        joints.update(last.limiting_joints)
        robot.step(step.given, controller.period)
    return felt, off, last, joints


by_boxes, by_postures = drive(boxes), drive(posed)
for what, (felt, off, _, joints) in (("boxes", by_boxes), ("postures", by_postures)):
    print(f"{what}: a joint feels at most {felt:.2f} N·m, the cart is at most {1e3 * off:.1f} mm off its path")
    print(f"  joints at their limit: {', '.join(sorted(joints)) or 'none, as none has one'}")

for words, pull in (("pull back", (-1.0, 0, 0, 0, 0, 0)), ("push ahead", (1.0, 0, 0, 0, 0, 0))):
    farthest = by_postures[2].polytopes["left"].support(pull)  # worked out when asked for
    print(f"at the end left could {words} with {farthest.distance:.0f} N: {', '.join(farthest.limits)}")

assert by_boxes[0] > 1.4 * FELT
assert by_postures[0] <= FELT + 1e-6
assert by_postures[1] < 1.01 * by_boxes[1], "and the cart is driven as well"
