"""The bound where motion is measured, held against dense elimination and against what exact sensors give."""

import numpy as np
import pytest

from cartgrasp.effects import RollingResistance, ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.information import fisher_information, parameter_regressor
from cartgrasp.model import CartModel
from cartgrasp.simulation.sensors import SensorNoise
from cartgrasp.studies.motion_bound import TrueMotion, information_of

CART = CartModel(Inertia(24.0, (0.3, 0.05), 2.0), effects=(ViscousDrag(3.0, 1.0), RollingResistance(0.015)))
PERIOD, NOISE = 0.05, np.array([[9.0, 0.4], [0.4, 0.3]])


def weaving(n: int) -> TrueMotion:
    time = PERIOD * np.arange(n)
    nu = np.column_stack([0.5 + 0.3 * np.sin(2.0 * time), 0.4 * np.cos(3.0 * time)])
    pose = np.zeros((n, 3))
    pose[:, 2] = np.concatenate([[0.0], np.cumsum(PERIOD * (nu[1:, 1] + nu[:-1, 1]) / 2)])
    return TrueMotion(pose, nu, PERIOD, np.arange(n - 1) % 7 != 3)


def test_exact_sensors_leave_what_wrenches_tell():
    motion = weaving(60)
    exact = SensorNoise(1e-9, 1e-9, 1e-9, 1e-9, 3.0, 0.1)
    middle = (motion.velocity[1:] + motion.velocity[:-1]) / 2
    pose = (motion.pose[1:] + motion.pose[:-1]) / 2
    regressor = parameter_regressor(CART, np.hstack([pose, middle]), np.diff(motion.velocity, axis=0) / PERIOD)
    told = fisher_information(regressor[motion.used], NOISE)
    found = information_of(CART, motion, NOISE, exact)
    assert found == pytest.approx(told, rel=1e-4, abs=1e-4 * np.abs(told).max())


def test_it_is_what_dense_elimination_gives():
    """Dense, of the motion as a first nu, nu' and a first place: other unknowns for the same."""
    n, sensors = 24, SensorNoise(0.004, 0.003, 0.05, 0.04, 3.0, 0.1)
    motion = weaving(n)
    state = np.hstack([motion.pose, motion.velocity])
    rise = np.diff(motion.velocity, axis=0) / PERIOD
    middle = (state[1:] + state[:-1]) / 2
    there = CART.inverse(middle, rise)
    to_nu = np.zeros((n, 2, n, 2))  # by the first nu and each nu'
    for k in range(n):
        to_nu[k, :, 0], to_nu[k, :, 1 : k + 1] = np.eye(2), PERIOD * np.eye(2)[:, None, :]
    rows = []
    white = np.linalg.inv(np.linalg.cholesky(NOISE))
    for k in np.flatnonzero(motion.used):
        by = there.by_state[k][:, 3:5] @ (to_nu[k] + to_nu[k + 1]).reshape(2, -1) / 2
        own = np.zeros((2, n, 2))
        own[:, k + 1] = there.by_acceleration[k]
        rows.append(white @ np.hstack([there.by_parameters[k], by + own.reshape(2, -1), np.zeros((2, 2))]))
    way = np.zeros((2, 2 * n))
    p = len(CART.parameters)
    for k in range(n):
        if k:
            way = way + PERIOD * (to_nu[k - 1] + to_nu[k]).reshape(2, -1) / 2
        velocity = np.hstack([np.zeros((2, p)), to_nu[k].reshape(2, -1), np.zeros((2, 2))])
        place = np.hstack([np.zeros((2, p)), way, np.eye(2)])
        rows += [np.diag([1 / 0.05, 1 / 0.04]) @ velocity, np.diag([1 / 0.004, 1 / 0.003]) @ place]
    whole = np.concatenate(rows)
    prior = 1e-2 * np.eye(p)
    information = whole.T @ whole
    information[:p, :p] += prior
    told = np.linalg.inv(information)[:p, :p]
    found = np.linalg.inv(information_of(CART, motion, NOISE, sensors) + prior)
    np.testing.assert_allclose(found, told, rtol=1e-4, atol=1e-6 * np.abs(told).max())
