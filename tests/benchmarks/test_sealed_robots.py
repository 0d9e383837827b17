"""The sealed generator's robots, in complex numbers, beside the library's effects, in vectors."""

from __future__ import annotations

import numpy as np
import pytest

import cartgrasp as cg
from benchmarks.sealed.cases import CASES, ROBOT_CASES, draw_case, objection
from benchmarks.sealed.generate import generate, simulate
from benchmarks.sealed.robots import hanging
from benchmarks.sealed.weaker import weaker
from benchmarks.sealed.world import R, U, W
from cartgrasp.effects import KNOWN_EFFECTS, PoseOffset
from cartgrasp.effects.effect import HandMotion
from cartgrasp.logs import RunLog
from cartgrasp.logs.alignment import at_body


def test_they_are_a_group_beside_the_others():
    assert not set(ROBOT_CASES) & set(CASES)
    assert not any(objection(case) for case in ROBOT_CASES)
    assert objection("tool_inertia@coasting")


@pytest.mark.parametrize("seed", range(3))
def test_a_tool_hangs_as_the_library_says(seed):
    scene = draw_case("tool_inertia", seed, "rich")
    states, rates, *_ = scene.run()
    ((arm, values),) = scene.sensors.tools.items()
    columns = [U, W, R]
    hand = HandMotion.of(states[:, columns], rates[:, columns], scene.drive.contacts[:, arm])
    effect = KNOWN_EFFECTS["tool_inertia"](*values)
    expected = effect.recorded(np.zeros(6), effect.values, hand)
    np.testing.assert_allclose(hanging(scene.sensors, scene.drive, states, rates)[:, arm], expected, atol=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_poses_are_of_the_tracked_point(seed):
    """Brought back by the library, they and the velocities are those of the cart, to within their noise."""
    scene = draw_case("pose_offset", seed, "rich")
    states, *_ = scene.run()
    header, table, _ = simulate(scene, np.random.default_rng(seed))
    names = ["x", "y", "theta", "vx", "vy", "omega"][: 3 if scene.sensors.speed_noise is None else 6]
    columns = table[:, [header.index(name) for name in names]]
    log = RunLog(table[:, 0], columns[:, :3], columns[:, 3:] if len(names) > 3 else None, {})
    cart = cg.CartModel(cg.Inertia(20.0, (0.3, 0.0), 2.0), effects=(PoseOffset(**scene.truths[0].parameters),))
    back = at_body(log, cart)
    np.testing.assert_allclose(back.pose, states[:, :3], atol=6 * scene.sensors.pose_noise)
    if back.velocity is not None:
        u, w, r = states[:, [U, W, R]].T
        along = np.exp(1j * states[:, 2]) * (u + 1j * w)
        expected = np.column_stack([along.real, along.imag, r])
        np.testing.assert_allclose(back.velocity, expected, atol=6 * scene.sensors.speed_noise)


def test_a_hand_is_where_it_is_and_the_log_is_wrong():
    scene = draw_case("contact_offset@two_arms", 0, "rich")
    header, table, _ = simulate(scene, np.random.default_rng(0))
    (truth,) = scene.truths
    for arm, name in enumerate(scene.arms):
        recorded = table[:, [header.index(f"{name}.{axis}") for axis in ("px", "py", "pz")]]
        away = [truth.parameters["x"], truth.parameters["y"], 0.0] if name == truth.arm else np.zeros(3)
        np.testing.assert_allclose(scene.drive.contacts[:, arm] - recorded, np.tile(away, (len(table), 1)), atol=1e-12)


@pytest.mark.parametrize("case", ROBOT_CASES)
def test_weaker_ones_are_as_their_truth_says(case):
    scene = weaker(draw_case(case, 1, "rich"), 0.5)
    (truth,), sensors = scene.truths, scene.sensors
    if truth.name == "pose_offset":
        ahead, left, turn = sensors.tracked
        body = -complex(ahead, left) * np.exp(-1j * turn)
        np.testing.assert_allclose(list(truth.parameters.values()), [body.real, body.imag, -turn], atol=1e-12)
    elif truth.name == "tool_inertia":
        assert truth.parameters["mass"] == pytest.approx(next(iter(sensors.tools.values()))[0])
    else:
        np.testing.assert_allclose(list(truth.parameters.values()), next(iter(sensors.beside.values()))[:2])


def test_files_are_written_as_for_any_case(tmp_path):
    (name,) = generate(tmp_path, ["contact_offset"], [0], "straight")
    assert cg.read_log(tmp_path / "logs" / name / "run.csv").arms
    assert cg.load_cart(tmp_path / "logs" / name / "cart.yaml").inertia.mass > 0
