"""The peers are given a fair chance: partials against differences, and right answers where wrenches are exact."""

from dataclasses import replace

import numpy as np
import pytest

from cartgrasp.inertia import physical_from_phi
from cartgrasp.studies.consistency import PRIOR, drawn_cart, exact_noise
from cartgrasp.studies.estimators import HANDS, SENSOR_SETS, Job, drive_cart, guess

pytest.importorskip("filterpy")

from benchmarks.textbook_filters import TextbookEkf, TextbookUkf

ARMS = list(HANDS)


def test_partials():
    online = TextbookEkf(guess(), ARMS, exact_noise("usual"), PRIOR)
    online._wrench_b = np.array([9.0, 0.0, 1.5])
    x = np.concatenate([[0.3, -0.2, 0.7, 0.4, 0.3], online.start[online.n :]])
    F, H = online._partials(x, 0.001)[0], online._seen_partials(x)
    for i in range(len(x)):
        h = np.zeros(len(x))
        h[i] = 1e-5
        moved = (online._moved(x + h, 0.001) - online._moved(x - h, 0.001)) / 2e-5
        seen = (online._seen(x + h) - online._seen(x - h)) / 2e-5
        assert moved == pytest.approx(F[:, i], abs=1e-5)
        assert seen == pytest.approx(H[:, i], abs=1e-8)


@pytest.mark.parametrize("kind", [TextbookEkf, TextbookUkf])
def test_right_where_wrenches_are_nearly_exact(kind, monkeypatch):
    """A textbook's assumption; 3 N of noise is what it can't stand (physics.md)."""
    monkeypatch.setitem(SENSOR_SETS, "exact", replace(SENSOR_SETS["quiet"], force=0.02, moment=0.001))
    cart = drawn_cart(1)
    log = drive_cart(cart, Job("curves", "exact", 1), 4.0).log
    online = kind(guess(), ARMS, exact_noise("exact"), PRIOR)
    for measurement in log.measurements():
        online.update(measurement)
    assert not online.diverged
    mass, x, y, _ = physical_from_phi(online.phi.mean)
    assert mass == pytest.approx(cart.inertia.mass, rel=0.03)
    assert [x, y] == pytest.approx(cart.inertia.com, abs=0.02)
