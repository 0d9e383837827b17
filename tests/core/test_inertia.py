"""phi, the CoM and the inertia about it; what is physical; wheel loads."""

from __future__ import annotations

from contextlib import nullcontext

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.optimize import nnls

from cartgrasp.errors import UsageError
from cartgrasp.first_guess import FirstGuess
from cartgrasp.inertia import Inertia, phi_from_physical, physical_from_phi, physical_jacobian
from cartgrasp.wheels import GRAVITY, Wheel, WheelSet

from .differences import assert_partials
from .drawn import WHEELS, inertias, numbers, phis, vectors


@given(inertia=inertias())
def test_phi_round_trip(inertia):
    again = Inertia.from_phi(inertia.phi)
    np.testing.assert_allclose([again.mass, *again.com], [inertia.mass, *inertia.com], rtol=1e-14, atol=1e-15)
    # the inertia about the CoM is a difference of J and m d², both up to 35 kg m²
    np.testing.assert_allclose(again.about_com, inertia.about_com, rtol=0, atol=1e-13)


@pytest.mark.parametrize("com", [[0.3, 0.1], np.array([0.3, 0.1])])
def test_a_body_is_its_numbers_however_they_come(com):
    body, same = Inertia(24.0, com, 2.0), Inertia(24.0, (0.3, 0.1), 2.0)
    assert body == same
    assert hash(body) == hash(same)


def test_deviations_may_stand_in_a_mapping():
    assert FirstGuess({"mass": 2.0}) == FirstGuess((("mass", 2.0),))


@given(phi=phis())
def test_jacobian_against_differences(phi):
    assert_partials(physical_jacobian(phi), physical_from_phi, phi)


def with_point_mass(inertia, mass, x, y):
    """At (x, y) in {b}; a negative one is taken off."""
    return Inertia.from_phi(inertia.phi + mass * np.array([1.0, x, y, x**2 + y**2]))


@given(mass=numbers(-5, 60), first=vectors(2, -20, 20), J=numbers(-5, 40))
def test_physical_is_a_positive_definite_pseudo_inertia(mass, first, J):
    phi = np.array([mass, *first, J])
    pseudo = np.array([[J, *first], [first[0], mass, 0], [first[1], 0, mass]])
    smallest = np.linalg.eigvalsh(pseudo)[0]
    assume(abs(smallest) > 1e-9)  # on the border rounding decides
    with nullcontext() if smallest > 0 else pytest.raises(UsageError, match="is not positive"):
        Inertia.from_phi(phi)


@given(phi=phis(), parts=st.lists(st.tuples(numbers(0, 10), numbers(-1, 1), numbers(-1, 1)), max_size=4))
def test_payloads_by_the_parallel_axis_theorem(phi, parts):
    """CoM of all the masses, and about it each body's own inertia plus m times the distance squared."""
    cart = Inertia.from_phi(phi)
    loaded = cart
    for mass, x, y in parts:
        loaded = with_point_mass(loaded, mass, x, y)
    masses = np.array([cart.mass, *(mass for mass, _, _ in parts)])
    places = np.array([cart.com, *((x, y) for _, x, y in parts)])
    com = masses @ places / masses.sum()
    about_com = cart.about_com + masses @ ((places - com) ** 2).sum(axis=1)
    expected = [masses.sum(), *com, about_com]
    np.testing.assert_allclose([loaded.mass, *loaded.com, loaded.about_com], expected, rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize(
    ("mass", "com", "about_com", "words"),
    [
        (0.0, (0, 0), 1.0, "mass: 0 kg is not positive"),
        (-1.0, (0, 0), 1.0, "mass: -1 kg is not positive"),
        (20.0, (0, 0), 0.0, "inertia: 0 kg m²"),
        (np.nan, (0, 0), 1.0, "mass: nan is not a number"),
        (20.0, (np.inf, 0), 1.0, "com: .* inf is not a number"),
    ],
)
def test_unphysical_inertia_is_refused(mass, com, about_com, words):
    with pytest.raises(UsageError, match=words):
        Inertia(mass, com, about_com)


def test_a_payload_that_was_not_there_cannot_be_taken_off():
    with pytest.raises(UsageError, match="inertia"):
        with_point_mass(Inertia(20.0, (0.3, 0.0), 2.0), -5.0, 2.0, 0.0)
    for phi in ([0.0, 0.0, 0.0, 1.0], [-2.0, 0.0, 0.0, 1.0]):
        with pytest.raises(UsageError, match="mass"):
            Inertia.from_phi(phi)


def test_phi_broadcasts():
    generator = np.random.default_rng(2)
    mass, com_x = generator.uniform(5, 60, (4, 1)), generator.uniform(-1, 1, (3,))
    phi = phi_from_physical(mass, com_x, 0.1, 2.0)
    assert phi.shape == (4, 3, 4)
    np.testing.assert_allclose(physical_from_phi(phi)[2, 1], [mass[2, 0], com_x[1], 0.1, 2.0])
    assert physical_jacobian(phi).shape == (4, 3, 4, 4)


@given(phi=phis(), wheels=st.sampled_from([w for w in WHEELS if w]))
def test_loads_balance_the_weight_and_its_moments(phi, wheels):
    """Also where a wheel lifts: least energy of unilateral springs, by another solver's road (NNLS)."""
    wheel_set = WheelSet(wheels)
    loads = wheel_set.loads(phi)
    m, mx, my, _ = phi
    assert loads.min() >= 0
    np.testing.assert_allclose(loads.sum(), m * GRAVITY, rtol=1e-12)
    balance = np.vstack([np.ones(len(wheels)), wheel_set.positions.T])
    weight = np.array([m, mx, my]) * GRAVITY
    stiff = 1e5  # equilibrium weighs 1e10 times the springs' energy
    rows, right = (
        np.vstack([stiff * balance, np.eye(len(wheels))]),
        np.append(stiff * weight, np.zeros(len(wheels))),
    )
    expected, _ = nnls(rows, right)
    assume(np.abs(balance @ expected - weight).max() < 1e-3)  # else the CoM is outside the wheels, and the cart tips
    # a CoM a hair outside is balanced by NNLS to the hair that was allowed for
    np.testing.assert_allclose(balance @ loads, weight, atol=2e-3)
    np.testing.assert_allclose(loads, expected, atol=1e-2)


@given(
    places=st.lists(st.tuples(numbers(-1, 1), numbers(-1, 1)), min_size=1, max_size=5, unique=True),
    phi=phis(),
    origin=vectors(2, -1, 1),
    in_line=st.booleans(),
)
def test_loads_do_not_depend_on_where_the_origin_is(places, phi, origin, in_line):
    """The same cart, told from another {b}: same weight, same loads. Two wheels carry it all too;
    what they can't balance, the hands on the handle do."""
    places = np.array(places) * ([1.0, 0.0] if in_line else [1.0, 1.0])
    spread = np.linalg.svd(places - places.mean(axis=0), compute_uv=False)
    assume(all(s == 0 or s > 0.05 for s in np.round(spread, 15)))
    m, mx, my, _ = phi
    moved_phi = np.array([m, mx - m * origin[0], my - m * origin[1], 1.0])
    here = WheelSet(tuple(Wheel("caster", *p) for p in places))
    there = WheelSet(tuple(Wheel("caster", *(p - origin)) for p in places))
    np.testing.assert_allclose(phi @ here.load_map.T, moved_phi @ there.load_map.T, rtol=1e-8, atol=1e-8)
    np.testing.assert_allclose((phi @ here.load_map.T).sum(), m * GRAVITY, rtol=1e-9)


def test_loads_broadcast_where_wheels_lift():
    wheels = WheelSet(WHEELS[1])
    com = np.array([[[0.3, 0.0], [0.1, 0.2]], [[0.6, 0.1], [-2.0, 0.3]]])
    phi = phi_from_physical(24.0, com[..., 0], com[..., 1], 2.0)
    loads, load_map = wheels.loads_with_map(phi)
    assert load_map.shape == (2, 2, 4, 4)
    np.testing.assert_allclose(loads.sum(axis=-1), 24.0 * GRAVITY)  # also of the last, which tips
    for i, j in np.ndindex(2, 2):
        one, one_map = wheels.loads_with_map(phi[i, j])
        np.testing.assert_allclose(loads[i, j], one, atol=1e-12)
        np.testing.assert_allclose(load_map[i, j], one_map, atol=1e-12)
    assert (loads[0, 1] == 0).sum() == 1
    assert not wheels.loads([-1.0, 0.0, 0.0, 1.0]).any()  # a filter's unphysical guess


def test_without_wheels_the_weight_is_at_the_origin():
    wheels = WheelSet.of((), rolls_along_x=True)
    np.testing.assert_allclose(wheels.loads(phi_from_physical(20.0, 0.3, 0.1, 2.0)), [20.0 * GRAVITY])
    assert not wheels.is_caster.any()
    assert WheelSet.of((), rolls_along_x=False).is_caster.all()


@pytest.mark.parametrize(
    ("values", "words"),
    [
        (("steered", 0.0, 0.0), "'steered' is neither 'fixed' nor 'caster'"),
        (("fixed", np.nan, 0.0), "x: nan is not a number"),
        (("caster", 0.0, 0.0, -0.1), "trail: -0.1 is not a number from 0"),
    ],
)
def test_wheels_that_cannot_be_are_refused(values, words):
    with pytest.raises(UsageError, match=words):
        Wheel(*values)
