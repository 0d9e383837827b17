"""Force sensors that freeze under an online filter."""

from __future__ import annotations

import numpy as np
import pytest

from cartgrasp import CartModel, Inertia, Measurement
from cartgrasp.effects import ViscousDrag
from estimation import CartFilter, DisturbedFilter
from estimation.online.frozen_wrenches import SENSOR_CALIBRATION_ROWS, FrozenWrenches

CART = CartModel(Inertia(20.0, (0.3, 0.0), 2.0), effects=(ViscousDrag(5.0, 2.0),))
HOLD = {"hand": np.array([-0.25, 0.0, 1.0])}


def told(rows, used=slice(None)):
    """Which of the rows (n, 6) a watch believes, by the components that are used."""
    watch = FrozenWrenches()
    seen = [
        watch.without_frozen(Measurement(0.01 * k, wrenches={"hand": row}, contacts=HOLD)) for k, row in enumerate(rows)
    ]
    return np.array([np.isfinite(one.wrenches["hand"][used]).all() for one in seen])


def rows(count, noise):
    smooth = np.sin(0.013 * np.arange(count)[:, None] * np.arange(1, 7))
    return smooth + noise * np.random.default_rng(0).standard_normal((count, 6))


@pytest.mark.parametrize("odd", [0.0, np.nan])
def test_a_sensor_that_tells_noise_never_stays_as_it_is(odd):
    """What pushes no planar cart may be missing, always."""
    felt = rows(SENSOR_CALIBRATION_ROWS + 100, 0.1) + np.array([0.0, 0.0, odd, odd, odd, 0.0])
    felt[SENSOR_CALIBRATION_ROWS + 20 : SENSOR_CALIBRATION_ROWS + 60] = felt[SENSOR_CALIBRATION_ROWS + 19]
    believed = told(felt, [0, 1, 5])
    assert believed[: SENSOR_CALIBRATION_ROWS + 20].all()
    assert believed[SENSOR_CALIBRATION_ROWS + 60 :].all()
    assert not believed[SENSOR_CALIBRATION_ROWS + 24 : SENSOR_CALIBRATION_ROWS + 60].any()


def test_a_sensor_is_known_by_what_it_tells_once_it_tells():
    """An arm that comes later gives exact zeros until then: it had never been known to tell noise."""
    felt = np.concatenate([np.zeros((300, 6)), rows(SENSOR_CALIBRATION_ROWS + 100, 0.1)])
    felt[-60:] = felt[-61]
    believed = told(felt)
    assert believed[:-60].all()
    assert not believed[-50:].any()


@pytest.mark.parametrize(
    "felt",
    [
        np.repeat(rows(SENSOR_CALIBRATION_ROWS, 0.0), 3, axis=0),
        np.repeat(rows(SENSOR_CALIBRATION_ROWS, 0.1), 3, axis=0),
        np.concatenate([rows(SENSOR_CALIBRATION_ROWS, 0.0), np.repeat(rows(1, 0.0), 200, axis=0)]),
        np.concatenate([rows(SENSOR_CALIBRATION_ROWS, 0.1), np.zeros((200, 6))]),
        np.round(rows(3 * SENSOR_CALIBRATION_ROWS, 0.1)),
    ],
    ids=["held", "noisy and held", "no noise", "lets go", "coarse"],
)
def test_what_only_seems_so_is_believed(felt):
    assert told(felt).all()


@pytest.mark.parametrize("kind", [CartFilter, DisturbedFilter])
def test_nothing_is_learned_from_a_frozen_sensor(kind):
    """For 1.5 s of every 4 s. Before, one told a push in 4 s of them, and to the other nothing fitted: 19.5 kg."""
    made, random, speed, x, acted = kind(CART, ["hand"]), np.random.default_rng(3), 0.0, 0.0, []
    last = np.zeros(6)
    for k in range(2000):
        time = 0.01 * k
        force = 15.0 * np.sin(1.3 * time) + 5.0 * np.sin(3.1 * time)
        felt = np.array([force, 0.0, 0.0, 0.0, 0.0, 0.0]) + random.normal(size=6) * [0.3, 0.3, 0.3, 0.03, 0.03, 0.03]
        last = last if time % 4.0 > 2.5 and time > 4.0 else felt
        off = random.normal(size=6) * [5e-4, 5e-4, 5e-4, 5e-3, 5e-3, 5e-3]
        pose, velocity = np.add(off[:3], [x, 0, 0]), np.add(off[3:], [speed, 0, 0])
        now = Measurement(time, pose, velocity, {"hand": last}, HOLD)
        estimate = made.update(now)
        acted.append(time > 1.0 and estimate.disturbance is not None and estimate.disturbance.acts)
        speed, x = speed + 0.01 * (force - 5.0 * speed) / 24.0, x + 0.01 * speed
    mass = estimate.parameters["mass"]
    assert abs(mass.value - 24.0) < 3.0 * mass.std < 3.0
    assert not any(acted)
