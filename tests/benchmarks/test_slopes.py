"""The benchmark of slopes that nobody told of: a small one."""

import numpy as np
import pytest

from benchmarks.slopes import HEADER, NAMES, driven, rows
from estimation import Prior


@pytest.mark.prove
def test_a_row_says_what_its_runs_did():
    first = next(rows([3], {"0.007": Prior()}, ["CartFilter"]))
    told = driven(3, 0.0, "curved", "CartFilter", Prior())[0]
    named = dict(zip(HEADER, first, strict=True))
    assert named["`ok`"] == "1 of 1"
    assert [float(named[name]) for name in NAMES] == np.abs(told.errors).round(2).tolist()
    assert named["mass ±"] == f"{100 * told.deviations[0]:.1f} %"
