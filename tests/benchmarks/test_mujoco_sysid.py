"""MuJoCo's `sysid` as a peer: its model answers to every parameter; where wrenches are exact it finds what is there."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid

from benchmarks.sealed.baselines import regress
from benchmarks.sealed.mujoco_sysid import GEARS, SETTERS, description, set_gain
from benchmarks.sealed.recorded import Recorded
from benchmarks.sealed.sysid_report import rolled_out as reported
from benchmarks.sysid_peer import installed, rolled_out
from cartgrasp.effects import RollingResistance, ViscousDrag
from cartgrasp.inertia import Inertia, physical_from_phi
from cartgrasp.model import CartModel
from cartgrasp.studies.consistency import drawn_cart
from cartgrasp.studies.estimators import SENSOR_SETS, Job, drive_cart, guess

from .test_sealed_baselines import made_up

needs_sysid = pytest.mark.skipif(not installed(), reason="mujoco.sysid needs the extra `bench`")
BASE = {"mass": 20.0, "com_x": 0.3, "com_y": 0.05, "inertia": 2.0, "linear": 2.0, "angular": 1.0, "rolling": 4.0}
BASE |= {"imbalance": 0.5, "turning": 0.5, "grade_x": 0.0, "grade_y": 0.0, "toe": 0.0, "slip": 1e-3}
BASE |= {"pull": 0.0, "twist": 0.0}
PUSH = {"fx": 20.0, "fy": 5.0, "tau": 2.0}


def moved(values, gain=1.0):
    """Pose and velocity after half a second from 0.3 m/s and 0.2 rad/s."""
    spec = mujoco.MjSpec.from_string(description(["arm"]))
    for name, value in values.items():
        SETTERS[name](spec, value)
    set_gain(spec, "arm", gain)
    model = spec.compile()
    data = mujoco.MjData(model)
    data.qvel[:] = 0.3, 0.0, 0.2
    data.ctrl[: len(GEARS)] = list(PUSH.values())
    mujoco.mj_step(model, data, 50)
    return np.concatenate([data.qpos, data.qvel])


@pytest.mark.parametrize("name", BASE)
def test_the_smallest_step_of_a_parameter_tells_as_much_as_a_larger_one(name):
    """MuJoCo's compiler must not round it away."""
    small, large = (moved(BASE | {name: BASE[name] + step}) - moved(BASE) for step in (1.5e-8, 1e-5))
    assert np.abs(large).max() > 1e-9
    assert small / 1.5e-8 == pytest.approx(large / 1e-5, rel=0.02, abs=0.02 * np.abs(large / 1e-5).max())


def test_a_step_is_that_of_the_library_s_model():
    body = Inertia(BASE["mass"], (BASE["com_x"], BASE["com_y"]), BASE["inertia"])
    cart = CartModel(
        body, guess().constraints, (ViscousDrag(linear=2.0, angular=1.0), RollingResistance(coefficient=0.0))
    )
    state, wrench = np.array([0.0, 0.0, 0.0, 0.3, 0.2]), np.array(list(PUSH.values()))
    for _ in range(5000):
        state = state + 1e-4 * cart.rate(state, wrench, cart.parameters).value
    c, s = np.cos(state[2]), np.sin(state[2])
    wanted = [*state[:3], c * state[3], s * state[3], state[4]]
    found = moved(BASE | {"rolling": 0.0, "imbalance": 0.0, "turning": 0.0, "slip": 0.0})
    assert found == pytest.approx(wanted, abs=0.004)


@needs_sysid
def test_right_where_wrenches_are_nearly_exact(monkeypatch):
    monkeypatch.setitem(SENSOR_SETS, "exact", replace(SENSOR_SETS["quiet"], force=0.02, moment=0.001))
    cart = drawn_cart(1)
    phi = rolled_out(drive_cart(cart, Job("curves", "exact", 1)).log, guess())
    mass, x, y, inertia = physical_from_phi(phi.mean)
    assert [mass, inertia] == pytest.approx([cart.inertia.mass, cart.inertia.about_com], rel=0.03)
    assert [x, y] == pytest.approx(cart.inertia.com, abs=0.01)
    assert (np.linalg.eigvalsh(phi.covariance) > 0).all()


@needs_sysid
def test_a_slope_is_named_in_a_report_like_the_others():
    log, cart, grade = made_up(1)
    log = Recorded(
        **{
            k: v[:120] if isinstance(v, np.ndarray) else {a: w[:120] for a, w in v.items()}
            for k, v in vars(log).items()
        }
    )
    place = {"x": np.cos(log.heading), "y": np.sin(log.heading)}
    driven = replace(log, **{k: cumulative_trapezoid(log.u * v, log.time, initial=0) for k, v in place.items()})
    report, other = reported(driven, cart, 0.02), regress(driven, cart)
    assert report["effects"][0]["name"] == "floor_slope"
    found = report["effects"][0]["parameters"]
    assert [found[k]["value"] for k in ("grade_x", "grade_y")] == pytest.approx(grade, abs=1e-3)
    assert report.keys() == other.keys()
    assert report["parameter_mismatch"].keys() == other["parameter_mismatch"].keys()
    assert report["effects"][0].keys() == other["effects"][0].keys()
