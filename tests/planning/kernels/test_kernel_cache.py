"""Compiled code is found again by the next process, and never after a source has changed."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from cartgrasp.compiling import digest
from planning.kernels import jit

ROOT = Path(__file__).parents[3]


def test_any_change_of_a_source_changes_the_name():
    sources = [b"a = 1\n", b"b = 2\n"]
    assert digest(sources) == digest(list(sources))
    assert digest(sources) != digest([b"a = 1\n", b"b = 3\n"])


def test_the_cached_kernels_carry_the_digest():
    from planning.kernels.allocation import allocate

    assert allocate.py_func.__qualname__ == f"allocate_{jit.DIGEST}"


def test_importing_planning_imports_no_kernel():
    code = "import sys, planning; print([m for m in sys.modules if m == 'numba' or m.startswith('planning.kernels')])"
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, env=environment)
    assert done.stdout.strip() == "[]"
