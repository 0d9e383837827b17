"""Kernels that only kernels call become machine code with their entries, once, and are found again."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numba import njit

from cartgrasp import compiling
from cartgrasp.compiling import JIT_OPTIONS, cached_as, digest_of, inner
from cartgrasp.kernel_compiler import EntryLibrary, InnerLibrary, _all_called

ROOT = Path(__file__).parents[2]


def compiled(function):
    return inner(function, JIT_OPTIONS)


@compiled
def squared(x):
    return x * x


@compiled
def added(values):
    total = 0.0
    for i in range(len(values)):
        total += squared(values[i])
    return total


def mean_square(values):
    return added(values) / len(values) + squared(0.0)


def libraries(kernel):
    return [result.library for result in kernel.overloads.values()]


def test_an_entry_holds_what_it_calls_and_nothing_else_is_finished():
    entry = njit(mean_square, pipeline_class=compiling.EntryCompiler, **JIT_OPTIONS)
    assert entry(np.array([1.0, 2.0, 3.0])) == pytest.approx(14.0 / 3.0, rel=1e-15)
    assert [type(library) for library in libraries(entry)] == [EntryLibrary]
    for kernel in (squared, added):
        assert libraries(kernel)
        for library in libraries(kernel):
            assert isinstance(library, InnerLibrary)
            assert not library._finalized


def test_numbas_own_functions_may_call_them():
    assert njit(lambda values: added(values) + squared(2.0))(np.array([3.0])) == 13.0


def test_python_may_not():
    njit(lambda x: squared(x))(2.0)
    with pytest.raises((TypeError, ValueError)):
        squared(2.0)


@given(st.lists(st.sets(st.integers(0, 7)), min_size=1, max_size=8), st.data())
def test_what_is_called_is_linked_after_all_that_call_it(calls, data):
    """LLVM leaves out what nothing asks for yet; `int_power` was missing from a cold start of one benchmark."""
    kernels = [InnerLibrary.__new__(InnerLibrary) for _ in calls]
    for place, (kernel, called) in enumerate(zip(kernels, calls, strict=True)):
        kernel._name = str(place)
        kernel._linking_libraries = [kernels[i] for i in called if i < place]
    chosen = data.draw(st.lists(st.sampled_from(kernels), unique_by=id))
    order = _all_called(chosen)
    assert len(set(order)) == len(order)
    assert set(chosen) <= set(order)
    for place, kernel in enumerate(order):
        assert set(kernel._linking_libraries) <= set(order[place + 1 :])


PROGRAM = """
import sys
sys.path.insert(0, sys.argv[1])
import kernels
print(kernels.entry(3.0), sum(kernels.entry.stats.cache_hits.values()))
"""
KERNELS = """
from cartgrasp.compiling import JIT_OPTIONS, cached_as, inner

def tripled(x):
    return 3.0 * x

tripled = inner(tripled, JIT_OPTIONS)

@cached_as("a", JIT_OPTIONS)
def entry(x):
    return tripled(x) + 1.0
"""


@pytest.mark.long
def test_another_process_finds_them_again(tmp_path):
    (tmp_path / "kernels.py").write_text(KERNELS)
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    command = [sys.executable, "-c", PROGRAM, str(tmp_path)]
    said = [subprocess.run(command, capture_output=True, text=True, check=True, env=environment) for _ in range(2)]
    assert [done.stdout.split() for done in said] == [["10.0", "0"], ["10.0", "1"]]


def test_the_digest_says_how_they_were_compiled(tmp_path, monkeypatch):
    (tmp_path / "a.py").write_text("x = 1\n")
    before = digest_of(tmp_path)
    assert digest_of(tmp_path) == before
    other = tmp_path / "compiler" / "kernel_compiler.py"
    other.parent.mkdir()
    other.write_text("passes = 2\n")
    monkeypatch.setattr(compiling.kernel_compiler, "__file__", str(other))
    assert digest_of(tmp_path) != before
    assert cached_as(before, JIT_OPTIONS)(mean_square).py_func.__qualname__ == f"mean_square_{before}"
