"""After `warm_up` the collector of garbage has next to nothing to look at, whichever part was asked."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
COUNTED = """
import gc
import cartgrasp as cg
from estimation import CartFilter
from planning import Controller, PathReference, WrenchPlanner, chain, speed_change
cart = cg.CartModel(cg.Inertia(24.0, (0.3, 0.0), 2.0))
hand = cg.Arm("hand", [(-0.25, 0.0, 1.0)])
path = PathReference(chain(speed_change(0.3), speed_change(-0.3)))
{made}.warm_up()
print(gc.get_freeze_count(), len(gc.get_objects()))
"""


@pytest.mark.some(1)
@pytest.mark.parametrize("made", ["WrenchPlanner(cart, [hand])", "CartFilter(cart)", "Controller(cart, [hand], path)"])
def test_what_lives_is_frozen(made):
    script, environment = COUNTED.format(made=made), {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True, env=environment)
    frozen, left = map(int, done.stdout.split())
    assert frozen > 20_000
    assert left < 2_000
