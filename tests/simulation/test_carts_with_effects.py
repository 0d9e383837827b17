"""Closed loops on carts whose file names effects of the wheels, the load and the sensors, as the command runs them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cartgrasp.cli.simulate import Choice, build_scenario
from cartgrasp.errors import PlantError

CART = """
mass: 24
com: [0.3, 0.05]
inertia: 2.0
constraints:
  - no_lateral_slip: {x: 0.0}
effects:
  viscous_drag: {linear: 3.0, angular: 1.0}
"""
EFFECTS = {
    "wheel_misalignment": "{angle: 0.03}",
    "lateral_slip": "{cornering_stiffness: 2000}",
    "load_slosh": "{mass: 5, frequency: 0.9, damping: 0.08}",
    "time_delay": "{delay: 0.03}",
    "learned_force": """
    spot: {acts_on: forward_force, of: travelled_distance, lever: 0.27, period: 0.525, cos_1: 6, sin_1: 3}
    gusts: {acts_on: world_force, of: time, direction: 1.5, knots: [0, 1, 2, 3], value_1: 0, value_2: 8, value_3: 2}
    patch: {acts_on: drag, of: place, knots: [0.2, 0.6, 1.0], value_1: 0, value_2: 5, value_3: 0}""",
}
ROBOT = {
    "contact_offset": "{x: 0.02, y: -0.04}",
    "tool_inertia": "{mass: 1.5, x: 0.05, y: 0.02, z: -0.03}",
    "pose_offset": "{x: -0.06, y: 0.02, yaw: 0.03}",
}


def scenario(folder, *names, **changes):
    path = folder / "cart.yaml"
    path.write_text(CART + "".join(f"  {name}: {(EFFECTS | ROBOT)[name]}\n" for name in names))
    choice = Choice(path, None, "curves", None, "model", 2, 0.6, 0.0, False, 0)
    return replace(build_scenario(replace(choice, **changes)), duration=4.0)


@pytest.mark.long
@pytest.mark.parametrize("name", EFFECTS)
def test_a_cart_with_each_is_tracked_when_it_is_known(name, tmp_path):
    record = scenario(tmp_path, name).run()
    assert record.pose[-1, 0] > 1.0
    assert record.tracking_error.max() < 0.02
    assert set(record.statuses) == {"optimal"}
    if name == "load_slosh":
        assert record.tracking_error.max() < 0.002  # 5 mm where only what does not swing is fed forward
    if name == "learned_force":
        assert record.tracking_error.max() < 0.001  # 2 cm where they are not fed forward
    if name == "time_delay":
        for arm, given in record.wrenches.items():
            np.testing.assert_allclose(record.log.arms[arm].wrench[3:], given[:-3], atol=1e-12)
    if name == "wheel_misalignment":
        along = np.diff(record.pose[-50:, :2], axis=0)
        heading = (record.pose[-50:-1, 2] + record.pose[-49:, 2]) / 2
        np.testing.assert_allclose(np.arctan2(along[:, 1], along[:, 0]) - heading, 0.03, atol=1e-4)


@pytest.mark.long
@pytest.mark.parametrize("plant", ["model", "mujoco"])
def test_a_robot_with_all_that_is_known_of_it_is_tracked(plant, tmp_path):
    """Poses are of the tracked point, and what its sensors weigh of the tool is there."""
    known = scenario(tmp_path, *ROBOT, plant=plant)
    record = known.run()
    assert record.pose[-1, 0] > 1.0
    assert record.tracking_error.max() < 0.03
    assert set(record.statuses) == {"optimal"}
    heading = record.log.pose[:, 2]
    np.testing.assert_allclose(heading, record.pose[:, 2] - 0.03, atol=0.003)  # of noise
    c, s = np.cos(heading), np.sin(heading)
    there = record.log.pose[:, :2] + np.column_stack([-0.06 * c - 0.02 * s, -0.06 * s + 0.02 * c])
    np.testing.assert_allclose(there, record.pose[:, :2], atol=0.003)
    for arm, given in record.wrenches.items():
        np.testing.assert_allclose(record.log.arms[arm].wrench[:, 2] - given[:, 2], 1.5 * 9.81, atol=1e-9)


@pytest.mark.parametrize("name", ["wheel_misalignment", "lateral_slip", "load_slosh"])
def test_mujoco_refuses_by_name_what_it_has_no_counterpart_of(name, tmp_path):
    with pytest.raises(PlantError, match=f"MuJoCo plant: {name}: no counterpart in MuJoCo"):
        scenario(tmp_path, name, plant="mujoco").build()
