"""How sure a diagnosis is of its values: a push whose times are known, and pulls that cancel where a fit is best."""

from dataclasses import replace

import numpy as np
import pytest

from cartgrasp.effects import ExternalPush, ForceBias, PayloadChange, ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.logs import ArmLog
from cartgrasp.model import CartModel
from estimation.batch.wrench_regression import WrenchRegression
from estimation.discrepancy.certainty import balanced, certain, proven, pulls
from estimation.discrepancy.evidence import findings
from estimation.discrepancy.fitted import Fitted

from .runs import simulate

TRUTH = (24.0, 0.28, 0.06, 2.2, 3.0, 1.2, 0.0)
START, DURATION = 4.03, 0.93
CART = CartModel(Inertia(24.0, (0.28, 0.06), 2.2), effects=(ViscousDrag(linear=3.0, angular=1.2),))


def pushed(force, seed=0):
    """A log in which somebody else pushed too: the hand's wrench misses it."""
    log, _ = simulate(TRUTH, seed, 10.0, noise=(0.0005, 0.005, 3.0))
    ((name, arm),) = log.arms.items()
    wrench = arm.wrench.copy()
    wrench[:, 0] -= force * ((log.time > START) & (log.time < START + DURATION))
    return replace(log, arms={name: ArmLog(arm.contact, wrench)})


def fitted(force, seed=0, guess=(4.0, 1.0)):
    added = ExternalPush(*guess, force=force, moment=0.0)
    return Fitted((WrenchRegression(pushed(force, seed), CART, None),), CART, (added,))


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_times_are_known_as_well_as_they_are_said_to_be(seed):
    sure, vague = certain(fitted(40.0, seed)), certain(fitted(6.0, seed))
    for found in (sure, vague):
        (push,) = found.fitted.added
        assert abs(push.start - START) < 3 * found.settings["external_push.start"]
        assert abs(push.duration - DURATION) < 3 * found.settings["external_push.duration"]
    assert abs(sure.fitted.added[0].start - START) < 0.05
    assert sure.settings["external_push.start"] < vague.settings["external_push.start"]


def test_a_push_of_another_form_is_no_less_sure():
    """Half a sine whose halves contradict the rectangle that is fitted to it, by so much that it weighs less."""
    log = pushed(0.0)
    ((name, arm),) = log.arms.items()
    wrench = arm.wrench.copy()
    wrench[:, 0] -= 90.0 * np.sin(np.pi * np.clip((log.time - START) / 1.5, 0, 1))
    log = replace(log, arms={name: ArmLog(arm.contact, wrench)})
    nearest = ExternalPush(START + 0.19, 1.11, 70.0, 0.0)
    found = certain(Fitted((WrenchRegression(log, CART, None),), CART, (nearest,)))
    assert found.deviations["external_push"] > 4


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_what_rises_and_falls_begins_and_ends_where_it_does(seed):
    """The rectangle that is nearest to half a sine begins 0.12 s later; with the same mean it has the same impulse."""
    log = pushed(0.0, seed)
    ((name, arm),) = log.arms.items()
    wrench = arm.wrench.copy()
    wrench[:, 0] -= 40.0 * np.sin(np.pi * np.clip((log.time - START) / DURATION, 0, 1))
    log = replace(log, arms={name: ArmLog(arm.contact, wrench)})
    nearest = ExternalPush(START + 0.12, 0.742 * DURATION, 40.0, 0.0)
    found, removed = proven(Fitted((WrenchRegression(log, CART, None),), CART, (nearest,)))
    assert removed == ()
    push = found.cart.effects[-1]
    assert abs(push.start - START) < min(0.08, 3 * found.settings["external_push.start"])
    assert abs(push.duration - DURATION) < min(0.15, 3 * found.settings["external_push.duration"])
    force = found.parameters["external_push.force"]
    assert force.value == pytest.approx(2 / np.pi * 40.0, abs=3 * force.std)


def test_pulls_cancel_against_the_prior_at_the_best_fit():
    model = fitted(20.0)
    model = replace(model, start=model.cart.parameters)
    ((each),) = (one.there for one in pulls(model))
    std = np.append(
        np.sqrt(np.diagonal(model.identification.covariance))[model.free[:-1]], model.regressions[0].usual_delay[1]
    )
    assert std * (each.sum(axis=1) + model.base.pull) == pytest.approx(0.0, abs=0.1)
    assert (std * np.linalg.norm(each, axis=1) > 0.2).all()


@pytest.mark.parametrize("began", [0.0, 1.7e9])
def test_a_push_is_found_whatever_the_clock(began):
    log = pushed(20.0)
    log = replace(log, time=log.time + began)
    model = Fitted((WrenchRegression(log, CART, None),), CART)
    (found,) = findings(model.dictionary([ExternalPush()]), model.loose)
    assert found.log_factor > 50
    assert found.effect.start == pytest.approx(began + START, abs=0.25)


@pytest.mark.parametrize("grows", [False, True])
def test_an_offset_that_grows_drifts(grows):
    """It is nothing at first, and twice its mean in the end; a quarter of the log has a quarter of that at most."""
    log = pushed(0.0)
    ((name, arm),) = log.arms.items()
    wrench = arm.wrench.copy()
    wrench[:, 0] += 6.0 * (2 * log.time / log.time[-1] if grows else 1.0)
    biased = replace(log, arms={name: ArmLog(arm.contact, wrench)})
    model = Fitted((WrenchRegression(biased, CART, None),), CART)
    (found,) = findings(model.dictionary([ForceBias()]), model.loose)
    assert found.log_factor > 50
    assert found.drift > 0.5 if grows else found.drift < 0.15


def test_what_is_hardly_surer_than_nothing_is_left_out():
    """Of a push that is there and an offset that is not; an offset as large as its noise allows says how sure it is."""
    sure, removed = proven(replace(fitted(20.0), added=(*fitted(20.0).added, ForceBias())))
    assert removed == ("force_bias",)
    assert [effect.name for effect in sure.fitted.added] == ["external_push"]
    assert sure.deviations["external_push"] > 5
    ((name, arm),) = (log := pushed(0.0)).arms.items()
    biased = replace(log, arms={name: ArmLog(arm.contact, arm.wrench + 3.0 * np.eye(6)[0])})
    kept, removed = proven(Fitted((WrenchRegression(biased, CART, None),), CART, (ForceBias(),)))
    assert removed == ()
    offset = kept.parameters["force_bias.fx"]
    assert kept.deviations["force_bias"] >= 0.99 * offset.value / offset.std


def test_where_a_load_lies_says_nothing_of_whether_it_is_there():
    log, load = pushed(0.0), PayloadChange(time=5.0, mass=0.5, x=0.9, y=0.5)
    known = certain(Fitted((WrenchRegression(log, CART, None),), CART, (load,)))
    mass = known.parameters["payload_change.mass"]
    assert known.deviations["payload_change"] == pytest.approx(abs(mass.value) / mass.std)


def test_a_direction_with_misfit_is_believed_less():
    log = pushed(0.0)
    ((name, arm),) = log.arms.items()
    wrench = arm.wrench.copy()
    wrench[:, 5] += 2.0 * np.sin(5.0 * log.time)
    twisted = replace(log, arms={name: ArmLog(arm.contact, wrench)})
    plain, odd = (balanced(Fitted((WrenchRegression(one, CART, None),), CART)) for one in (log, twisted))
    ratio = [np.diagonal(f.regressions[0].wrench_covariance[100]) for f in (plain, odd)]
    forward, yaw = ratio[1] / ratio[0]
    assert yaw > 3.0
    assert forward < 2.0
