"""The study of carts driven hard: what is drawn, the truth's limits on MuJoCo's own loads, and its figures by hand."""

from dataclasses import replace

import numpy as np
import pytest

from cartgrasp.contacts import ContactWrenches
from cartgrasp.studies.safety import (
    BLIND,
    CONFIDENT,
    ESTIMATED,
    MASS_RANGE,
    MIN_REST_LOAD_RATIO,
    MIN_WHEEL_LOAD,
    TRUTH_KNOWN,
    WAYS,
    Run,
    WatchedPlant,
    drawn,
    drive,
)
from cartgrasp.studies.safety_report import as_dict, claims, figure, findings


def test_carts_that_are_drawn():
    """They stand, and first guesses err as much as they say."""
    pairs = [drawn(seed) for seed in range(200)]
    assert all((t.wheel_set.loads(t.inertia.phi) > MIN_REST_LOAD_RATIO * MIN_WHEEL_LOAD).all() for t, _ in pairs)
    assert all(MASS_RANGE[0] <= truth.inertia.mass <= MASS_RANGE[1] for truth, _ in pairs)
    errors = [(g.inertia.com[1] - t.inertia.com[1]) / dict(g.first_guess.std)["com_y"] for t, g in pairs]
    assert 0.85 < np.std(errors) < 1.1


def test_its_room_is_that_of_mujoco():
    """A steady push: the least load by the model is that of MuJoCo, whose casters stand 45 mm behind their pivots."""
    truth = drawn(0)[0]
    plant = WatchedPlant(truth)
    push = ContactWrenches({"left": np.array([20.0, 0, 0, 0, 0, 0])}, {"left": [-0.25, 0.2, 1.0]})
    for _ in range(20):
        plant.step(push, 0.01)
    weight = 9.81 * truth.inertia.mass
    assert abs(plant.room[-1] + MIN_WHEEL_LOAD - np.mean(plant.loads[10:])) < 0.05 * weight


def test_a_cart_that_falls():
    """Without limits, in its bend; it broke a true limit long before, and never arrives."""
    run = drive(101, BLIND)
    assert run.fell
    assert run.violates
    assert run.arrived == np.inf
    first = int(np.argmax(run.room < -1.0))
    assert 100 < first < len(run.room) - 20
    assert len(run.room) - len(run.loads) == 1, "it fell in its last tick"


def test_its_figures():
    good = Run(0, CONFIDENT, np.array([3.0, 0.0]), np.array([9.0, 8.0]), 100.0, 4.5, fell=False)
    bad = replace(good, seed=1, room=np.array([3.0, -2.0]), loads=np.array([9.0, 0.0]), arrived=np.inf, fell=True)
    runs = [replace(good, way=way) for way in WAYS] + [
        replace(good if way == CONFIDENT else bad, way=way) for way in WAYS
    ]
    rows = {row[0]: row[1:] for row in findings(runs).sections[0].rows}
    assert rows[BLIND] == ("2", "1", "1", "2.0", "1", "100", "1.00", "1", "+0.00")
    assert rows[CONFIDENT][:3] == ("2", "0", "0")
    assert [claim.holds for claim in claims(runs)] == [True] * 5
    told = as_dict(bad)
    assert (told["room"], told["least_load"], told["arrived"], told["violates"]) == (-2.0, 0.0, np.inf, True)
    assert len(figure(runs).axes) == 2
    assert {ESTIMATED, TRUTH_KNOWN} < set(rows)


@pytest.mark.prove
def test_margins_hold():
    runs = [drive(seed, CONFIDENT) for seed in range(300, 310)]
    assert not any(run.violates for run in runs)
