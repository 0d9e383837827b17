"""A command's time, its first line and its longest silence."""

import os
import sys

import pytest

from benchmarks.fresh_clones import Run, table, timed

SLOW = "import time; time.sleep(0.2); print('first', flush=True); time.sleep(0.6); print('last', flush=True)"


def test_a_command_is_timed_by_its_lines(tmp_path):
    run = timed([sys.executable, "-S", "-c", SLOW], tmp_path, dict(os.environ))
    assert 0.2 < run.first_line < run.longest_silence < run.whole
    assert 0.6 < run.longest_silence < 2.0
    with pytest.raises(SystemExit, match="exit status 3"):
        timed([sys.executable, "-S", "-c", "raise SystemExit(3)"], tmp_path, dict(os.environ))


def test_the_table_has_medians():
    lines = table("make demo", [Run(3.0, 1.0, 2.0), Run(1.0, 1.0, 1.0), Run(2.0, 1.0, 1.5)], [Run(4.0, 2.0, 3.0)])
    assert "| whole | 2.0 | 4.0 | 0.50 |" in lines
