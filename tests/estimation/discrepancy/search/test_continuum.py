"""Lines and humps: what repeats, and noise that wanders about a period."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.signal import lfilter

from cartgrasp.effects import LearnedForce
from estimation.discrepancy import diagnose
from estimation.discrepancy.search.continuum import NEIGHBOURS_PER_SIDE, NOISE_HUMP_NATS, beside_neighbours
from estimation.discrepancy.search.gains import MIN_GAIN_NATS, score_gain
from estimation.discrepancy.search.laws import Law
from estimation.discrepancy.search.model import Model
from estimation.weak_form.balances import Balances

from .test_laws import CART, resisted

PERIOD = 1.8


def line(time, truth):
    return 6.0 * np.sin(2 * np.pi * time / PERIOD)


def wandering(seed, lasts=4.0, force=4.0):
    """A force about a period, of that standard deviation, whose phase is forgotten in `lasts` seconds."""

    def drawn(time, truth):
        step = time[1] - time[0]
        shrink, turn = np.exp(-step / lasts), 2 * np.pi * step / PERIOD
        white = np.random.default_rng(seed).standard_normal(20 * len(time))
        found = lfilter([1.0], [1.0, -2 * shrink * np.cos(turn), shrink**2], white)[-len(time) :]
        return force * found / found.std()

    return drawn


def compared(force, seed, duration=60.0):
    started = Model.started([Balances.of(resisted(force, seed, duration), CART)], CART)
    return replace(started, compares=True).rewhitened()


def with_law(model, period, *, harmonics=(1.0,)):
    law = Law.free("force", LearnedForce("forward_force", "time", period=period, harmonics=harmonics))
    return replace(model, laws=(law,)).refitted(model.cart), law


def best_of(model):
    """Gain of the law that gains most, and that beside its neighbours, for as many as were tried."""
    tried = [with_law(model, period) for period in np.arange(1.6, 2.0, 0.02)]
    gain, one, law = max(
        ((score_gain(model.score, own.score, None), own, law) for own, law in tried), key=lambda it: it[0]
    )
    return gain - np.log(len(tried)), beside_neighbours(one, law) - np.log(len(tried))


@pytest.mark.some(1)
@pytest.mark.parametrize("seed", range(6))
def test_a_line_stands_out_and_a_hump_does_not(seed):
    """Both gain as much beside white noise as what is told by name."""
    gain, beside = best_of(compared(line, seed))
    assert gain > 2 * MIN_GAIN_NATS
    assert beside > 2 * MIN_GAIN_NATS
    gain, beside = best_of(compared(wandering(seed), seed))
    assert gain > 2 * MIN_GAIN_NATS
    assert beside < MIN_GAIN_NATS


def test_it_is_the_integral_over_the_noise_of_the_neighbours():
    """Against lines fitted one by one to the rows, and the density of their squares integrated over all variances."""
    model, law = with_law(compared(wandering(3), 3, 30.0), PERIOD)
    scale, span = model.score.scale, model.motions[0].time[-1] - model.motions[0].time[0]
    rows = (model.rows / scale[:, None]).reshape(-1, model.rows.shape[2])
    left, base = rows[:, -1], rows[:, :-1]
    prior = np.diag(1 / model.prior_std)

    def misfit(columns):
        whole = np.vstack([columns, np.hstack([prior, np.zeros((len(prior), columns.shape[1] - base.shape[1]))])])
        found = np.linalg.lstsq(whole, np.append(left, np.zeros(len(prior))))[0]
        return ((np.append(left, np.zeros(len(prior))) - whole @ found) ** 2).sum()

    squares = []
    for side in range(-NEIGHBOURS_PER_SIDE, NEIGHBOURS_PER_SIDE + 1):
        if abs(side) > 1:
            _, other = with_law(model, 1 / (1 / PERIOD + side / span))
            own = model.whitened([other.columns(balances, model.cart) for balances in model.logs]) / scale[:, None]
            squares.append(misfit(base) - misfit(np.hstack([base, own.reshape(len(base), -1)])))
    (place,) = model.law_places
    fit, covariance = model.score.fit[place], model.score.covariance[place, place]
    own = fit @ np.linalg.solve(covariance, fit)

    def log_density(total, count):
        peak = np.log(max(total / count, 1e-6))
        any_scale = quad(
            lambda x: np.exp(-count / 2 * (x - peak) - total / 2 * (np.exp(-x) - np.exp(-peak))), peak - 8, peak + 8
        )[0]
        hump = np.log(any_scale) - count / 2 * peak - total / 2 * np.exp(-peak) - NOISE_HUMP_NATS
        return np.logaddexp(-total / 2, hump)

    total, count = sum(squares), 2 * len(squares)
    expected = log_density(total, count) - log_density(total + own, count + 2)
    expected += np.linalg.slogdet(covariance)[1] / 2 - np.log(law.std).sum()
    assert beside_neighbours(model, law) == pytest.approx(expected, rel=0.03, abs=0.3)


def test_it_is_no_more_than_beside_white_noise():
    """Of a harmonic without neighbours, too: those of two turns in all leave no frequency between them."""
    model, law = with_law(compared(line, 0, 12.0), 6.0, harmonics=(1.0, 2.0, 3.0, 4.0, 5.0, 6.0))
    (place,) = model.law_places
    fit, covariance = model.score.fit[place], model.score.covariance[place, place]
    own = sum(
        fit[at : at + 2] @ np.linalg.solve(covariance[at : at + 2, at : at + 2], fit[at : at + 2])
        for at in range(0, 12, 2)
    )
    volume = np.linalg.slogdet(covariance)[1] / 2 - np.log(law.std).sum()
    assert beside_neighbours(model, law) <= own / 2 + volume + 1e-9


@pytest.mark.long
@pytest.mark.some(1)
@pytest.mark.parametrize("seed", range(10, 14))
def test_what_wanders_about_a_period_is_no_law(seed):
    found = diagnose(resisted(wandering(seed), seed, 60.0), CART)
    assert "learned_force" not in [effect.name for effect in found.effects]
