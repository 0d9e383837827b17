"""Bands: a share of the acceleration that no force made opens the bracket of the mass, and narrows the band."""

from dataclasses import replace

import numpy as np
import pytest

from estimation.weak_form.balances import Balances
from estimation.weak_form.band import ROW_STEPS, Band, bands, consistent
from estimation.weak_form.motion import GRID_STEP, KNOT_STEPS

from .motions import RAIL, RAIL_MASS, on_rail

ROOM = 0.03
"""Of the mass: what the sensors' noise moves the ends of a bracket by, in all seeds here."""


def bands_of(log):
    return bands(Balances.of(log, RAIL), RAIL)


@pytest.mark.parametrize("seed", range(3))
def test_a_sound_log_keeps_the_widest_band(seed):
    known = bands_of(on_rail(seed=seed))
    assert consistent(known) == known[0]
    assert known[0].row_step == pytest.approx(min(step for step in ROW_STEPS if step >= 2 * KNOT_STEPS * GRID_STEP))
    assert known[0].mass == pytest.approx(RAIL_MASS, rel=0.01)
    assert known[0].bracket < 0.01 * RAIL_MASS


@pytest.mark.parametrize("seed", range(3))
def test_motion_that_no_force_made_narrows_the_band(seed):
    """In the widest band the mass comes out too small; the bracket's other end is beyond the truth."""
    known = bands_of(on_rail(share=0.012, seed=seed))
    assert known[0].mass < 0.9 * RAIL_MASS
    assert known[0].bracket > 0.08 * known[0].mass
    for band in known:
        assert band.mass - ROOM * RAIL_MASS < RAIL_MASS < band.mass + 2 * band.bracket + ROOM * RAIL_MASS
    taken = consistent(known)
    assert taken.row_step > 0.15
    assert taken.mass == pytest.approx(RAIL_MASS, rel=0.05)


def test_the_bracket_ends_where_acceleration_is_regressed_on_force():
    """Two lines of one cloud, by hand, with what drag and the other effects explain taken out of both."""
    log = on_rail(share=0.006)
    balances = Balances.of(log, RAIL)
    (band, *_) = bands(balances, RAIL)
    left, slopes = balances.residual(RAIL)
    others = [slopes[:, 0, 4:5]]
    speed = balances.motion.velocity[:, 0]
    others += [balances.integrated(column)[:, None] for column in (np.ones_like(speed), speed**2)]
    basis = np.linalg.qr(np.column_stack(others))[0]
    taken = [signal - basis @ (basis.T @ signal) for signal in (slopes[:, 0, 0], left[:, 0])]
    x, y = taken[0], taken[1] + RAIL_MASS * taken[0]
    assert band.mass == pytest.approx(x @ y / (x @ x), rel=2e-3)
    assert band.mass + 2 * band.bracket == pytest.approx(y @ y / (x @ y), rel=2e-2)


def test_the_widest_is_taken_whose_mass_all_narrower_ones_have():
    wide, middle, narrow = Band(0.1, 10.0, 0.1, 0.1), Band(0.2, 20.0, 0.1, 0.1), Band(0.4, 20.5, 0.5, 0.1)
    assert consistent([wide, middle, narrow]) == middle
    assert consistent([middle, narrow]) == middle
    assert consistent([Band(0.1, 20.0, 0.1, 5.0), narrow]) == narrow
    assert consistent([Band(0.1, 20.0, 0.1, 5.0)]) == Band(0.1, 20.0, 0.1, 5.0)
    assert consistent([]) is None


def test_a_cart_whose_file_has_no_effect_has_bands():
    """What drags is among the forces that say nothing about the mass."""
    bare = replace(RAIL, effects=())
    (widest, *_) = bands(Balances.of(on_rail(), bare), bare)
    assert abs(widest.mass - RAIL_MASS) < 3 * widest.deviation
