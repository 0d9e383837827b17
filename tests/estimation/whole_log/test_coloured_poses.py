"""What a log teaches whose poses have noise that remembers."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from cartgrasp.effects import ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from estimation.whole_log.identification import identify

from ..runs import STEP, simulate_two_hands

TRUTH = (24.0, 0.28, 0.06, 2.2, 3.0, 1.2, 0.0)
GUESS = CartModel(Inertia(20.0, (0.3, 0.0), 1.8), effects=(ViscousDrag(linear=2.0, angular=1.0),))
WHITE, SLOW, TIME = 0.0005, 0.001, 0.2


def remembering(n, random, time=TIME, step=STEP):
    """Noise (n, 3) of unit variance that fades with a correlation time."""
    fade = np.exp(-step / time)
    white = random.standard_normal((n, 3))
    white[1:] *= (1 - fade**2) ** 0.5
    return lfilter([1.0], [1.0, -fade], white, axis=0)


def recorded(seed, duration=40.0, slow=SLOW, time=TIME, velocity=False):
    log = simulate_two_hands(TRUTH, seed, duration, noise=(WHITE, 0.005, 1.0))
    noise = slow * remembering(len(log), np.random.default_rng(1000 + seed), time)
    return replace(log, pose=log.pose + noise, velocity=log.velocity if velocity else None)


def scores(log):
    found = identify([log], GUESS).parameters.values()
    return np.array([(p.value - v) / p.std for p, v in zip(found, TRUTH[:6], strict=True)])


@pytest.mark.some(1)
@pytest.mark.long
@pytest.mark.parametrize("velocity", [False, True])
def test_the_load_is_found_beside_it(velocity):
    found = identify([recorded(3, velocity=velocity)], GUESS).parameters
    assert found["mass"].value == pytest.approx(24.0, rel=0.04)
    assert found["inertia"].value == pytest.approx(2.2, rel=0.15)
    assert np.abs(scores(recorded(3, velocity=velocity))).max() < 4.0


@pytest.mark.prove
def test_intervals_cover_over_20_seeds():
    z = np.array([scores(recorded(seed)) for seed in range(20)])
    assert np.abs(z).max() < 4.5
    assert np.sqrt((z**2).mean()) < 1.3
    assert (np.abs(z) < 1.96).mean() > 0.88
