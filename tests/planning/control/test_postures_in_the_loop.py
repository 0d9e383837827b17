"""Arms from a URDF in the closed loop: their limits are those of the posture of now, checked by Pinocchio's inverse
dynamics (RNEA) with the reaction of the wrench at the tool, and by virtual work, where Pinocchio isn't asked."""

from __future__ import annotations

from itertools import pairwise, product
from pathlib import Path

import numpy as np
import pytest

import cartgrasp as cg
from cartgrasp.effects import RollingResistance
from cartgrasp.errors import UsageError
from cartgrasp.roles import ContactChoice
from cartgrasp.simulation import ModelPlant, SensorNoise, Sensors
from cartgrasp.spatial_pose import SpatialPose
from cartgrasp.urdf_arm import read_urdf_arm
from cartgrasp.urdf_postures import UrdfPostures
from planning import Controller, PathReference, WrenchPlanner, chain
from planning.contact_sources.least_effort import LeastEffortContacts
from planning.references import pause, speed_change, turn

from ...docs.given import a_robot

pinocchio = pytest.importorskip("pinocchio", reason="arms from a URDF need the extra `arms`")

CART = cg.CartModel(cg.Inertia(120.0, (0.4, 0.0), 12.0), effects=(RollingResistance(0.02),))
PATH = PathReference(chain(pause(3.0), speed_change(-0.6), turn(1.5, 0.4), speed_change(0.6), pause(0.5)))
SIDES, TORQUE = {"left": 0.2, "right": -0.2}, 52.0  # m, N·m of each joint, of which 37 to 47 carry the arm
BENT = (0.1, 0.6, 1.2, 0.1, -0.3, 0.1)
BASE, HAND = (-0.7, 0.0, 0.3), (0.0, np.pi / 2, 0.0)  # in {b}, m; the tool's z points ahead


def hands(folder: Path, torque: float = TORQUE) -> dict[str, UrdfPostures]:
    path, found = a_robot(folder), {}
    for name, side in SIDES.items():
        arm = read_urdf_arm(path, "tool0", torque_limit=[torque] * 6).placed(SpatialPose.of((BASE[0], side, BASE[2])))
        found[name] = UrdfPostures(arm, HAND, BENT)
    return found


def arms(postures=None, more=(), **other):
    limits = {"force_limit": (150.0,) * 3, "moment_limit": (15.0,) * 3}
    return [
        cg.Arm(
            name,
            [(-0.1, side, 0.75), (0.0, side, 0.9), (0.0, side, 0.6), *more],
            **(limits | other),
            joints=None if postures is None else postures[name],
        )
        for name, side in SIDES.items()
    ]


class InTurn:
    """One candidate after the other: the second once the cart stands with both hands on the first, the third while it
    drives."""

    def __init__(self, holders):
        self.arms = holders

    def contacts(self, query):
        held = {arm.name: arm.contacts.points for arm in self.arms}
        index = int(np.searchsorted((0.5, 5.0), query.time, "right"))
        return ContactChoice({name: np.array(points[index]) for name, points in held.items()}, "told")


def as_they_are(posed):
    """The same arms with the limits of the posture that they have, for good."""
    limits = {"force_limit": posed[0].force_limit, "moment_limit": posed[0].moment_limit}
    return [cg.Arm(arm.name, arm.contacts, joints=arm.joints, **limits) for arm in posed]


def drive(controller, duration=PATH.duration):
    plant, sensors = ModelPlant(CART), Sensors(CART, SensorNoise(force=0.5, moment=0.02), seed=1)
    steps = []
    while plant.time < duration:
        steps.append(controller.step(sensors.motion(plant.time, plant.motion)))
        controller.observe(sensors.wrenches(plant.time, steps[-1].given))
        plant.step(steps[-1].given, controller.period)
    return steps


def rnea(model, configuration, wrench):
    """Joint torques of an arm at rest that carries itself and gives (f, t) in {b}, whose axes are the root's, to what
    is at its tool's origin: inverse dynamics with the reaction of the wrench on the last joint."""
    data, tool = model.createData(), model.getFrameId("tool0")
    pinocchio.framesForwardKinematics(model, data, configuration)
    pose, joint = data.oMf[tool], model.frames[tool].parentJoint
    force = pinocchio.SE3(np.eye(3), pose.translation).act(pinocchio.Force(-wrench[:3], -wrench[3:]))  # in the root
    outside = pinocchio.StdVec_Force()
    outside.extend(pinocchio.Force.Zero() for _ in range(model.njoints))
    outside[joint] = data.oMi[joint].actInv(force)
    zero = np.zeros(model.nv)
    return pinocchio.rnea(model, data, configuration, zero, zero, outside)


def largest_torques(steps, postures, folder):
    """|torque| by RNEA of all ticks in which a hand gives something."""
    model, found = pinocchio.buildModelFromUrdf(str(folder / "arm.urdf")), []
    for step in steps:
        for name, wrench in step.wrenches.items():
            if not (step.hands and step.hands[name].is_away):
                at = postures[name].posture(tuple(step.contacts[name].tolist()))
                assert at.reached
                found.append(np.abs(rnea(model, at.configuration, wrench)).max())
    return np.array(found)


@pytest.fixture
def postures(tmp_path):
    return hands(tmp_path)


def place_of(arm, index):
    return {one.name: np.array(one.contacts.points[index]) for one in arm}


@pytest.mark.long
@pytest.mark.some(1)
@pytest.mark.parametrize(("moment", "beyond"), [(15.0, 4.0), (2.0, 13.0)])
def test_no_joint_is_overloaded_where_boxes_alone_would(moment, beyond, postures, tmp_path):
    """Nor would the limits of the first posture do; the wrench on the cart is the same."""
    posed, largest, statuses = arms(postures, moment_limit=(moment, moment, moment)), {}, {}
    boxes = arms(moment_limit=(moment, moment, moment))
    for way, held in (("now", posed), ("first", as_they_are(posed)), ("box", boxes)):
        controller = Controller(CART, held, PATH, contacts=InTurn(held), learn=False)
        controller.warm_up()
        steps = drive(controller)
        largest[way] = largest_torques(steps, postures, tmp_path)
        statuses[way] = [step.plan.status for step in steps]
        assert {tuple(step.contacts["left"]) for step in steps} >= set(held[0].contacts.points[:2])
        if way == "now":
            limited = [step.words for step in steps if step.plan.limiting_joints]
            assert any("at its limit is left: joint j1 torque lower" in words for words in limited)
    assert largest["now"].max() == pytest.approx(TORQUE, abs=1e-6)
    assert largest["first"].max() > TORQUE + beyond
    assert largest["box"].max() > TORQUE + beyond
    assert statuses["now"] == statuses["box"]


def test_limits_are_what_inverse_dynamics_say(postures, tmp_path):
    """At random configurations, under random wrenches."""
    rng, model = np.random.default_rng(0), pinocchio.buildModelFromUrdf(str(tmp_path / "arm.urdf"))
    arm = read_urdf_arm(tmp_path / "arm.urdf", "tool0", torque_limit=[1e3] * 6)
    for configuration, wrench in zip(rng.uniform(-3, 3, (100, 6)), rng.uniform(-50, 50, (100, 6)), strict=True):
        expected = rnea(model, configuration, wrench)
        assert arm.joint_torques(configuration).torques(wrench) == pytest.approx(expected, abs=1e-9)


def test_nothing_is_compiled_anew_and_what_stays_is_not_looked_for(postures, monkeypatch):
    held, sought = arms(postures), []
    planner = WrenchPlanner(CART, held)
    planner.warm_up()
    compiled, template = planner._now.compiled, planner._now.terms.base
    monkeypatch.setattr("cartgrasp.urdf_postures.find_posture", lambda *_, **__: sought.append(1))
    limits = []
    for index in (0, 1, 2, 1, 1):
        plan = planner.plan_or_hold((30.0, 0.0, 1.0), place_of(held, index))
        assert plan.solver == "dual active set"
        assert planner._now.compiled is compiled
        limits.append(planner._now.terms.base)
    assert template is not limits[1]
    assert limits[3] is limits[4]
    assert not sought, "every candidate's posture is known when the planner is made"
    assert plan.arms[0].joints is held[0].at(held[0].contacts.points[1]).joints


def test_a_hand_is_not_sent_where_no_posture_was_found(postures):
    far = (0.9, 0.0, 1.0)
    held = arms(postures, more=[far])
    controller = Controller(CART, held, PATH, contacts=SecondAt(held, far), learn=False)
    words = [step.words for step in drive(controller, 0.3)]
    assert words[0] == "holds left at (−0.10, 0.20): told; holds right at (−0.10, −0.20): told"
    why = "no posture was found with the hand at (0.9, 0, 1); the nearest stays "
    assert f"keeps left at (−0.10, 0.20): arm left: {why}" in words[-1]
    planner = WrenchPlanner(CART, held)
    assert far not in planner._now.terms.sets["left"].points
    plan = planner.plan_or_hold((30.0, 0.0, 0.0), {"left": far, "right": held[1].contacts.points[0]})
    assert plan.status == "invalid_input"
    assert plan.message.startswith(f"arm left: {why}")
    with pytest.raises(UsageError, match="no posture was found"):
        cg.Arm("left", [far], joints=postures["left"])


class SecondAt:
    """Both hands at their first contact, and from 0.1 s on the left one is to go elsewhere."""

    def __init__(self, holders, there):
        self.first, self.there = {arm.name: arm.contacts.first for arm in holders}, np.array(there)

    def contacts(self, query):
        return ContactChoice(self.first | ({"left": self.there} if query.time > 0.1 else {}), "told")


def test_a_base_that_moves_takes_its_postures_along(postures, tmp_path):
    """The robot falls back by 1 cm a tick: the hand stays, joints turn a little, and the limits are others."""
    held, model = arms(postures), pinocchio.buildModelFromUrdf(str(tmp_path / "arm.urdf"))
    planner, points = WrenchPlanner(CART, held), place_of(held, 1)
    planner.warm_up()
    compiled, data, found = planner._now.compiled, model.createData(), []
    for k in range(20):
        x = BASE[0] - 0.01 * k
        for name, side in SIDES.items():
            postures[name].place(SpatialPose.of((x, side, BASE[2])))
        plan = planner.plan_or_hold((-90.0, 0.0, 0.0), points)
        assert planner._now.compiled is compiled
        found.append(postures["left"].posture(tuple(points["left"].tolist())).configuration)
        pinocchio.framesForwardKinematics(model, data, found[-1])
        in_root = points["left"] - np.array([x, SIDES["left"], BASE[2]])
        assert data.oMf[model.getFrameId("tool0")].translation == pytest.approx(in_root, abs=1e-6)
        if plan.status == "optimal":
            assert np.abs(rnea(model, found[-1], plan.wrenches["left"])).max() <= TORQUE + 1e-6
    assert max(np.abs(b - a).max() for a, b in pairwise(found)) < 0.05
    for name, side in SIDES.items():
        postures[name].place(SpatialPose.of((-3.0, side, BASE[2])))
    lost = planner.plan_or_hold((-90.0, 0.0, 0.0), points)
    assert lost.status == "invalid_input"
    assert "no posture was found with the hand at (0, 0.2, 0.9)" in lost.message


def test_contacts_are_chosen_by_the_limits_that_hold_there(postures):
    """300 N by open hands: least effort is sought with each choice's own limits, as by planners made for each. A
    planner that chooses alone looks at the limits of now, and says that this proves nothing of others."""
    held, wanted, efforts = arms(postures, moment_limit=(0, 0, 0)), np.array([300.0, 0.0, 0.0]), {}
    source = LeastEffortContacts(WrenchPlanner(CART, held), held, 1.0, least_gain=0.0)
    source._wanted = wanted
    source._regrasp()
    for choice in product(*(arm.contacts.points for arm in held)):
        there = as_they_are([arm.at(point) for arm, point in zip(held, choice, strict=True)])
        contacts = {arm.name: point for arm, point in zip(held, choice, strict=True)}
        efforts[choice] = WrenchPlanner(CART, there).plan_or_hold(wanted, contacts).effort
    chosen = tuple(tuple(point.tolist()) for point in source._held.values())
    assert efforts[chosen] == pytest.approx(min(efforts.values()), rel=1e-9)
    assert chosen == ((0.0, 0.2, 0.9), (0.0, -0.2, 0.9))
    plan = WrenchPlanner(CART, held).plan(wanted)
    assert plan.effort == pytest.approx(efforts[tuple(tuple(p.tolist()) for p in plan.contacts.values())], rel=1e-9)
    assert plan.choice.bound == -np.inf


def test_what_an_arm_could_give_is_told_beside_the_plan(postures, tmp_path):
    """Only when it is asked for; where the farthest wrench is stopped by a joint, that joint bears its limit."""
    held, model = arms(postures), pinocchio.buildModelFromUrdf(str(tmp_path / "arm.urdf"))
    planner = WrenchPlanner(CART, held)
    planner.warm_up()
    for index in range(3):
        plan = planner.plan_or_hold((-40.0, 0.0, 0.0), place_of(held, index))
        assert "polytopes" not in vars(plan)
        at = postures["left"].posture(held[0].contacts.points[index])
        for direction in np.vstack([np.eye(6), -np.eye(6)])[[0, 1, 2, 6, 7, 8]]:
            farthest = plan.polytopes["left"].support(direction)
            torques = rnea(model, at.configuration, farthest.wrench)
            assert np.abs(torques).max() <= TORQUE + 1e-6
            for name in farthest.limits:
                if name.startswith("joint"):
                    assert abs(torques[int(name.split()[1][1:])]) == pytest.approx(TORQUE, abs=1e-6)
        assert "joint j1 torque lower" in repr(plan.polytopes["left"])
