"""What a motion can show: against two columns whose angle is known."""

import numpy as np
import pytest

from cartgrasp.effects import FloorSlope, QuadraticDrag, RollingResistance
from estimation.discrepancy.dictionary import Dictionary, Trial
from estimation.discrepancy.evidence import Base
from estimation.discrepancy.isolability import isolability


def of(columns, effects, base):
    """One row a block; `columns` are unit traces, which amplitudes of usual size multiply."""
    sides = np.concatenate([base, columns, np.zeros((len(base), 1))], axis=1)
    gram = sides[:, :, None] * sides[:, None, :]
    p = base.shape[1]
    trials, at = [], p
    for effect, size in effects:
        trials.append(Trial(effect, np.arange(at, at + size), np.arange(size), np.full(size, 2.0)))
        at += size
    n = len(base)
    dictionary = Dictionary(tuple(trials), None, gram, np.empty((0, 0)), np.arange(n) * 0.25, np.zeros(n, dtype=int), p)
    return isolability(dictionary, Base(np.eye(p) * 1e-9, np.zeros(p)))


@pytest.mark.parametrize(("angle", "alike"), [(0.1, True), (1.2, False)])
def test_parallel_traces_are_alike(angle, alike):
    random = np.random.default_rng(0)
    first, other = np.linalg.qr(random.standard_normal((50, 2)))[0].T
    columns = 5 * np.column_stack([first, np.cos(angle) * first + np.sin(angle) * other])
    base = random.standard_normal((50, 1))
    base -= np.outer(np.outer(first, first) @ base + np.outer(other, other) @ base, [1.0])
    found = of(columns, [(RollingResistance(), 1), (QuadraticDrag(), 1)], base)
    assert (found["rolling_resistance"].alike == ("quadratic_drag",)) == alike
    assert found["rolling_resistance"].z == pytest.approx(5.0)
    assert found["rolling_resistance"].is_shown
    assert found["rolling_resistance"].likeness["quadratic_drag"] == pytest.approx(np.cos(angle))
    assert found["quadratic_drag"].likeness == {"rolling_resistance": pytest.approx(np.cos(angle))}


def test_what_the_base_explains_is_not_shown():
    random = np.random.default_rng(1)
    base = random.standard_normal((50, 2))
    columns = np.column_stack([base @ [0.3, -1.0], random.standard_normal(50)])
    found = of(columns, [(RollingResistance(), 1), (QuadraticDrag(), 1)], base)
    assert not found["rolling_resistance"].is_shown
    assert found["quadratic_drag"].is_shown


def test_an_effect_with_two_amplitudes_is_like_one_in_its_plane():
    random = np.random.default_rng(2)
    plane = 4 * random.standard_normal((50, 2))
    columns = np.column_stack([plane, plane @ [1.0, -0.5]])
    found = of(columns, [(FloorSlope(), 2), (RollingResistance(), 1)], random.standard_normal((50, 1)))
    assert found["rolling_resistance"].alike == ("floor_slope",)
