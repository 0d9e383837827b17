"""What a newcomer may type: each mistake is told in one sentence of ours with the cure, where the value is born."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

import cartgrasp as cg
from cartgrasp.effects import ForceBias, RollingResistance, ViscousDrag
from cartgrasp.errors import CartgraspError
from cartgrasp.first_guess import FirstGuess
from cartgrasp.logs import ArmLog
from cartgrasp.simulation import ModelPlant, SensorNoise, Sensors
from estimation import CartFilter, FilterNoise, Prior, RegressorEstimator, diagnose, identify
from planning import (
    InternalForce,
    Lexicographic,
    LoadShare,
    SearchLimit,
    Skid,
    Smoothness,
    TipOver,
    WrenchPlanner,
    build_allocation,
)
from planning.references import PathReference, Stretch, chain, pause, speed_change, straight, turn
from planning.tracking import Gains

from .cli.commands import CART, PROBLEM, run

POINT = (-0.25, 0.2, 1.0)
BODY = cg.Inertia(24.0, (0.3, 0.0), 2.0)
TRUE = cg.CartModel(BODY, effects=(RollingResistance(0.02),))
LEFT = cg.Arm("left", [POINT], force_limit=(60, 60, 40))
RIGHT = cg.Arm("right", [(-0.25, -0.2, 1.0)], force_limit=(60, 60, 40))
SHORT = cg.Measurement(0.0, None, None, {"left": (1, 2)}, {"left": POINT})
HAND = ArmLog(np.zeros((3, 3)), np.zeros((3, 6)))
NOTHING = cg.ContactWrenches({}, {})
LOG = cg.RunLog(np.arange(3) / 100, np.zeros((3, 3)), None, {"left": HAND})


def log(**more):
    return replace(LOG, **more)


def arm(**more):
    return cg.Arm("left", [POINT], **more)


def planner(**more):
    return WrenchPlanner(TRUE, [LEFT, RIGHT], **more)


PYTHON = [
    (lambda: cg.Friction("0.6"), "friction: mu: '0.6' is not a number"),
    (lambda: cg.Friction(60.0, sides="4"), "sides: '4' is neither a whole number"),
    (lambda: cg.Friction(-0.6), "mu: -0.6 is not a number from 0"),
    (lambda: arm(friction=0.6), r"arm left: friction: 0.6 is no Friction; write friction=Friction\(mu=0.6\)"),
    (lambda: arm(force_limit=60), r"arm left: force_limit: 60 is not \(fx, fy, fz\)"),
    (lambda: arm(force_limit=(60, 60)), "3 numbers are needed, 2 given"),
    (lambda: arm(force_limit=("60", "60", "40")), r"force_limit: .* is not \(fx, fy, fz\)"),
    (lambda: arm(moment_limit=(8, 8, -6)), "moment_limit: .* -6 is not a number >= 0"),
    (lambda: arm(weights=(1, 1, 1)), "weights: .* 6 numbers are needed, 3 given"),
    (lambda: arm(yaw=90), "yaw: 90 rad .* 90 degrees are 1.571 rad"),
    (lambda: arm(yaw="0.5"), "yaw: '0.5' is not a number"),
    (lambda: arm(payload="5 kg"), "payload: .*5 kg"),
    (lambda: arm(push_only="no"), "push_only: 'no' is no bool; write True or False"),
    (lambda: arm(joints=np.eye(6)), "joints: .* is no JointTorques; write"),
    (lambda: arm(reach=(0, 1)), r"reach: \(0, 1\) is no Reach; write Reach.box\(low, high\)"),
    (lambda: arm(segment=[POINT]), "segment: 2 ends are needed, 1 given"),
    (lambda: cg.Arm("left", POINT), r"is one point; a list of points is needed: \[\(x, y, z\)\]"),
    (lambda: cg.Arm("left", "handle"), r"contacts: 'handle' is no list of points; write"),
    (lambda: cg.Arm("left", [(-250, 200, 1000)]), r"\(x, y, z\) in \{b\}, m: -250 is not a number from -50 to 50"),
    (lambda: cg.Arm("left", [(0, 0, 100)]), "100 is not a number from -50 to 50"),
    (lambda: cg.Arm([POINT]), "arm: name .* must be a word"),
    (lambda: cg.Arm("left"), "contacts: none given; an arm needs a point or a segment"),
    (lambda: cg.ContactSet(segments=(POINT, POINT)), r"segments: .* is no Segment; write \[Segment\(start, stop\)\]"),
    (lambda: cg.ContactWrenches({"left": (1, 2, 3)}, {"left": POINT}), r"wrenches: left: shape \(3,\) instead of 6"),
    (lambda: cg.ContactWrenches({"left": np.zeros(6)}, {"left": (0, 0)}), r"contacts: left: shape \(2,\) instead of 3"),
    (lambda: cg.ContactWrenches(np.zeros(6), POINT), r"wrenches: .* write \{arm: numbers\}"),
    (lambda: cg.RollingConstraints(()), r"constraints: axle_x: \(\) is not a number"),
    (lambda: cg.RollingConstraints("0"), "axle_x: '0' is not a number .*; give its x in {b}, m, or None"),
    (lambda: cg.RollingConstraints(0.0, "yes"), "no_rotation: 'yes' is no bool"),
    (lambda: cg.RollingConstraints(None, True), "no_rotation needs no_lateral_slip beside it"),
    (lambda: cg.Inertia(24, (0, 0, 0), 1), r"com: \(0, 0, 0\) is not \(x, y\) in \{b\}, m; 2 numbers are needed"),
    (lambda: cg.Inertia(24, 0.3, 1), r"com: 0.3 is not \(x, y\)"),
    (lambda: cg.Inertia(24, (300, 0), 1), "300 is not a number from -50 to 50"),
    (lambda: cg.Inertia("24", (0, 0), 1), "mass: '24' is not a number; give kg"),
    (lambda: cg.Inertia(-24, (0, 0), 1), "mass: -24 kg is not positive"),
    (lambda: cg.Wheel("castor", 0, 0), "'castor' is neither 'fixed' nor 'caster'"),
    (lambda: cg.Wheel("fixed", 720, 200), "wheels: x: 720 is not a number from -50 to 50; give m"),
    (lambda: cg.Wheel("fixed", (0, 1), 2), r"wheels: x: \(0, 1\) is not a number"),
    (lambda: cg.CartModel(24.0), r"cart: inertia: 24.0 is no Inertia; write Inertia\("),
    (lambda: cg.CartModel(BODY, 0.0), r"cart: constraints: 0.0 is no RollingConstraints; write"),
    (lambda: cg.CartModel(BODY, effects=RollingResistance()), "cart: effects: .* is no list; write"),
    (lambda: cg.CartModel(BODY, wheels=("fixed",)), "cart: wheels: 'fixed' is no Wheel; write"),
    (lambda: cg.CartModel(BODY, com_height="0.4"), "com_height: '0.4' is not a number"),
    (lambda: TRUE.with_effect("viscous_drag"), "effects: 'viscous_drag' is no Effect; write .* known are"),
    (lambda: TRUE.with_effect(RollingResistance()), "rolling_resistance stands twice; give each its own label"),
    (lambda: TRUE.without_effect("rolling"), "this cart has no rolling; it has rolling_resistance"),
    (lambda: TRUE.with_parameters((24.0, 0.3)), r"parameters \(2,\) are not the 5 of this cart"),
    (lambda: TRUE.state(velocity=(0.5, 0.0, 0.0)), r"velocity has shape \(3,\), but this cart's 2 numbers"),
    (lambda: RollingResistance("0.02"), "rolling_resistance.coefficient: '0.02' is not a number"),
    (lambda: ViscousDrag(None), "viscous_drag.linear: None is not a number"),
    (lambda: ForceBias(fx=np.nan), "force_bias.fx: nan is not a finite number"),
    (lambda: cg.load_cart("nowhere.yaml"), "nowhere.yaml: can't be read: No such file"),
    (lambda: cg.read_log("nowhere.csv"), "nowhere.csv"),
    (lambda: WrenchPlanner("bed.yaml", [LEFT]), r"cart: 'bed.yaml' is no CartModel; load it first: load_cart\("),
    (lambda: WrenchPlanner(TRUE, LEFT), r"arms: Arm\('left'.* is no list; write \[Arm\("),
    (lambda: WrenchPlanner(TRUE, ["left"]), r"arms: 'left' is no Arm; write"),
    (lambda: WrenchPlanner(TRUE, []), "arms: none given"),
    (lambda: WrenchPlanner(TRUE, [LEFT, LEFT]), "left stands twice; names must differ"),
    (lambda: planner(objective="smoothness"), "objective: 'smoothness' is no Objective; write"),
    (lambda: planner(cart_limits=Skid(0.5)), r"cart_limits: .* is no list; write cart_limits=\[Skid\(0.5\)\]"),
    (lambda: planner(cart_limits=["skid"]), "cart_limits: 'skid' is no CartLimit"),
    (lambda: planner(confidence=95), "confidence: 95 is not a probability"),
    (lambda: planner(confidence="95 %"), "confidence: '95 %' is not a number"),
    (lambda: planner(min_hand_distance="0.1"), "min_hand_distance: '0.1' is not a finite number >= 0; give m"),
    (lambda: planner(period=0), "period: 0 is not > 0; give s"),
    (lambda: planner(period=10), "period: 10 is not a number from 0 to 0.5; give s"),
    (lambda: planner(relax="any"), "relax: 'any' is not a number >= 0"),
    (lambda: planner(search_limit=100), r"search_limit: 100 is no SearchLimit; write SearchLimit\("),
    (lambda: planner(switching_cost="high"), "switching_cost: 'high' is not a number from 0"),
    (lambda: planner(switching_cost={"lefft": 3.0}), "switching_cost: there is no 'lefft'; did you mean left?"),
    (lambda: planner().start_from({"left": (1, 2, 3)}), r"start_from: .* are not wrenches \(6,\)"),
    (lambda: planner(objective=LoadShare({"lefft": 1.0})), "lefft"),
    (lambda: Skid("0.5"), "skid: friction: '0.5' is not a finite number"),
    (lambda: TipOver("50"), "tip-over: least_load: '50' is not a finite number >= 0; give N"),
    (lambda: InternalForce("10"), "internal force: bound: '10' is not a finite number >= 0; give N"),
    (lambda: Smoothness("0.1"), "smoothness: rate: '0.1' is not a finite number"),
    (lambda: SearchLimit(solves="many"), "search_limit: solves: 'many' is not a finite number"),
    (lambda: CartFilter("bed.yaml"), "filter: cart: 'bed.yaml' is no CartModel; load it first"),
    (lambda: CartFilter(TRUE, [LEFT]), r"filter: arms: Arm\('left'.* is no str; write their names"),
    (lambda: CartFilter(TRUE, "left"), "filter: arms: 'left' is no list; write their names"),
    (lambda: CartFilter(TRUE, noise=3.0), r"filter: noise: 3.0 is no FilterNoise; write FilterNoise\(force=3.0\)"),
    (lambda: CartFilter(TRUE, prior=0.4), r"filter: prior: 0.4 is no Prior; write Prior\("),
    (lambda: CartFilter(TRUE, yaws={"left": 90}), "yaws: left: 90 rad .* 90 degrees are 1.571 rad"),
    (lambda: CartFilter(TRUE, prior=Prior(known={"masss"})), "there is no 'masss'; did you mean mass?"),
    (lambda: CartFilter(TRUE).update((0.0, 0.0)), r"filter: measurement: .* is no Measurement; write Measurement\("),
    (lambda: CartFilter(TRUE).update(cg.Measurement("0")), "measurement: time: '0' is not a number; give s"),
    (lambda: CartFilter(TRUE).update(cg.Measurement(0.0, (1, 2))), r"measurement: pose: \(1, 2\) is not 3 numbers"),
    (lambda: CartFilter(TRUE).update(SHORT), r"measurement: wrenches: left: \(1, 2\) is not 6 numbers"),
    (lambda: log(time="0.01"), "run: time: '0.01' is no array of numbers; give t of each row"),
    (lambda: log(time=[0.0, "a", 0.02]), "time: .* is no array of numbers"),
    (lambda: log(time=np.zeros((3, 1))), r"time: shape \(3, 1\) instead of \(n,\): t of each row"),
    (lambda: log(time=[0.0, 0.02, 0.01]), "time: 0.01 s in row 2 after 0.02 s: times must be finite and increase"),
    (lambda: log(time=[0.0, 0.01, 0.01]), "0.01 s in row 2 after 0.01 s: .*; leave such rows out, or mend their clock"),
    (lambda: log(time=[0.0, np.nan, 0.02]), "time: nan s in row 1"),
    (lambda: log(time=[]), "run: the log has no rows"),
    (lambda: log(pose=np.zeros((2, 3))), r"run: pose: shape \(2, 3\) instead of \(3, 3\): x, y, theta of each row"),
    (lambda: log(pose=np.zeros((3, 2))), r"pose: shape \(3, 2\) instead of \(3, 3\): x, y, theta of each row"),
    (lambda: log(pose=None), "pose: None is no array of numbers; give x, y, theta of each row, NaN where missing"),
    (lambda: log(pose=np.zeros((3, 3), dtype=object)), "pose: an array of object is no array of numbers"),
    (lambda: log(velocity=np.zeros(3)), r"velocity: shape \(3,\) instead of \(3, 3\): .*; one for all rows is np.tile"),
    (lambda: log(velocity="fast"), "velocity: 'fast' is no array of numbers; give vx, vy, omega of each row"),
    (lambda: log(arms=HAND), "run: arms: ArmLog.* is no Mapping; write {"),
    (lambda: log(arms={"left": POINT}), r"arms: left: \(-0.25, 0.2, 1.0\) is no ArmLog; write {"),
    (lambda: log(arms={"left.hand": HAND}), "arms: 'left.hand' is no name of an arm; give a word without a dot"),
    (lambda: log(arms={"": HAND}), "arms: '' is no name of an arm"),
    (lambda: log(arms={"left": ArmLog(np.zeros((2, 3)), np.zeros((2, 6)))}), "left: 2 rows, but the log has 3; give"),
    (lambda: log(name=3), 'log: name: 3 is no str; say where it is from, name="run.csv"'),
    (
        lambda: ArmLog(POINT, np.zeros((3, 6))),
        r"arm: contact: shape \(3,\) instead of \(n, 3\): px, py, pz of each row; one",
    ),
    (
        lambda: ArmLog(np.zeros((3, 3)), np.zeros((3, 3))),
        r"arm: wrench: shape \(3, 3\) instead of \(3, 6\): fx, fy, fz, tx",
    ),
    (lambda: ArmLog(np.zeros((3, 3)), np.zeros((2, 6))), r"arm: wrench: shape \(2, 6\) instead of \(3, 6\)"),
    (lambda: ArmLog([[0, 0], [0, 0, 1]], np.zeros((2, 6))), "arm: contact: .* is no array of numbers"),
    (lambda: TRUE.with_inertia(24.0), "cart: inertia: 24.0 is no Inertia; write"),
    (lambda: cg.CartModel(BODY, name=3), "cart: name: 3 is no str; write"),
    (lambda: cg.load_cart(None), "file: None is no str; name it by its path"),
    (lambda: cg.Reach.box(0, 1), r"reach: 0 is not \(x, y, z\) in \{b\}, m"),
    (lambda: cg.Segment(1, 2), r"segment: .* is one point; a list of points"),
    (lambda: LoadShare(0.5), "load share: shares: 0.5 is no Mapping; write {'left': 0.7, 'right': 0.3}"),
    (lambda: LoadShare({"left": "most"}), "load share: left: 'most' is not a number from 0 to 1"),
    (lambda: Lexicographic(1, 2), r"lexicographic: 1 is no Objective; write"),
    (lambda: InternalForce(3.0, "up"), r"internal force: axis: 'up' is not \(x, y, z\)"),
    (lambda: build_allocation("cart.yaml", [LEFT], {"left": POINT}, (40, 0, 3)), "cart: 'cart.yaml' is no CartModel"),
    (lambda: CartFilter(TRUE).estimate, "no measurement has come yet"),
    (lambda: RegressorEstimator(TRUE, "left"), "filter: arms: 'left' is no list"),
    (lambda: FilterNoise(force="3"), "noise: force: '3' is not a finite number"),
    (lambda: FilterNoise(force=-3), "noise: force: -3 is not a finite number"),
    (lambda: Prior(known="mass"), "prior: known: 'mass' is no list; write"),
    (lambda: Prior(mass=-0.4), "prior: mass: -0.4 is not a number from 0"),
    (lambda: Prior(com=0.0), "prior: com: 0 is not > 0; .*what is sure stands under `known`"),
    (lambda: Prior(std={"mass": 0}), "prior: std of mass: 0 is not > 0; .*what is sure stands under `known`"),
    (lambda: FirstGuess(std=(("mass", -2.0),)), "first guess: std of mass: -2.0 is not a number from 0"),
    (lambda: FirstGuess(std=("mass", 2.0)), "first guess: std: 'mass' is no name with its deviation; write std="),
    (lambda: FirstGuess(std=(("mass",),)), "first guess: std: .* is no name with its deviation; write std="),
    (lambda: FirstGuess(known="mass"), "first guess: known: 'mass' is no list; write known="),
    (lambda: Prior(std={"mass": "2"}), "prior: std of mass: '2' is not a number"),
    (lambda: identify(LOG, TRUE), r"identify: logs: RunLog\('run', 3 rows.* is no list; write \[read_log"),
    (lambda: identify([LOG], "cart.yaml"), "identify: cart: 'cart.yaml' is no CartModel; load it first"),
    (lambda: identify([], TRUE), "identify: no log is given; at least one is needed"),
    (lambda: diagnose("run.csv", TRUE), r"diagnose: logs: 'run.csv' is no list; write \[read_log"),
    (lambda: diagnose(LOG, "cart.yaml"), "diagnose: cart: 'cart.yaml' is no CartModel; load it first"),
    (lambda: diagnose(LOG, TRUE, candidates=["viscous_drag"]), "candidates: 'viscous_drag' is no Effect; write"),
    (lambda: turn(60, 0.4), "turn: angle: 60 rad is more than two turns.* 60 degrees are 1.047 rad"),
    (lambda: turn(1.0, 0.0), "turn: speed: 0 is not > 0; give rad/s"),
    (lambda: straight("3 m", 0.5), "straight: distance: '3 m' is not a number .*; give m"),
    (lambda: straight(3.0, -0.5), "straight: speed: -0.5 is not a number from 0"),
    (lambda: speed_change(0.5, 0), "speed_change: acceleration: 0 is not > 0; give m/s²"),
    (lambda: pause(-1), "stretch: duration: -1 is not a number from 0"),
    (lambda: Stretch("1"), "stretch: duration: '1' is not a number"),
    (lambda: PathReference(Stretch(1.0)), "reference: stretches: .* is no list; write chain"),
    (lambda: PathReference([straight(1.0, 0.5)]), "stretches: .* is no Stretch; write chain"),
    (lambda: PathReference(chain(pause(1.0)), start_pose=(0, 0, 90)), "theta: 90 rad .* 90 degrees are 1.571 rad"),
    (lambda: PathReference(chain(pause(1.0)), start_pose=(0, 0)), r"\(x, y, theta\) .*; 3 numbers are needed"),
    (lambda: PathReference(chain(pause(1.0)), TRUE), "reference: constraints: .* is no RollingConstraints; give"),
    (lambda: Gains(along="1"), "gains: along: '1' is not a number"),
    (lambda: ModelPlant("cart.yaml"), "plant: cart: 'cart.yaml' is no CartModel; load it first"),
    (lambda: ModelPlant(TRUE, (0, 0, 90)), "plant: pose_sb: theta: 90 rad"),
    (lambda: ModelPlant(TRUE, timestep=0), "plant: timestep: 0 is not > 0; give s"),
    (
        lambda: ModelPlant(TRUE).step({"left": np.zeros(6)}, 0.01),
        "plant: step: {.* is no ContactWrenches; give plan.contact_wrenches",
    ),
    (lambda: ModelPlant(TRUE).step(NOTHING, -0.01), "plant: step: duration: -0.01 is not a number >= 0; give s"),
    (lambda: Sensors(TRUE, 0.1), "sensors: noise: 0.1 is no SensorNoise; write SensorNoise"),
    (lambda: Sensors("cart.yaml", SensorNoise()), "sensors: cart: 'cart.yaml' is no CartModel; load it first"),
    (lambda: Sensors(TRUE, SensorNoise(), seed="1"), "sensors: seed: '1' is no int; give a whole number"),
    (lambda: SensorNoise(force=-1), "sensor noise: force: -1 is not a number >= 0"),
    (lambda: PathReference(chain(straight(1.0, 0.5))).at(np.nan), "reference: time: nan is not a number; give s"),
    (lambda: PathReference(chain(straight(1.0, 0.5))).at("1"), "reference: time: '1' is not a number; give s"),
    (lambda: cg.read_log(None), "log: None is no str; name it by its path"),
    (lambda: cg.read_log(["run.csv"]), r"log: \['run.csv'\] is no str; name it by its path, one at a time"),
    (lambda: cg.Inertia(24, {0.3, 0.0}, 2), r"com: {.*} is not \(x, y\) in \{b\}, m"),
    (lambda: cg.Inertia(24, (v for v in (0.3, 0.0)), 2), r"com: .* is not \(x, y\)"),
    (lambda: CartFilter(TRUE, ["left"], yaws={"lefft": 0.1}), "yaws: there is no 'lefft'; did you mean left?"),
]


@pytest.mark.parametrize(("call", "words"), PYTHON, ids=[words for _, words in PYTHON])
def test_a_mistake_in_python(call, words):
    with pytest.raises(CartgraspError, match=words) as found:
        call()
    assert "\n" not in str(found.value)
    assert "object at 0x" not in str(found.value)


REFUSED = [
    ({"wrench": (40.0, 0.0)}, "wrench: shape (2,) instead of three numbers (fx, fy, tau)"),
    ({"wrench": "40"}, "wrench: '40' is not three numbers"),
    ({"contacts": {"lefft": POINT}}, "contacts: there is no arm 'lefft'; there are left, right"),
    ({"contacts": {"left": (0, 0, 100)}}, "(x, y, z) in {b} is needed"),
    ({"contacts": [POINT]}, "contacts: a mapping from arm to (x, y, z) is needed"),
    ({"arms": []}, "arms: none given; name those that hold"),
    ({"arms": ["left"]}, "arms: 'left' is not an Arm; give those made"),
    ({"arms": "left"}, "arms: 'left' is not an Arm"),
    ({"arms": [cg.Arm("middle", [POINT])]}, "arms: there is no arm 'middle'; there are left, right"),
    ({"estimate": TRUE}, "estimate: its time, motion or parameters are not those of an Estimate"),
]


@pytest.mark.parametrize(("asked", "words"), REFUSED, ids=[words for _, words in REFUSED])
def test_a_mistake_at_a_tick_is_told_by_the_plan(asked, words):
    plan = planner().plan_or_hold(**{"wrench": (40.0, 0.0, 3.0), **asked})
    assert plan.status == "invalid_input"
    assert words in plan.message


FILES = [
    ("plan", "wrench: [40.0, 0.0, 3.0]", "wrench: [40.0, 0.0]", "2 given, but at least 3 are needed"),
    ("plan", "wrench: [40.0, 0.0, 3.0]", "wrench: 40", "40 is not a list"),
    ("plan", "mu: 0.6", "mu: rough", "'rough' is not a number"),
    ("plan", "mu: 0.6", "my: 0.6", "unknown key; known are mu, sides"),
    ("plan", "sides: 4", "sides: 2", "2 is neither a whole number of 3 to 256 nor `exact`"),
    ("plan", "yaw: 0.0", "yaw: 90", "90 rad is more than two turns"),
    ("plan", "[-0.25, 0.20, 1.0]", "[-250, 200, 1000]", "-250 is not a number from -50 to 50"),
    ("plan", "[-0.25, 0.20, 1.0]", "[-0.25, 0.20]", "2 given, but at least 3 are needed"),
    ("plan", "force: [60, 60, 40]", "force: [60, 60, 40, 1]", "4 given, but at most 3 are allowed"),
    ("plan", "force: [60, 60, 40]", "force: [60, 60, -40]", "-40 is negative; a number >= 0 is needed"),
    ("plan", "weights: [1, 1, 1, 10, 10, 10]", "weights: [1]", "1 given, but at least 6 are needed"),
    ("plan", "name: right", "name: left", "left stands twice; names must differ"),
    ("plan", "cart: cart.yaml", "cart: bed.yaml", "bed.yaml: can't be read: No such file"),
    ("plan", "cart: cart.yaml\n", "", "cart: is missing; add it"),
    ("plan", "wrench: [40.0, 0.0, 3.0]", "\twrench: [40.0, 0.0, 3.0]", "not valid YAML: a tab; indent with blanks"),
    ("plan", "wrench: [40.0, 0.0, 3.0]", "wrench: [40.0 0.0", "a bracket that is not closed"),
    ("plan", "cart: cart.yaml", "cart: my: cart.yaml", "a colon where none may stand; indent"),
    ("plan", "cart: cart.yaml", "cart: @cart.yaml", "text that begins so must stand in quotes"),
    ("plan", "cart: cart.yaml", " cart: cart.yaml", "not valid YAML"),
    ("plan", "mu: 0.6", "MU: 0.6", "unknown key; did you mean mu?"),
    ("cart", "mass: 24.0 ", "mass: heavy ", "'heavy' is not a number"),
    ("cart", "mass: 24.0 ", "mas: 24.0 ", "unknown key; did you mean mass?"),
    ("cart", "com: [0.30, 0.00]", "com: [300, 0.00]", "lengths are in m"),
    ("cart", "com: [0.30, 0.00]", "com: [0.30]", "1 given, but at least 2 are needed"),
    ("cart", "{x: 0.0}", "{x: 300}", "300 m is beyond 50 m; lengths are in m"),
    ("cart", "kind: fixed,  x: 0.00", "kind: fixed,  x: 720", "720.0 is not a number from -50 to 50; give m"),
    ("cart", "kind: fixed", "kind: fix", "'fix' is neither fixed nor caster"),
    ("cart", "viscous_drag", "viscous_drg", "unknown effect; did you mean viscous_drag?"),
    ("cart", "linear: 3.0", "liner: 3.0", "unknown parameter; did you mean linear?"),
    ("cart", "linear: 3.0", "linear: much", "viscous_drag.linear: "),
]


@pytest.mark.parametrize(("file", "good", "bad", "words"), FILES, ids=[f"{bad}" for _, _, bad, _ in FILES])
def test_a_mistake_in_a_file(tmp_path, capsys, file, good, bad, words):
    texts = {"cart": CART, "plan": PROBLEM}
    assert good in texts[file]
    texts[file] = texts[file].replace(good, bad, 1)
    (tmp_path / "cart.yaml").write_text(texts["cart"])
    (tmp_path / "problem.yaml").write_text(texts["plan"])
    run(capsys, "plan", tmp_path / "problem.yaml").refused(2, words)


COMMANDS = [
    (["pln", "problem.yaml"], "Did you mean 'plan'?"),
    (["plan"], "PROBLEM"),
    (["plan", "nowhere.yaml"], "nowhere.yaml: can't be read: No such file"),
    (["estimate", "run.csv"], "--cart is missing: name the cart.yaml"),
    (["estimate", "run.csv", "--methd", "filter"], "--methd"),
    (["estimate", "run.csv", "--cart", "nowhere.yaml"], "nowhere.yaml: can't be read"),
    (["identify"], "LOG"),
    (["discrepancy", "run.csv"], "--cart is missing"),
    (["simulate", "--cart", "cart.yaml", "--path", "circle"], "circle"),
    (["simulate", "--cart", "cart.yaml", "--speed", "fast"], "--speed"),
    (["simulate", "--cart", "cart.yaml", "--speed", "-1"], "--speed"),
    (["simulate", "--cart", "cart.yaml", "--arms", "9"], "--arms"),
]


@pytest.mark.parametrize(("arguments", "words"), COMMANDS, ids=[" ".join(a) for a, _ in COMMANDS])
def test_a_mistake_on_the_command_line(tmp_path, capsys, monkeypatch, arguments, words):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "cart.yaml").write_text(CART)
    run(capsys, *arguments).refused(2, words)


# --- what is shown ------------------------------------------------------------------------------------------


def short(value, lines=3):
    words = repr(value)
    assert len(words.splitlines()) <= lines
    assert "0x" not in words
    assert "array(" not in words
    return words


def test_what_a_user_holds_is_shown_in_a_few_words():
    assert "24 kg" in short(TRUE)
    assert "force_limit=(60, 60, 40)" in short(LEFT)
    assert "left, right" in short(planner())
    assert "left: (" in short(planner().plan((40.0, 0.0, 3.0)))
    assert "infeasible" in short(planner().plan((400.0, 0.0, 3.0)))
    fx, fy, tau = planner().plan((30.0, 6.0, 4.0)).cart_wrench
    assert fy < 0  # the axle takes what is asked for sideways, and the plan says what the cart gets
    assert f"on the cart ({fx:.4g}, {fy:.4g}, {tau:.4g})" in short(planner().plan((30.0, 6.0, 4.0)))
    assert "3 rows" in short(LOG)
    assert "pose (0, 0, 0)" in short(ModelPlant(TRUE))
    seen = CartFilter(TRUE, ["left"])
    assert "no measurement yet" in short(seen)
    estimate = seen.update(cg.Measurement(0.0, np.zeros(3), np.zeros(3), {}, {}))
    assert "mass 24 ± 9.6 kg, not taught" in short(estimate)
    assert "mass 24 ± 9.6 kg" in short(seen)


def test_a_log_takes_lists_of_whole_numbers():
    made = cg.RunLog([0, 1], [[0, 0, 0], [1, 0, 0]], None, {"left": ArmLog([[0, 0, 1]] * 2, [[0] * 6] * 2)})
    assert made.table.dtype == float
    assert made.duration == 1.0


# --- the arms of a call -------------------------------------------------------------------------------------


@pytest.mark.parametrize("warm", [False, True])
def test_arms_of_a_call_are_these_arms_alone(warm):
    both, alone = planner(), WrenchPlanner(TRUE, [RIGHT])
    if warm:
        both.warm_up()
    both.plan((20.0, 0.0, 3.0))
    plan = both.plan((20.0, 0.0, 3.0), arms=[RIGHT])
    assert list(plan.wrenches) == ["right"]
    np.testing.assert_allclose(plan.wrenches["right"], alone.plan((20.0, 0.0, 3.0)).wrenches["right"], atol=1e-6)
    assert list(both.plan((20.0, 0.0, 3.0)).wrenches) == ["right"]  # they hold until others are given
    assert both.plan((100.0, 0.0, 0.0)).status == "infeasible"
    assert "there is no arm 'left'" in both.plan((20.0, 0.0, 3.0), contacts={"left": POINT}).message
    again = both.plan((100.0, 0.0, 0.0), arms=[LEFT, RIGHT])
    assert list(again.wrenches) == ["left", "right"]


# --- what the cart and its wheels get -----------------------------------------------------------------------


@pytest.mark.parametrize("warm", [False, True])
def test_the_wheels_take_what_newton_leaves(warm):
    """The lateral force of physics, m (u r + dx r' - dy r²) - fy, with r' from Newton's and Euler's equations solved
    here, at a motion with turn and speed; drag is along the cart."""
    cart = cg.CartModel(cg.Inertia(24.0, (0.3, 0.05), 2.0), effects=(ViscousDrag(3.0, 1.2),))
    made = WrenchPlanner(cart, [LEFT, RIGHT])
    if warm:
        made.warm_up()
    u, r, m, dx, dy = 0.8, 0.5, 24.0, 0.3, 0.05
    motion = cg.Motion(np.array([1.0, 2.0, 0.7]), np.array([u, r]))
    for velocity, estimate in (
        ((0.0, 0.0), None),
        ((u, r), cg.Estimate(0.0, motion, {}, "ok", cart, cart.parameters)),
    ):
        plan = made.plan((30.0, 6.0, 4.0), estimate=estimate)
        fx, fy, tau = plan.cart_wrench
        held = sum(plan.wrenches[arm][1] for arm in plan.wrenches)
        assert fy == pytest.approx(held)  # hands at yaw 0
        assert (fx, tau) == pytest.approx((30.0, 4.0))
        u_now, r_now = velocity
        mass = np.array([[m, -m * dy], [-m * dy, 2.0 + m * (dx**2 + dy**2)]])
        push = np.array([fx - 3.0 * u_now + m * dx * r_now**2, tau - 1.2 * r_now - m * dx * u_now * r_now])
        _, turning = np.linalg.solve(mass, push)
        lateral = m * (u_now * r_now + dx * turning - dy * r_now**2) - fy
        assert plan.wheel_side_force == pytest.approx(lateral, rel=1e-9)
        assert json.loads(json.dumps(plan.as_dict()))["wheel_side_force"] == plan.wheel_side_force
    assert made.plan((4000.0, 0.0, 0.0)).cart_wrench is None
    held = made.plan_or_hold((np.nan, 0.0, 0.0))
    np.testing.assert_allclose(held.cart_wrench, held.contact_wrenches.wrench_b)
    assert np.isfinite(held.wheel_side_force)


def test_casters_take_no_side_force():
    cart = cg.CartModel(BODY, cg.RollingConstraints(None))
    plan = WrenchPlanner(cart, [LEFT, RIGHT]).plan((20.0, 5.0, 1.0))
    assert plan.cart_wrench == pytest.approx((20.0, 5.0, 1.0))
    assert plan.wheel_side_force == pytest.approx(0.0, abs=1e-9)
