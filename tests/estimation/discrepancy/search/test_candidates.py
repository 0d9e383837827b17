"""Candidates from outside: effects of one's own, and laws, in the same comparison and in rollouts."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pytest

from cartgrasp.effects import ForceEffect, LearnedForce, ViscousDrag
from cartgrasp.effects.effect import Contribution, Parameter
from cartgrasp.errors import UsageError
from cartgrasp.model import CartModel
from estimation.discrepancy import diagnose
from estimation.discrepancy.findings.forced_motion import ForcedMotion
from estimation.discrepancy.findings.rollouts import rolled_out, starts
from estimation.discrepancy.search.gains import every_family
from estimation.discrepancy.search.model import Model
from estimation.weak_form.balances import Balances

from ...runs import simulate
from .test_laws import CART, TRUTH, resisted


@dataclass(frozen=True, kw_only=True)
class Bent(ForceEffect):
    """Drag `strength` u / (1 + (u / `at`)²), by default a straight one."""

    strength: float = 0.0
    at: float = 0.3

    name: ClassVar[str] = "bent_drag"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("strength", "N·s/m", typical=10.0, lower=0.0),
        Parameter("at", "m/s", typical=0.3, lower=0.01, estimated=False, grid=(0.3,)),
    )

    def wrench_b(self, situation, memory, parameters):
        u, strength, at = situation.velocity_b[..., 0], parameters[..., 0], parameters[..., 1]
        bent = 1 + (u / at) ** 2
        value = np.zeros((*np.broadcast_shapes(u.shape, strength.shape), 3))
        by_velocity, by_parameters = np.zeros((*value.shape, 3)), np.zeros((*value.shape, 2))
        value[..., 0], by_parameters[..., 0, 0] = -strength * u / bent, -u / bent
        by_velocity[..., 0, 0] = -strength * (2 - bent) / bent**2
        by_parameters[..., 0, 1] = -strength * 2 * u**3 / (at**3 * bent**2)
        return Contribution(value, by_velocity=by_velocity, by_parameters=by_parameters)


def braked(time, truth):
    return 80.0 * truth[:, 3] / (1 + (truth[:, 3] / 0.3) ** 2)


@pytest.mark.prove
def test_an_effect_of_ones_own_is_named_where_it_explains():
    found = diagnose(resisted(braked, 3, 40.0), CART, candidates=[Bent()])
    assert [effect.name for effect in found.effects] == ["bent_drag"]
    told = {name: value for name, (value, _, _) in found.effects[0].parameters.items()}
    speed = np.array([0.3, 0.5, 0.8])
    drag = told["strength"] * speed / (1 + (speed / told["at"]) ** 2)
    assert drag == pytest.approx(80.0 * speed / (1 + (speed / 0.3) ** 2), rel=0.2)
    assert found.gap.after < 0.6 * found.gap.refitted


@pytest.mark.long
def test_where_nothing_is_missing_it_is_not_told():
    found = diagnose(resisted(lambda time, truth: 0.0, 3, 30.0), CART, candidates=[Bent()])
    assert not found.effects
    assert "bent_drag" in {one.key for one in found.steps[0].attempts}


@pytest.mark.prove
def test_a_law_may_be_proposed():
    """A force with a period that is longer than any that a scan tries."""

    def force(time, truth):
        return 3.0 * np.sin(2 * np.pi * time / 5.5)

    law = LearnedForce("forward_force", "time", period=5.5)
    found = diagnose(resisted(force, 3, 60.0), CART, candidates=[law])
    (effect,) = found.effects
    assert effect.as_dict()["law"]["period"]["value"] == pytest.approx(5.5, rel=0.01)
    assert effect.law.size == pytest.approx(3.0 / 2**0.5, rel=0.2)


def test_one_that_the_cart_has_already_is_refused():
    log, _ = simulate(TRUTH, 3, 12.0)
    with pytest.raises(UsageError, match="viscous_drag already"):
        diagnose(log, CART, candidates=[ViscousDrag(linear=1.0)])


def test_rollouts_have_effects_without_a_kernel():
    """A straight drag of one's own, and the library's."""
    log, _ = simulate(TRUTH, 3, 12.0)
    bare = CartModel(CART.inertia)
    balances = Balances.of(log, bare)
    first = starts(balances)
    carts = [bare.with_effect(effect) for effect in (Bent(strength=6.0, at=1e6), ViscousDrag(linear=6.0))]
    starts_of = [ForcedMotion.of(balances, cart) for cart in carts]
    own, ours = (rolled_out(balances, cart, first, starts_of[0]) for cart in carts)
    np.testing.assert_allclose(own, ours, atol=1e-6)
    np.testing.assert_allclose(starts_of[0].velocity, starts_of[1].velocity, atol=1e-4)


def test_every_candidate_beside_a_log_in_which_nobody_pushes_has_columns():
    """A turned frame, too, which would turn the hands' wrenches where there were any."""
    log = replace(resisted(braked, 3, 12.0), arms={})
    model = Model.started([Balances.of(log, CART)], CART)
    for family in every_family(model):
        for effect in family.variants[:2]:
            columns, std = model.columns_of(effect)
            assert np.isfinite(columns).all(), effect.key
            assert columns.shape[2] == len(std)
    assert "pose_offset" in {family.key for family in every_family(model)}
