"""Public classes and functions say what they are; the examples in their docstrings run and print what they say."""

from __future__ import annotations

import doctest
import inspect
from importlib import import_module

import pytest

from .given import put_files

PACKAGES = ("cartgrasp", "cartgrasp.effects", "cartgrasp.simulation", "estimation", "planning")
PUBLIC = {
    f"{name}.{one}": getattr(import_module(name), one) for name in PACKAGES for one in import_module(name).__all__
}
CALLED = {name: one for name, one in PUBLIC.items() if callable(one)}
WITH_EXAMPLE = [
    "cartgrasp.Arm",
    "cartgrasp.CartModel",
    "cartgrasp.Measurement",
    "cartgrasp.RunLog",
    "cartgrasp.SoftFinger",
    "cartgrasp.load_cart",
    "cartgrasp.read_log",
    "cartgrasp.simulation.ModelPlant",
    "cartgrasp.simulation.Sensors",
    "estimation.CartFilter",
    "estimation.DisturbedFilter",
    "estimation.FilterNoise",
    "estimation.Prior",
    "estimation.diagnose",
    "estimation.identify",
    "planning.Controller",
    "planning.PathReference",
    "planning.RegraspTimes",
    "planning.WrenchPlanner",
]


@pytest.mark.parametrize("name", CALLED)
def test_it_says_what_it_is(name):
    """A dataclass without a docstring of its own would have its signature for one."""
    one = CALLED[name]
    assert one.__doc__
    assert not one.__doc__.startswith(f"{one.__name__}(")


def test_those_with_an_example():
    """None loses its example unseen."""
    assert [name for name in sorted(CALLED) if ">>>" in (CALLED[name].__doc__ or "")] == sorted(WITH_EXAMPLE)


@pytest.mark.parametrize("name", WITH_EXAMPLE)
def test_its_example_runs_and_its_arguments_are_told(name, tmp_path, monkeypatch):
    put_files(tmp_path)
    monkeypatch.chdir(tmp_path)
    one, told = CALLED[name], []
    (test,) = doctest.DocTestFinder(recurse=False).find(one, name, globs={})
    doctest.DocTestRunner().run(test, out=told.append)
    assert not told, "".join(told)
    for argument in inspect.signature(one).parameters:
        assert f"\n    {argument}: " in inspect.getdoc(one), argument
