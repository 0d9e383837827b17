"""Effects that look at where casters point: one heading for all of them, whoever says how it turns."""

from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cartgrasp.constraints import RollingConstraints
from cartgrasp.effects import CasterRealignment, FloorPatch, RollingResistance, StribeckFriction
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from cartgrasp.wheels import Wheel
from tests.core.drawn import HOSPITAL_BED, SHOPPING_CART, numbers, vectors, velocities

BODY = Inertia(24.0, (0.36, 0.05), 2.0)
PUSH = np.array([10.0, 2.0, 1.0])
AT_WHEELS = RollingResistance(0.02), StribeckFriction(5.0, 0.1, 0.5), FloorPatch(-9.0, 9.0, -9.0, 9.0, 0.03)
SWIVEL = CasterRealignment(0.3)


def bed(*effects, wheels=HOSPITAL_BED):
    return CartModel(BODY, RollingConstraints(None), effects, wheels)


@pytest.mark.parametrize(
    "effects", list(permutations((*AT_WHEELS[:2], SWIVEL))), ids=lambda e: "+".join(x.name for x in e)
)
@given(data=st.data())
def test_effects_share_the_headings_and_each_does_what_it_does_alone(effects, data):
    cart, headings = bed(*effects), data.draw(vectors(4, -3, 3))
    velocity = data.draw(velocities())
    assert cart.memory_names == tuple(f"caster{i}.heading" for i in (1, 2, 3, 4))
    state = np.concatenate([np.zeros(3), velocity, headings])
    alone = sum(bed(effect).effect_wrench(state) for effect in effects)
    np.testing.assert_allclose(cart.effect_wrench(state), alone, atol=1e-12)
    swivels = bed(SWIVEL).rate(state, PUSH).value[cart.memory_slice]
    np.testing.assert_allclose(cart.rate(state, PUSH).value[cart.memory_slice], swivels, atol=1e-12)


@pytest.mark.parametrize("effect", AT_WHEELS, ids=lambda e: e.name)
@given(headings=vectors(4, -3, 3), velocity=velocities())
def test_without_a_swivel_torque_the_headings_turn_as_with_one(effect, headings, velocity):
    state = np.concatenate([np.zeros(3), velocity, headings])
    one, other = (bed(e).rate(state, np.zeros(3)) for e in (effect, SWIVEL))
    memory = bed(effect).memory_slice
    np.testing.assert_allclose(one.value[memory], other.value[memory], atol=1e-12)
    np.testing.assert_allclose(one.by_state[memory], other.by_state[memory], atol=1e-12)


def test_who_says_how_headings_turn():
    """A trail that `caster_realignment` gives stands for the listed ones, for all effects; its place in the list does
    not matter."""
    own = CasterRealignment(0.3, trail=0.1)
    listed = tuple(Wheel("caster", w.x, w.y, 0.1) for w in HOSPITAL_BED)
    state = np.concatenate([np.zeros(3), [0.5, 0.1, 0.3], [0.1, 1.0, -2.0, 3.0]])
    wanted = bed(RollingResistance(0.02), SWIVEL, wheels=listed).rate(state, PUSH).value
    for effects in ((RollingResistance(0.02), own), (own, RollingResistance(0.02))):
        np.testing.assert_allclose(bed(*effects).rate(state, PUSH).value, wanted, atol=1e-12)


@pytest.mark.parametrize("wheels", [(), SHOPPING_CART[:2]], ids=["none listed", "fixed ones"])
def test_carts_that_list_no_casters_have_no_headings(wheels):
    cart = CartModel(BODY, effects=AT_WHEELS, wheels=wheels)
    assert cart.memory_names == ()
    assert cart.with_effect(SWIVEL).memory_names == ("caster_realignment.heading",)


@given(coefficient=numbers(0.001, 0.1), heading=numbers(-3, 3), speed=numbers(0.3, 2), way=numbers(-3, 3))
def test_a_caster_drags_by_its_load_along_its_heading(coefficient, heading, speed, way):
    """Not along the motion of its pivot: across its heading a wheel gives nothing that is rolling."""
    cart = CartModel(
        Inertia(24.0, (0.4, 0.0), 2.0), RollingConstraints(None), (RollingResistance(coefficient),),
        (Wheel("caster", 0.4, 0.0, 0.05),),
    )  # fmt: skip
    state = cart.state(velocity=[speed * np.cos(way), speed * np.sin(way), 0.0])
    assert state[-1] == 0.0
    state[-1] = heading
    along = np.array([np.cos(heading), np.sin(heading)])
    rolled = speed * np.cos(way - heading)
    size = coefficient * 24.0 * 9.81 * rolled / np.hypot(rolled, 0.002)
    np.testing.assert_allclose(cart.effect_wrench(state), -size * np.r_[along, 0.4 * along[1]], atol=1e-9)


def test_what_is_remembered_depends_on_trails_and_laws_and_no_sizes():
    cart = bed(RollingResistance(0.02), SWIVEL)
    assert cart.memory_key == cart.with_parameters(cart.parameters * 1.1).memory_key
    other = bed(RollingResistance(0.02), CasterRealignment(0.3, trail=0.1))
    shorter = bed(RollingResistance(0.02), wheels=HOSPITAL_BED[:3])
    assert len({cart.memory_key, other.memory_key, shorter.memory_key}) == 3
