"""How names are told."""

from estimation.discrepancy.findings.named import NamedEffect, words_of


def test_the_same_effect_of_another_arm_is_told_as_such():
    one = NamedEffect("force_bias", "left", 0.7, {"fx": (1.9, 0.1, "N")}, ("force_bias", "floor_slope"), 0.8)
    assert one.alike == ["that of another arm than left", "floor_slope"]
    assert words_of([one]) == (
        "force_bias left (fx 1.9 N, or that of another arm than left or floor_slope: these logs can't tell)"
    )
