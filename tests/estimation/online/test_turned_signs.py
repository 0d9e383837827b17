"""Signs that turn while a cart is pushed, of rows that are drawn from a cart with another mass and friction than
guessed."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from estimation.online.turned_signs import ForceRow, TurnedSigns

ROWS, AT = 64, 40
SHARES = np.array([1.4, 0.7])
ARMS = np.array([[0.7, 0.3], [0.3, 0.7]])
"""Shares of the forces along and of the moments, by arm; and beside these arms pull against each other."""
LEVER, PUSH = 0.25, np.array([900.0, 80.0])


def rows(seed, noise=0.03, push=None):
    """Of a cart that is sped up and slowed down on a winding way, pushed by something beside the arms from `AT` on for
    some rows."""
    random, time = np.random.default_rng(seed), 0.25 * np.arange(ROWS)
    phase = random.uniform(0.0, 2.0 * np.pi, 2)
    velocity = np.stack([0.6 + 0.3 * np.sin(0.9 * time + phase[0]), 0.4 * np.sin(0.7 * time + phase[1])], axis=1)
    rate = np.gradient(velocity, time, axis=0)
    take = np.stack([rate * [24.0, 2.0], velocity * [3.0, 1.0] + np.sign(velocity) * [3.0, 0.5]], axis=1)
    give = np.einsum("k,nkf,af->naf", SHARES, take, ARMS)
    inner = 2.0 * np.sin(1.3 * time + phase.sum())
    give += inner[:, None, None] * np.array([[1.0, -LEVER], [-1.0, LEVER]]) * [1.0, 0.2]
    give += noise * random.standard_normal(give.shape) * [5.0, 1.0]
    if push is not None:
        force, until = push
        give[AT:until] -= 0.5 * np.asarray(force)
    found = []
    for one_take, one_give, one_velocity in zip(take, give, velocity, strict=True):
        powers = np.concatenate([one_take, one_give]) @ one_velocity
        speed = float(np.abs(one_velocity) @ [1.0, 0.35])
        found.append(ForceRow(powers, speed * one_take, speed * one_give, speed))
    return found


def taken_in(found):
    signs = [TurnedSigns.of(2, PUSH)]
    for row in found:
        signs.append(signs[-1].and_then(row).judged())
    return signs[1:]


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10_000), st.sampled_from([(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0)]))
def test_what_turns_is_told_within_three_seconds_and_until_it_turns_back(seed, turned):
    sound, signs = rows(seed), np.array(turned)
    faulty = [row.turned(signs) if AT <= k < AT + 14 else row for k, row in enumerate(sound)]
    told = [tuple(one.signs) for one in taken_in(faulty)]
    assert set(told[:AT]) == {(1.0, 1.0)}
    assert turned in told[AT : AT + 12]
    assert told[AT + 13] == turned
    assert told[-1] == (1.0, 1.0)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10_000))
def test_rows_that_turned_are_turned_back(seed):
    """So that later ones are held against what sound sensors say."""
    sound = rows(seed, noise=0.01)
    faulty = [row.turned(-np.ones(2)) if k >= AT else row for k, row in enumerate(sound)]
    products, count = taken_in(faulty)[-1].all_rows
    expected, also = taken_in(sound)[-1].all_rows
    assert count == also
    assert products == pytest.approx(expected, rel=1e-9, abs=1e-9 * np.abs(expected).max())


@settings(max_examples=20, deadline=None)
@given(
    st.integers(0, 10_000),
    st.floats(-60.0, 60.0),
    st.floats(-10.0, 10.0),
    st.sampled_from([AT + 2, AT + 8, ROWS]),
)
def test_a_push_is_no_sign(seed, force, moment, until):
    assert {tuple(one.signs) for one in taken_in(rows(seed, push=([force, moment], until)))} == {(1.0, 1.0)}


def test_before_rows_have_taught_the_cart_nothing_is_told():
    """Of what is wrong from the first row on, the power of all rows tells."""
    told = taken_in([row.turned(-np.ones(2)) for row in rows(1)])
    assert {tuple(one.signs) for one in told} == {(1.0, 1.0)}
