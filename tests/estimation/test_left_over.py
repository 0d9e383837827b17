"""What a model leaves, in N and N·m, against a push that the test leaves out."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from cartgrasp.constraints import RollingConstraints
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from estimation.discrepancy.diagnosis import Diagnosis
from estimation.discrepancy.gap import Gap
from estimation.discrepancy.generic import Dependence
from estimation.discrepancy.left_over import beyond_noise, followed, missing_push
from estimation.discrepancy.polygon import Polygon
from estimation.discrepancy.scatter import Scatter
from estimation.discrepancy.selection import Attempt, Selection, Step

MASS, COM, ABOUT_COM = 20.0, (0.0, 0.1), 2.0


NODES = np.arange(400.0)
POLYGON = Polygon(NODES, np.zeros(400, dtype=int), np.zeros((400, 2)), (np.full((1, 400), 2.0), np.full((1, 400), 0.5)))
"""Of nodes that are known to 0.5 N and 2 N m, one apart from the other."""


def gap_of(forward, heading, after=0.1, floor=0.01):
    told = {"forward": (forward, 0.003), "sideways": (0.04, 0.002), "heading": (heading, 0.004)}
    each = {c: {"after": float(np.hypot(miss, noise)), "noise_floor": noise} for c, (miss, noise) in told.items()}
    return Gap(after, after, after, floor, each, {})


@pytest.mark.parametrize(("force", "moment"), [(8.0, 0.0), (0.0, 1.5)])
def test_a_constant_push_is_found_where_it_pushes(force, moment):
    """A body with its CoM to the left, from rest, for 1 s; the other coordinate takes what its lever gives."""
    matrix = np.array([[MASS, -MASS * COM[1]], [-MASS * COM[1], ABOUT_COM + MASS * COM[1] ** 2]])
    missed = np.abs(np.linalg.solve(matrix, [force, moment])) / 2
    found = missing_push(gap_of(*missed), CartModel(Inertia(MASS, COM, ABOUT_COM)))
    expected = np.hypot(*(matrix * 2 * missed).T)
    assert found == pytest.approx(expected)
    assert (found >= np.array([force, moment]) / np.sqrt(2)).all()


def test_on_a_rail_it_is_mass_times_acceleration():
    rail = CartModel(Inertia(MASS, (0.0, 0.0), ABOUT_COM), RollingConstraints(0.0, no_rotation=True))
    assert missing_push(gap_of(0.05, 0.0), rail) == pytest.approx([MASS * 0.1])


def test_what_noise_does_is_no_push():
    assert not missing_push(gap_of(0.05, 0.05, after=0.014), CartModel(Inertia(MASS, COM, ABOUT_COM))).any()


def diagnosis_of(left, gap):
    """One in which something like a slosh is there, and not proven; the residual is `left` times the noise."""
    alternating = np.sqrt(left) * np.where(np.arange(400) % 2, 1.0, -1.0)
    scatter = Scatter(np.tile(alternating[:, None], 2), np.tile(np.eye(2), (400, 1, 1)), np.arange(400), np.zeros(1), 1)
    cart = CartModel(Inertia(MASS, COM, ABOUT_COM))
    step = Step((Attempt("load_slosh", "load_slosh", 168.0, -22.0, "not proven", is_there=True),), None)
    selection = Selection(SimpleNamespace(), SimpleNamespace(polygon=POLYGON, scatter=scatter), (step,), None, (), {})
    return Diagnosis(cart, selection, (), (), (), (), gap, SimpleNamespace(cart=cart))


@pytest.mark.parametrize(
    ("left", "gap", "verdict"),
    [
        (0.5, gap_of(0.005, 0.005, after=0.009), "no_discrepancy"),
        (1.5, gap_of(0.005, 0.005, after=0.009), "unexplained"),
        (0.5, gap_of(0.1, 0.1), "unexplained"),
    ],
)
def test_what_is_called_unexplained_has_a_size(left, gap, verdict):
    found = diagnosis_of(left, gap)
    assert found.verdict == verdict
    assert all(size > 0 for size in found.unexplained["size"].values()) == (verdict == "unexplained")


def test_a_residual_beyond_its_noise():
    """A force of 3 N that comes and goes under noise of 1 N; the moment is less than the noise that is believed."""
    random, n = np.random.default_rng(1), 4000
    mean = random.standard_normal((n, 2)) * [1.0, 0.1] + np.outer(np.sign(np.sin(np.arange(n) / 7)), [3.0, 0.0])
    scatter = Scatter(mean, np.tile(np.diag([2.0, 50.0]), (n, 1, 1)), np.arange(n), np.zeros(n, dtype=int), 2.0)
    assert beyond_noise(scatter) == pytest.approx([3.0, 0.0], rel=0.03)


def test_what_follows_something_has_the_size_of_its_wave():
    value = np.column_stack([np.zeros(400), 3.0 * np.sin(2 * np.pi * NODES / 40)])
    heading = Dependence("heading", 1, None, "", 30.0, 1.0, 1.0)
    found = followed(replace(POLYGON, value=value), [replace(heading, share=0.25), heading])
    assert found == pytest.approx([0.0, 3.0 / np.sqrt(2)])
