"""What the forms of effects that were found may leave, against columns of those effects, and what is no form."""

from dataclasses import replace

import numpy as np
import pytest

from cartgrasp.effects import DirectionalDrag, ForceBias, RollingResistance, ViscousDrag, WheelMisalignment
from cartgrasp.effects.external_push import ExternalPush
from cartgrasp.effects.time_delay import TimeDelay
from cartgrasp.inertia import Inertia
from cartgrasp.logs import ArmLog, RunLog
from cartgrasp.model import CartModel
from estimation.discrepancy.search.form_error import FormError, modes_of
from estimation.discrepancy.search.gains import score_gain, scored_candidate
from estimation.discrepancy.search.model import Model
from estimation.discrepancy.search.screening import Screen
from estimation.discrepancy.search.search import refitted_candidate
from estimation.weak_form.balances import Balances

from ...runs import simulate
from ...weak_form.motions import RAIL, RAIL_DRAG, RAIL_MASS, noisy

TRUTH = (24.0, 0.28, 0.06, 2.2, 3.0, 1.2, 0.0)
CART = CartModel(Inertia(24.0, (0.28, 0.06), 2.2), effects=(ViscousDrag(linear=3.0, angular=1.2),))
DRAG = 6.0
"""N."""


def dragged(size, delay=0):
    """A log of a cart with a dry drag that is `size(time)` times as large, and wrenches `delay` samples late."""
    log, truth = simulate(TRUTH, 3, 30.0, noise=(0.0005, 0.005, 1.0))
    ((name, arm),) = log.arms.items()
    wrench = arm.wrench.copy()
    more = DRAG * size(log.time) * np.tanh(truth[:, 3] / 0.01)
    wrench[:, 0] += more
    wrench[:, 5] += arm.contact[:, 1] * more
    wrench[delay:] = wrench[: len(wrench) - delay].copy()
    return replace(log, arms={name: ArmLog(arm.contact, wrench)})


def to_and_fro(backwards):
    """On a rail, with a dry drag that is so many times as large `backwards`."""
    time = np.arange(0.0, 30.0, 0.01)
    slow, fast = 2 * np.pi * 0.13, 2 * np.pi * 0.31
    x = -0.5 / slow * np.cos(slow * time) - 0.2 / fast * np.cos(fast * time)
    speed = 0.5 * np.sin(slow * time) + 0.2 * np.sin(fast * time)
    rate = 0.5 * slow * np.cos(slow * time) + 0.2 * fast * np.cos(fast * time)
    zero, wrench = np.zeros_like(time), np.zeros((len(time), 6))
    drag = DRAG * np.tanh(speed / 0.01) * np.where(speed < 0, backwards, 1.0)
    wrench[:, 0] = RAIL_MASS * rate + RAIL_DRAG * speed + drag
    poses, velocities = np.column_stack([x, zero, zero]), np.column_stack([speed, zero, zero])
    log = RunLog(time, poses, velocities, {"arm": ArmLog(np.zeros((len(time), 3)), wrench)}, name="rail")
    return noisy(log, 4, 1e-4, 1e-3, 0.5)


def with_drag(log, cart=CART):
    """A model that knows the drag, but not what else it may be."""
    model = Model.started([Balances.of(log, cart)], cart)
    model = model.refitted(model.cart.with_effect(RollingResistance(0.02))).settled()
    return replace(model, compares=True).rewhitened()


def tried(model, effect):
    """The candidate, refined and fitted, with what it gains beside forms."""
    return refitted_candidate(model, Screen(model), scored_candidate(model, effect, 1), FormError(model))


@pytest.mark.long
@pytest.mark.parametrize(
    ("effect", "sizes", "which"),
    [
        (RollingResistance(0.02), [0.02], slice(0, 2)),
        (ForceBias(1.0, 0.5, 0.2), [1.0, 0.5, 0.2], slice(0, 2)),
        (WheelMisalignment.usual(""), [1.0], slice(2, 3)),
    ],
)
def test_what_an_effect_makes_is_its_column_times_its_size(effect, sizes, which):
    """By both roads: the balances with and without it, and the column of a unit of it."""
    balances = Balances.of(dragged(np.ones_like), CART)
    found = balances.integrated(balances.taken(CART.with_effect(effect)) - balances.taken(CART))[:, which]
    columns = (balances.columns(CART, effect) @ sizes)[:, which]
    assert np.abs(columns).max() > 0.0
    assert np.abs(found - columns).max() < 0.01 * np.abs(columns).max()


@pytest.mark.long
def test_a_drag_that_slowly_grows_is_no_push():
    """Alone beside it a push is worth a name; beside a drag that may be another at another time it is not."""
    model = with_drag(dragged(lambda time: 1.0 + 0.5 * np.exp(-(((time - 15.0) / 3.0) ** 2))))
    push = tried(model, ExternalPush(13.0, 4.0, -2.0, 0.0))
    assert push.gain > 20.0
    assert push.beside_forms < 0.3 * push.gain
    assert push.own_gain == push.beside_forms


@pytest.mark.long
def test_wrenches_that_come_late_are_no_form_of_a_drag():
    model = with_drag(dragged(np.ones_like, delay=3))
    late = tried(model, TimeDelay(0.03))
    assert late.gain > 30.0
    assert late.beside_forms > 0.8 * late.gain


def test_a_drag_that_is_another_backwards_has_a_name():
    model = with_drag(to_and_fro(0.4), RAIL)
    one_way = tried(model, DirectionalDrag(1.0, 0.0))
    assert one_way.gain > 30.0
    assert one_way.beside_forms > 0.7 * one_way.gain


@pytest.mark.long
def test_beside_a_form_that_is_right_nothing_is_gained():
    model = with_drag(dragged(np.ones_like))
    forms = FormError(model)
    alike, _ = forms.scores(model, RollingResistance(0.02))
    assert score_gain(model.score, alike, None) < 3.0
    assert forms.scores(model, RollingResistance(0.02))[1].stretches == pytest.approx(alike.stretches)


@pytest.mark.long
def test_modes_are_about_one_at_most():
    balances = Balances.of(dragged(np.ones_like), CART)
    modes = modes_of(balances.motion)
    assert np.isfinite(modes).all()
    assert modes.shape == (len(balances.motion.time), 23)
    assert np.abs(modes).max() <= 1.0 + 1e-9
