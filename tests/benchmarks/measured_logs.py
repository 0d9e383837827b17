"""Made logs for the tests of the measured ones, by closed forms, and where the measured ones are."""

from pathlib import Path

import numpy as np
import pytest

from cartgrasp.logs import ArmLog, RunLog

DATA = Path(__file__).parents[3] / "shared" / "data"
needs_data = pytest.mark.skipif(not DATA.is_dir(), reason=f"the measured logs are not at {DATA}")


def parabola(time, x=(0.1, 0.4, -0.2), y=(0.0, -0.3, 0.1), theta=(3.0, 0.5, 0.05), velocity=True):
    """A log of one arm whose pose is a parabola in time, and whose wrench is a straight line; angles wrap."""
    pose = np.column_stack([np.polyval(c[::-1], time) for c in (x, y, theta)])
    pose[:, 2] = np.angle(np.exp(1j * pose[:, 2]))
    wrench = np.outer(1 + time, [10.0, -2.0, 0.0, 0.0, 0.0, 0.5])
    rates = np.column_stack([c[1] + 2 * c[2] * time for c in (x, y, theta)])
    arms = {"left": ArmLog(np.tile([-0.2, 0.1, 1.0], (len(time), 1)), wrench)}
    return RunLog(np.asarray(time, dtype=float), pose, rates if velocity else None, arms, "a parabola")


def pushed_on_a_rail(mass=20.0, drag=3.0, coulomb=4.0, duration=12.0, noise=1e-4):
    """A log at 100 Hz: x = (1 - cos w t) / 2 with the force that it takes, pushed and pulled by one arm."""
    time, w = np.arange(0.0, duration, 0.01), 2 * np.pi / 3.0
    x, u, a = (1 - np.cos(w * time)) / 2, w * np.sin(w * time) / 2, w**2 * np.cos(w * time) / 2
    random, zero = np.random.default_rng(1), np.zeros_like(time)
    force = mass * a + drag * u + coulomb * np.tanh(u / 0.002) + 0.2 * random.standard_normal(len(time))
    pose = np.column_stack([x + noise * random.standard_normal(len(time)), zero, zero])
    arms = {"drive": ArmLog(np.zeros((len(time), 3)), np.column_stack([force, *[zero] * 5]))}
    return RunLog(time, pose, None, arms, "made")
