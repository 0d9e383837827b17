"""Whether noise of headings passes for an axle that is elsewhere, and turns tell where it is."""

import numpy as np
import pytest

from estimation.online.axle_monitor import AxleMonitor

BLOCKS, WAY = 40, 0.12


def watched(seed, off=0.0, turning=0.0, noise=1e-4):
    """Blocks of a cart that goes on and turns back and forth, by headings with noise; slips are of its axle, `off` (m)
    from where the file has it. Returns what is suspected on the way."""
    random = np.random.default_rng(seed)
    true = turning * np.sin(0.3 * np.arange(BLOCKS + 1))
    heading = true + noise * random.standard_normal(BLOCKS + 1)
    watch, found = AxleMonitor(), []
    for k in range(BLOCKS):
        turn = heading[k + 1] - heading[k]
        wrong = (heading[k] + heading[k + 1] - true[k] - true[k + 1]) / 2
        slip = -off * (true[k + 1] - true[k]) - WAY * wrong + 2e-4 * random.standard_normal()
        watch = watch.and_then(turn, slip, WAY**2)
        found.append(watch.suspicion(0.0, 0.5))
    return found


def test_what_goes_straight_tells_of_no_axle():
    for seed in range(300):
        assert not any(watched(seed)), seed


@pytest.mark.parametrize("off", [-0.3, 0.15])
def test_what_turns_tells_where_it_is(off):
    for seed in range(30):
        last = watched(seed, off, turning=0.2)[-1]
        assert last is not None
        assert last.factor == pytest.approx(off, abs=0.02)
