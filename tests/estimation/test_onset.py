"""When a load is put on, by whole fits, on logs of the tests' own equations."""

import numpy as np
import pytest

from cartgrasp.effects import PayloadChange, ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from estimation.batch.wrench_regression import WrenchRegression
from estimation.discrepancy.fitted import Fitted
from estimation.discrepancy.onset import MOST_FITS, with_best_onset

from .runs import simulate_two_hands

ALONE, LOAD, ONSET = (24.0, 0.28, 0.06, 2.2, 3.0, 1.2, 0.0), (6.0, 0.7, -0.2), 7.3
GUESS = CartModel(Inertia(22.0, (0.3, 0.0), 2.0), effects=(ViscousDrag(linear=2.5, angular=1.0),))


def loaded():
    """The cart with the load on it, by the parallel axis theorem."""
    m, dx, dy, inertia, *drag = ALONE
    mass, x, y = LOAD
    whole = m + mass
    com = (m * dx + mass * x) / whole, (m * dy + mass * y) / whole
    apart = m * mass / whole * ((dx - x) ** 2 + (dy - y) ** 2)
    return whole, *com, inertia + apart, *drag


def fitted(seed=0):
    log = simulate_two_hands(ALONE, seed, duration=16.0, noise=(0.0004, 0.005, 1.0), change=(ONSET, loaded()))
    return Fitted((WrenchRegression(log, GUESS, None),), GUESS)


@pytest.mark.parametrize("off", [-2.5, -0.8, 0.0, 1.2, 2.6])
def test_it_is_found_from_far_and_from_near(off):
    base = fitted()
    model = base.tried(PayloadChange(time=ONSET + off, mass=3.0, x=0.3, y=0.0))
    found = with_best_onset(base, model)
    effect = next(e for e in found.cart.effects if e.name == "payload_change")
    assert effect.time == pytest.approx(ONSET, abs=0.15)
    assert effect.values[1:] == pytest.approx(LOAD, abs=0.25)
    assert found.chi_squared() <= model.chi_squared()


def test_it_does_not_run_away():
    """Where no time is better than the next, or each is."""

    class Fit:
        def __init__(self, effect, fits):
            self.added, self.cart, self.fits = (effect,), CartModel(GUESS.inertia, effects=(effect,)), fits

        def tried(self, effect):
            self.fits.append(effect.time)
            return Fit(effect, self.fits)

        def chi_squared(self, keys):
            return self.slope * self.added[0].time

    for slope, expected in ((0.0, 4.0), (-50.0, 4.0 + MOST_FITS - 1)):
        Fit.slope, fits = slope, []
        model = Fit(PayloadChange(time=4.0, mass=3.0), fits)
        found = with_best_onset(model, model)
        assert found.added[0].time == expected
        assert len(fits) <= MOST_FITS
    assert np.isfinite(fits).all()
