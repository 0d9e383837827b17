"""Weaker effects: next to nothing is nothing, and half an offset is half; the floors that are read off reports."""

import json

import numpy as np
import pytest

from benchmarks.sealed.cases import draw_case
from benchmarks.sealed.scenes import draw_scene, random_of
from benchmarks.sealed.score import floors, read
from benchmarks.sealed.sensors import noiseless
from benchmarks.sealed.weaker import weaker

NEXT_TO_NOTHING = 1e-7


def seen(scene):
    """Poses and recorded wrenches."""
    states, _, present, told = scene.run()
    return states[:, :6], noiseless(scene.sensors, scene.drive, present, told)


@pytest.mark.some(5)
@pytest.mark.parametrize(
    "case",
    [
        *("rolling_resistance", "stribeck_friction", "floor_slope", "caster_realignment", "wheel_misalignment"),
        *("payload_change", "load_slosh", "force_bias", "force_scale", "force_misalignment", "external_push"),
    ],
)
def test_next_to_nothing_of_an_effect_is_nothing(case):
    whole = draw_case(case, 3, "straight")
    none = draw_scene((case,), "straight", random_of(case, 3, "straight"))
    found, wanted = seen(weaker(whole, NEXT_TO_NOTHING)), seen(none)
    for one, other in zip(found, wanted, strict=True):
        assert np.abs(one - other).max() < 1e-4
    assert np.abs(seen(whole)[1] - wanted[1]).max() > 0.1


def test_half_an_offset_is_half():
    whole = draw_case("force_bias", 3, "straight")
    none = draw_scene(("force_bias",), "straight", random_of("force_bias", 3, "straight"))
    offsets = [seen(scene)[1] - seen(none)[1] for scene in (whole, weaker(whole, 0.5))]
    assert offsets[1] == pytest.approx(offsets[0] / 2, abs=1e-9)
    told = [scene.truths[0].parameters["fx"] for scene in (whole, weaker(whole, 0.5))]
    assert told[1] == told[0] / 2 == pytest.approx(offsets[1][0, 0, 0] or offsets[1][0, -1, 0])


def test_a_floor_is_the_smallest_size_from_which_on_it_is_named(tmp_path):
    (tmp_path / "truth").mkdir()
    named = {1.0: [True, True], 0.5: [True, True], 0.25: [True, False], 0.125: [True, True]}
    for share, group in named.items():
        for k, right in enumerate(group):
            name = f"{share:g}-{k}"
            effect = {"name": "floor_slope", "parameters": {}, "roughly": {}, "arm": "", "outside": False}
            truth = {"case": "floor_slope", "share": share, "effects": [effect]}
            (tmp_path / "truth" / f"{name}.json").write_text(json.dumps(truth))
            out = tmp_path / "logs" / name / "out"
            out.mkdir(parents=True)
            effects = [{"name": "floor_slope", "parameters": {}}] if right else []
            (out / "report.json").write_text(json.dumps({"verdict": "explained", "effects": effects}))
    found = [read(tmp_path, path, "out") for path in sorted((tmp_path / "truth").glob("*.json"))]
    (line,) = (line for line in floors(found).splitlines() if line.startswith("floor_slope"))
    assert line.split() == ["floor_slope", *["2", "of", "2", "2", "of", "2", "1", "of", "2", "2", "of", "2"], "0.5"]
