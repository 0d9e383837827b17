"""A file in a folder of objectives is all that it takes for a key of problem files."""

import math
from importlib import import_module, invalidate_caches

import pytest
from pydantic import ValidationError

from planning import limits, objectives
from planning.limits import CartLimit, InternalForce, Pull, SideForce, Skid, TipOver
from planning.objectives import Lexicographic, Nothing, Smoothness, WeightedWrench, WorstArm
from planning.objectives.objective import Addition
from planning.problem.class_entries import classes_in, entry_of
from planning.problem.problem_schema import ARM_LIMITS

HEAVY = """
from collections.abc import Mapping
from dataclasses import dataclass, field

from planning.objectives.objective import ABOVE_ZERO, Addition, Objective, WeightedWrench


@dataclass(frozen=True)
class QuiteHeavy(Addition):
    least: float = field(metadata=ABOVE_ZERO)
    weight: float = 2.0
    axis: tuple[float, float, float] = (0.0, 1.0, 0.0)
    shares: Mapping[str, float] = field(default_factory=dict)
    base: Objective = field(default_factory=WeightedWrench)

    def cost(self, arms, previous):
        return self.base.cost(arms, previous)
"""


@pytest.fixture
def heavy(tmp_path, monkeypatch):
    (tmp_path / "quite_heavy.py").write_text(HEAVY)
    monkeypatch.setattr(objectives, "__path__", [*objectives.__path__, str(tmp_path)])
    invalidate_caches()
    return import_module("planning.objectives.quite_heavy").QuiteHeavy


def test_what_stands_in_a_folder_has_its_key(heavy):
    found = classes_in(objectives, Addition)
    assert found["quite_heavy"] is heavy
    assert (found["smoothness"], found["worst_arm"]) == (Smoothness, WorstArm)
    assert not {Lexicographic, Nothing, WeightedWrench, Addition} & set(found.values())
    kinds = {"internal_force": InternalForce, "side_force": SideForce, "skid": Skid, "tip_over": TipOver}
    assert classes_in(limits, CartLimit) == kinds, "a new limit of the cart stands in kinds, too"
    assert set(ARM_LIMITS.items()) == {("pull", Pull)}, "and one of an arm here"


def test_its_fields_are_keys_with_what_they_may_be(heavy):
    entry = entry_of("Entry", {"quite_heavy": heavy})
    told = entry.model_validate({"quite_heavy": {"least": 1.0, "axis": [1.0, 0.0, 0.0]}}).quite_heavy
    assert dict(told) == {"least": 1.0, "weight": 2.0, "axis": [1.0, 0.0, 0.0], "shares": {}}
    assert entry.model_validate({}).quite_heavy is None
    for wrong, why in (
        ({}, "least"),
        ({"least": 0.0}, "not > 0"),
        ({"least": 1.0, "weight": -1.0}, "negative"),
        ({"least": 1.0, "weight": math.inf}, "finite"),
        ({"least": 1.0, "axis": [1.0]}, "at least 3"),
        ({"least": 1.0, "shares": {"left": "much"}}, "number"),
        ({"least": 1.0, "base": None}, "base"),
    ):
        with pytest.raises(ValidationError, match=why):
            entry.model_validate({"quite_heavy": wrong})
