"""The residual's polygon against all rows: what it knows of slow waves is what dense sums over the log know."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import cholesky_banded

from cartgrasp.constraints import RollingConstraints
from cartgrasp.effects import ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.logs import ArmLog
from cartgrasp.model import CartModel
from estimation.batch.noise_colour import NoiseColour
from estimation.batch.wrench_regression import WrenchRegression
from estimation.discrepancy import polygon as polygons
from estimation.discrepancy.fitted import Fitted
from estimation.discrepancy.polygon import REACH, STEP, Polygon, _dominant

from .runs import simulate

TRUTH = (24.0, 0.28, 0.0, 2.2, 3.0, 1.2, 0.0)
RAIL = CartModel(Inertia(24.0, (0.28, 0.0), 2.2), RollingConstraints(0.0, no_rotation=True), (ViscousDrag(3.0),))


def fitted_on_a_rail(colour, missing):
    log, _ = simulate(TRUTH, 5, 20.0, curved=False, noise=(0.0005, 0.005, 2.0))
    pose = log.pose.copy()
    pose[missing] = np.nan
    regression = WrenchRegression(replace(log, pose=pose), RAIL, None).coloured(colour)
    return Fitted((regression,), RAIL)


@pytest.mark.parametrize("colour", [None, NoiseColour(0.3, 8.0, 0.06)])
@pytest.mark.parametrize("missing", [slice(0), slice(700, 760)])
@pytest.mark.parametrize("frequency", [0.1, 0.4, 1.3])
def test_a_slow_wave_is_as_sure_as_in_all_rows(colour, missing, frequency):
    """But for what straight lines take from its amplitude: they keep a share sinc²(frequency step)."""
    fitted = fitted_on_a_rail(colour, missing)
    ((_, line, _),) = fitted.linearised
    polygon = Polygon.of([line])

    def waves(time):
        return np.column_stack([np.sin(2 * np.pi * frequency * time), np.cos(2 * np.pi * frequency * time)])

    information, pull = line.taught(waves(line.time)[:, None, :])
    columns = polygon.whitened(0, waves(polygon.time))
    size, kept = np.sqrt(np.diagonal(information)), np.sinc(frequency * STEP) ** 2
    np.testing.assert_allclose(columns.T @ columns, kept**2 * information, atol=0.02 * size.max() ** 2)
    np.testing.assert_allclose(columns.T @ polygon.standard(0), kept * pull, atol=0.15 * size.max())


def test_logs_stand_beside_one_another():
    whole = [fitted_on_a_rail(None, slice(0)).linearised[0][1] for _ in range(2)]
    one, both = Polygon.of(whole[:1]), Polygon.of(whole)
    b = len(one.time)
    np.testing.assert_array_equal(both.log, np.repeat([0, 1], b))
    for k in range(2):
        np.testing.assert_allclose(both.standard(0)[k * b : (k + 1) * b], one.standard(0), rtol=1e-9, atol=1e-9)


@given(
    values=st.lists(st.floats(-1e3, 1e3), min_size=(REACH + 1) * 12, max_size=(REACH + 1) * 12),
    least=st.floats(1e-3, 1.0),
)
def test_a_band_that_is_cut_off_is_mended(values, least):
    band = np.array(values).reshape(REACH + 1, 12)
    band[0] = np.abs(band[0]) + least
    for apart in range(1, REACH + 1):
        band[apart, 12 - apart :] = 0.0
    mended = _dominant(band)
    assert np.isfinite(cholesky_banded(mended, lower=True)).all()
    assert (mended[0] >= band[0]).all()
    np.testing.assert_array_equal(mended[1:], band[1:])


@pytest.mark.parametrize("told", [1e-6, 0.0, -1e-9, -1e-4])
def test_nodes_that_tell_nothing_are_told_by_none(told):
    """As across a jolt; others are as if they were not there."""
    fitted = fitted_on_a_rail(None, slice(0))
    ((_, line, _),) = fitted.linearised
    weight = np.where((line.time > 9.0) & (line.time < 10.0), told, 1.0)[:, None, None]
    white = SimpleNamespace(time=line.time, residual=line.residual, whitened=lambda columns: weight * columns)
    polygon = Polygon.of([white])
    before = polygon.time < 8.0
    expected = Polygon.of([SimpleNamespace(time=line.time, residual=line.residual, whitened=lambda columns: columns)])
    np.testing.assert_allclose(polygon.value[before], expected.value[before], rtol=1e-3, atol=1e-3)
    assert np.isfinite(polygon.standard(0)).all()


@pytest.fixture(scope="module")
def held_aside():
    """A log of a hand far from the middle, whose force's noise is in the moment too."""
    log, _ = simulate(TRUTH, 6, 14.0, noise=(0.0005, 0.005, 0.0))
    hand = log.arms["hand"]
    aside = np.array([0.0, 0.4, 0.0])
    noise = np.random.default_rng(0).standard_normal((len(log), 6)) * [2.0, 2.0, 2.0, 0.1, 0.1, 0.1]
    wrench = hand.wrench + np.outer(hand.wrench[:, 0], [0, 0, 0, 0, 0, 0.4]) + noise
    cart = CartModel(Inertia(24.0, (0.28, 0.0), 2.2), effects=(ViscousDrag(3.0, 1.2),))
    beside = replace(log, arms={"hand": ArmLog(hand.contact + aside, wrench)})
    return Fitted((WrenchRegression(beside, cart, None),), cart)


@pytest.mark.parametrize("window", [20, 1000])
def test_each_direction_is_known_as_if_nothing_were_of_the_others(held_aside, window, monkeypatch):
    """By the inverse of the inverse of all nodes' information; a window more or less changes nothing."""
    ((_, line, _),) = held_aside.linearised
    monkeypatch.setattr(polygons, "WINDOW", window)
    _, _, band = polygons._nodes(line)
    whole = polygons._dense(band)
    covariance = np.linalg.inv(whole)
    for i in range(2):
        expected = np.linalg.inv(covariance[i::2, i::2])
        found = polygons._dense(polygons._alone(band, 2, i))
        size = np.abs(expected).max()
        reach = np.abs(np.subtract.outer(np.arange(len(found)), np.arange(len(found)))) <= REACH
        np.testing.assert_allclose(found[reach], expected[reach], atol=1e-3 * size)
    less = whole[::2, ::2].diagonal() / np.linalg.inv(covariance[::2, ::2]).diagonal()
    assert np.median(less) > 1.2


def test_noise_is_as_large_as_it_is_along_each_direction(held_aside):
    """Squares of one in means over half a second, though directions know of one another."""
    scatter = held_aside.scatter
    for i in range(2):
        assert np.mean((scatter.mean[:, i] / scatter.std[:, i]) ** 2) * scatter.excess == pytest.approx(1.0, abs=0.5)
    conditional = np.sqrt(scatter.excess / np.diagonal(scatter.information, axis1=1, axis2=2))
    assert np.median(scatter.std / conditional) > 1.1
