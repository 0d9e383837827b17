"""What the sealed generator writes: readable, repeatable, without a hint; and what it may not look at."""

from __future__ import annotations

import ast
import json
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest

from benchmarks.sealed.cases import CASES, PAIRS, draw_case
from benchmarks.sealed.effects import VOCABULARY
from benchmarks.sealed.generate import generate
from benchmarks.sealed.sizes import NOMINAL
from benchmarks.true_structures import effect_of
from cartgrasp import load_cart, read_log

PACKAGE = Path(__file__).parents[2] / "benchmarks" / "sealed"
ALLOWED = {
    *(
        "__future__",
        "argparse",
        "collections",
        "dataclasses",
        "functools",
        "hashlib",
        "io",
        "itertools",
        "json",
        "math",
        "pathlib",
        "sys",
        "time",
        "typing",
        "zlib",
    ),
    *("matplotlib", "mujoco", "numba", "numpy", "pysindy", "ruamel", "scipy"),
}
SOME = ("nothing", "floor_patch", "force_scale", "viscous_drag", "wind", "payload_change+floor_slope")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    out = tmp_path_factory.mktemp("sealed")
    generate(out, SOME, [3], "straight")
    return out


def test_rough_logs_have_other_names_and_can_be_read(tmp_path, folder):
    """Of the same carts."""
    names = generate(tmp_path, ("force_scale",), [3], "straight", is_rough=True)
    assert not (folder / "logs" / names[0]).exists()
    truth = json.loads((tmp_path / "truth" / f"{names[0]}.json").read_text())
    assert truth["settings"]["pose_noise"] >= 5e-4
    assert {"pose_correlation", "speed_correlation", "lost_rows", "poses_off"} <= set(truth["settings"])
    clean = [json.loads(path.read_text()) for path in (folder / "truth").glob("*.json")]
    assert truth["cart"] in [one["cart"] for one in clean if one["case"] == "force_scale"]
    assert len(read_log(tmp_path / "logs" / names[0] / "run.csv")) > 1000


def test_the_generator_imports_nothing_of_ours():
    for path in PACKAGE.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                roots = {alias.name.split(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                roots = {(node.module or "").split(".")[0]} if not node.level else set()
                assert node.level <= 1, f"{path.name}:{node.lineno} looks outside the package"
            else:
                continue
            assert roots <= ALLOWED, f"{path.name}:{node.lineno} imports {roots - ALLOWED}"


def test_every_effect_of_the_contract_has_a_case():
    names = (
        *("viscous_drag", "rolling_resistance", "stribeck_friction", "quadratic_drag", "directional_drag"),
        *("floor_slope", "floor_patch", "caster_realignment", "wheel_drag_imbalance", "wheel_misalignment"),
        *("lateral_slip", "payload_change", "load_slosh", "force_bias", "force_scale", "force_misalignment"),
        *("time_delay", "external_push"),
    )
    assert set(names) <= set(CASES)
    assert {part for pair in PAIRS for part in pair.split("+")} <= set(names)


def test_logs_and_carts_can_be_read(folder):
    truths = sorted((folder / "truth").glob("*.json"))
    assert len(truths) == len(SOME)
    for path in truths:
        truth, logs = json.loads(path.read_text()), folder / "logs" / path.stem
        log, cart = read_log(logs / "run.csv"), load_cart(logs / "cart.yaml")
        assert set(log.arms) == set(truth["settings"]["arms"])
        assert (log.velocity is None) == (truth["settings"]["speed_noise"] is None)
        assert 29.9 < log.duration < 30.1
        assert np.isfinite(log.table).all()
        true = truth["cart"]
        assert abs(cart.inertia.mass / true["mass"] - 1) <= NOMINAL["mass"] + 1e-3
        assert np.abs(np.subtract(cart.inertia.com, (true["com_x"], true["com_y"]))).max() <= NOMINAL["com"] + 1e-3
        assert len(cart.wheels) == 4
        assert [e.name for e in cart.effects] == ([] if truth["case"] == "viscous_drag" else ["viscous_drag"])


def test_nothing_beside_a_log_tells_its_case(folder):
    for path in (folder / "logs").rglob("*"):
        text = path.name + (path.read_text() if path.is_file() else "")
        for known in ("no_lateral_slip", "viscous_drag"):
            text = text.replace(known, "")
        assert not [case for case in CASES if case in text]
    assert {path.name for path in (folder / "logs").rglob("*") if path.is_file()} == {"run.csv", "cart.yaml"}


def test_a_seed_is_a_log_and_another_seed_another(folder, tmp_path):
    generate(tmp_path, SOME[:2], [3, 4], "straight")
    again = {path.name: path.read_text() for path in (tmp_path / "truth").iterdir()}
    before = {path.name: path.read_text() for path in (folder / "truth").iterdir()}
    assert len(again) == 4
    same = set(again) & set(before)
    assert len(same) == 2
    for name in same:
        assert again[name] == before[name]
        run = Path("logs", name.removesuffix(".json"), "run.csv")
        assert (tmp_path / run).read_bytes() == (folder / run).read_bytes()
    masses = {json.loads(text)["cart"]["mass"] for text in again.values()}
    assert len(masses) == 4


@pytest.mark.parametrize("seed", range(3))
def test_the_cart_meets_its_carpet(seed):
    scene = draw_case("floor_patch", seed, "rich")
    states, world = scene.run()[0], scene.world
    x = states[:, 0] + 0.5 * world.caster_x * np.cos(states[:, 2])
    y = states[:, 1] + 0.5 * world.caster_x * np.sin(states[:, 2])
    inside = (world.patch_x_min < x) & (x < world.patch_x_max) & (world.patch_y_min < y) & (y < world.patch_y_max)
    assert 0.08 < inside.mean() < 0.7


@pytest.mark.some(6)
@pytest.mark.parametrize("name", VOCABULARY)
def test_a_refit_begins_at_the_truth(name):
    """At each of its values, of the arm that is meant."""
    for seed in range(1200, 1204):
        scene = draw_case(name, seed, "straight")
        (truth,) = scene.truths
        effect = effect_of(asdict(truth), scene.arms)
        assert effect.name == name
        assert (effect.label or truth.arm) == truth.arm
        assert truth.parameters or truth.roughly
        for key, value in {**truth.parameters, **truth.roughly}.items():
            assert getattr(effect, key) == value


def test_what_no_effect_can_have_begins_at_the_nearest_that_it_can():
    told = {"name": "time_delay", "parameters": {"delay": -0.006}, "roughly": {}, "arm": ""}
    assert effect_of(told, ("arm",)).delay == 0.0
    assert effect_of(told | {"parameters": {"delay": 0.02}}, ("arm",)).delay == 0.02
