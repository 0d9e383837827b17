"""What rows tell in spite of noise in their slopes, against closed forms and drawn rows."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from estimation.online.kernels.row_parts import SIGNIFICANCE_SIGMAS
from estimation.online.kernels.slope_noise import SlopeNoise, without_slope_noise
from tests.kernels_called import called

from ...core.drawn import vectors

told = called(without_slope_noise)


def since(noise, squares, mean, covariance):
    first = np.linalg.inv(covariance)
    return SlopeNoise(np.asarray(noise, float), np.array([squares]), np.asarray(mean, float), covariance, first)


def test_without_noise_it_is_what_rows_tell():
    belief = np.array([[5.0, 1.0], [1.0, 4.0]]), np.array([3.0, 2.0])
    found = told(belief, since(np.zeros((2, 2)), 0.0, [1.0, 1.0], np.eye(2)))
    np.testing.assert_array_equal(found[0], belief[0])
    np.testing.assert_array_equal(found[1], belief[1])


def test_in_one_direction_it_is_godambes_information():
    """First information 0.25 around 4; rows add 10 by slopes of which noise is 3, in 50 rows alike."""
    first, rows, noise, n = 0.25, 10.0, 3.0, 50
    pull = first * 4.0 + (rows - noise) * 5.0  # a score of zero at 5
    found = told(
        (np.array([[first + rows]]), np.array([pull])),
        since([[noise]], n * (noise / n / first) ** 2, [4.0], np.array([[1.0 / first]])),
    )
    slope, share = 1.0 - noise / rows, noise / rows
    weight = 1.0 - SIGNIFICANCE_SIGMAS**2 * 2.0 / n * share**2 / slope**2
    varies = 1.0 + share + noise / first / n * share * (1.0 + share * rows / noise)
    information = weight * slope**2 * rows / varies
    assert found[0][0, 0] == pytest.approx(first + information, rel=2e-3)
    assert found[1][0] == pytest.approx(first * 4.0 + information * 5.0, rel=2e-3)


@pytest.mark.parametrize("rows", [2.0, 3.2])
def test_where_slopes_are_noise_the_first_belief_stays(rows):
    """In the second direction rows add what noise does, or what it might; in the first they tell."""
    covariance = np.diag([4.0, 9.0])
    turn = np.array([[0.8, -0.6], [0.6, 0.8]])
    first = turn @ np.linalg.inv(covariance) @ turn.T
    information = first + turn @ np.diag([40.0, rows]) @ turn.T
    noise = turn @ np.diag([0.1, 3.0]) @ turn.T
    mean, score = np.array([1.0, 2.0]), turn @ np.array([20.0, 30.0])
    pull = first @ mean + (information - first - noise) @ mean + score
    given = since(noise, (3.0 * 9.0 + 0.4) ** 2 / 25.0, mean, np.linalg.inv(first))
    found, more = told((information, pull), given)
    assert (turn.T @ found @ turn)[1, 1] == pytest.approx(1.0 / 9.0, rel=2e-3)
    off = turn.T @ (np.linalg.solve(found, more) - mean)
    assert off[1] == pytest.approx(0.0, abs=1e-9)
    assert off[0] == pytest.approx(20.0 / 39.9, rel=0.02)


def test_what_is_linked_with_the_unknowns_stays_linked():
    """Given the unknowns, what is believed of a link is as before."""
    whole = np.array([[6.0, 0.5, 1.0], [0.5, 3.0, -0.4], [1.0, -0.4, 2.0]])
    found, _ = told((whole, np.ones(3)), since(0.5 * np.eye(2), 0.1, [0.0, 0.0], np.eye(2)))
    np.testing.assert_array_equal(found[2], whole[2])
    assert np.linalg.eigvalsh(found).min() > 0.0


@given(numbers=vectors(6, -1.0, 1.0), faded=st.floats(0.05, 0.95))
def test_where_less_is_left_than_was_known_first_it_stays_positive(numbers, faded):
    """Rows forget along what they ask, which may be part of the first belief."""
    along, slopes = numbers[:2] + np.array([1.5, 0.0]), numbers[2:].reshape(2, 2)
    first = np.array([[2.0, 0.3], [0.3, 1.0]])
    asked = first @ along
    information = first - faded * np.outer(asked, asked) / (along @ asked) + 1e-6 * np.eye(2) + slopes @ slopes.T
    noise = 0.3 * slopes @ slopes.T
    found, _ = told((information, np.zeros(2)), since(noise, 0.02, [0.0, 0.0], np.linalg.inv(first)))
    assert np.linalg.eigvalsh(found).min() > 0.0
    assert np.linalg.eigvalsh(information - found).min() > -1e-9
