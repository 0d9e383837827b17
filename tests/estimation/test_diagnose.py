"""The discrepancy workflow end to end, on logs whose equations share nothing with the library's."""

import json
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.io import loadmat
from scipy.signal import butter, filtfilt

import cartgrasp as cg
from benchmarks.sealed.generate import generate
from benchmarks.true_structures import refit_all
from cartgrasp.constraints import RollingConstraints
from cartgrasp.effects import ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from cartgrasp.studies.shopping_cart import first_guess, scenario
from estimation import diagnose

FLAT_SPOT = pytest.param("flat_spot", marks=pytest.mark.prove)
EMPS = Path(__file__).parents[3] / "shared" / "data" / "emps" / "DATA_EMPS.mat"


@pytest.fixture(scope="module")
def sealed(tmp_path_factory):
    """A folder of logs, and their names by case."""
    folder = tmp_path_factory.mktemp("sealed")
    return folder, {case: generate(folder, [case], [40], "rich")[0] for case in ("nothing", "floor_slope", "flat_spot")}


@pytest.fixture(scope="module")
def found(sealed):
    """The diagnosis of a case, made once where it is asked for."""
    folder, names = sealed

    @cache
    def of_case(case):
        log = folder / "logs" / names[case]
        return diagnose(cg.read_log(log / "run.csv"), cg.load_cart(log / "cart.yaml"))

    return of_case


@pytest.mark.long
def test_a_hidden_effect_is_named_added_and_closes_the_gap(found, tmp_path):
    diagnosis = found("floor_slope")
    assert diagnosis.verdict in ("explained", "partly_explained")
    assert diagnosis.effects[0].name == "floor_slope"
    assert diagnosis.gap.after < 0.5 * diagnosis.gap.refitted < diagnosis.gap.before
    assert any("goes with the heading" in one.condition for one in diagnosis.where)
    maps = {(one.coordinate, one.variable): one for one in diagnosis.residual_maps}
    by_heading = maps["forward_force", "heading"]
    assert np.nanstd(by_heading.extended.mean) < 0.2 * np.nanstd(by_heading.refitted.mean)
    folder = diagnosis.report.save(tmp_path / "out")
    extended = cg.load_cart(folder / "cart.yaml")
    assert "floor_slope" in [effect.name for effect in extended.effects]
    again = diagnose_names(json.loads((folder / "report.json").read_text()))
    assert again == [effect.name for effect in diagnosis.effects]


@pytest.mark.prove
def test_casters_that_the_cart_does_not_list_are_found_with_their_place(tmp_path):
    """One stands for two, a fifth farther away."""
    log = tmp_path / "logs" / generate(tmp_path, ["caster_realignment"], [41], "rich")[0]
    cart = cg.load_cart(log / "cart.yaml")
    listed = [wheel for wheel in cart.wheels if wheel.kind == "caster"]
    diagnosis = diagnose(cg.read_log(log / "run.csv"), replace(cart, wheels=()))
    assert [effect.name for effect in diagnosis.effects] == ["caster_realignment"]
    found = next(effect for effect in diagnosis.cart.effects if effect.name == "caster_realignment")
    for name, listed_value in (("x", listed[0].x), ("trail", listed[0].trail)):
        value, std, _ = diagnosis.effects[0].parameters[name]
        assert value == getattr(found, name)
        assert abs(value - listed_value) < 2 * std < 0.5 * listed_value
    assert diagnosis.gap.after < 0.5 * diagnosis.gap.refitted


@pytest.mark.long
@pytest.mark.some(1)
@pytest.mark.parametrize(("plant", "seed"), [("model", 3), ("model", 11), ("mujoco", 0)])
def test_casters_that_a_reversal_left_poised_are_no_push(plant, seed):
    """A thousandth of a radian decides which way they swing round, and when; and how the cart turns under them."""
    found = diagnose(scenario(plant=plant, seed=seed).run().log, first_guess())
    assert found.verdict == "no_discrepancy"
    assert not found.effects


def test_where_nothing_is_hidden_nothing_is_named(found):
    diagnosis = found("nothing")
    assert diagnosis.verdict == "no_discrepancy"
    assert not diagnosis.where
    assert not diagnosis.effects
    assert diagnosis.gap.refitted < 1.35 * diagnosis.gap.noise_floor


@pytest.mark.parametrize(("times", "verdict"), [(1.9, "no_discrepancy"), (2.1, "unexplained")])
def test_nothing_agrees_that_is_twice_as_far_off_as_noise(found, times, verdict):
    """However quiet the rows are."""
    gap = found("nothing").gap
    far = replace(gap, refitted=times * gap.noise_floor, after=times * gap.noise_floor)
    diagnosis = replace(found("nothing"), gap=far)
    assert diagnosis.verdict == verdict
    assert ("disagree" in diagnosis.sentence) == (verdict == "unexplained")


@pytest.mark.prove
def test_what_no_vocabulary_has_is_a_law_of_what_it_follows(found):
    diagnosis = found("flat_spot")
    (effect,) = diagnosis.effects
    law = effect.as_dict()["law"]
    assert law["of"] == "travelled_distance"
    assert law["period"]["unit"] == "m"
    assert "wheel" in law["likely"]


@pytest.mark.parametrize("case", ["floor_slope", FLAT_SPOT])
def test_what_was_added_alone_closed_what_all_of_it_closes(found, case):
    """The table and the sentence say one thing."""
    (effect,), gap = found(case).effects, found(case).gap
    closed = (gap.refitted**2 - gap.after**2) / (gap.refitted**2 - gap.noise_floor**2)
    assert effect.gap_share == pytest.approx(min(closed, 1.0), abs=1e-9)


@pytest.mark.parametrize("case", ["nothing", "floor_slope", FLAT_SPOT])
def test_parameters_of_the_nominal_model_are_told_apart_from_effects(found, case):
    mass = found(case).parameter_mismatch["mass"]
    assert abs(mass["refitted"] - mass["nominal"]) > 0
    assert 0 < mass["std"] < 0.2 * mass["refitted"]


@pytest.mark.prove
def test_what_is_named_reaches_the_true_structure_refitted(found, sealed):
    """From no effect, or from the truth's own values: one gap. What has no name has no refit."""
    folder, names = sealed
    assert refit_all(folder) == 2
    refits = {path.parent.name: json.loads(path.read_text()) for path in folder.glob("logs/*/refit.json")}
    assert sorted(refits) == sorted([names["nothing"], names["floor_slope"]])
    assert refits[names["nothing"]]["gap"] == pytest.approx(found("nothing").gap.refitted)
    slope = refits[names["floor_slope"]]
    assert slope["gap"] == pytest.approx(found("floor_slope").gap.after, rel=0.01)
    (true,) = json.loads((folder / "truth" / f"{names['floor_slope']}.json").read_text())["effects"]
    assert slope["effects"]["floor_slope"] == pytest.approx(true["parameters"], abs=0.002)


def diagnose_names(report):
    return [effect["name"] for effect in report["effects"]]


def least_squares_on_the_axis(late):
    """Coulomb friction (N), and the share of the force that is left, of rows above 20 mm/s; the force acts so many ms
    after its sample. The authors' 20.4 N is for none, with rows at rest."""
    raw = loadmat(EMPS)
    force, position = np.roll(raw["vir"].ravel() * float(raw["gtau"].item()), late), raw["qm"].ravel()
    speed = np.gradient(filtfilt(*butter(4, 0.2), position), 1e-3)
    kept = np.flatnonzero(np.abs(speed) > 0.02)[200:-200]
    columns = np.gradient(speed, 1e-3), np.maximum(speed, 0), np.minimum(speed, 0), np.sign(speed)
    rows, force = np.column_stack(columns)[kept], force[kept]
    fit = np.linalg.lstsq(rows, force, rcond=None)[0]
    return fit[3], np.linalg.norm(force - rows @ fit) / np.linalg.norm(force)


@pytest.fixture(scope="module")
def axis():
    """From mass and viscous drag alone."""
    if not EMPS.is_file():
        pytest.skip(f"the EMPS data set is not at {EMPS}")
    rail = CartModel(
        Inertia(80.0, (0.0, 0.0), 1.0), RollingConstraints(0.0, no_rotation=True), (ViscousDrag(linear=100.0),)
    )
    return diagnose(cg.read_log(EMPS), rail)


def coulomb_of(diagnosis):
    """Value and standard deviation, N."""
    value, std, _ = diagnosis.effects[0].parameters["coefficient"]
    weight = diagnosis.cart.inertia.mass * 9.81
    return value * weight, std * weight


@pytest.mark.long
def test_the_real_axis_lacks_two_frictions(axis):
    """Reference values of the data's authors: M 95.1 ± 0.5 kg, Fc 20.4 N, within a deviation."""
    assert [effect.name for effect in axis.effects] == ["rolling_resistance", "directional_drag"]
    mass = axis.certainty.parameters["mass"]
    assert abs(mass.value - 95.1) < np.hypot(mass.std, 0.5) < 1.0
    coulomb, std = coulomb_of(axis)
    assert abs(coulomb - 20.4) < std < 0.05 * coulomb


@pytest.mark.long
@pytest.mark.xfail(strict=True, reason="issue 28: the drive's millisecond is no candidate, and costs 2 of 3 mm")
def test_the_real_axis_is_late_by_a_millisecond(axis):
    found = {late: least_squares_on_the_axis(late) for late in (0, 1, 2)}
    assert found[0][1] > 1.25 * found[1][1] < 0.8 * found[2][1]
    assert coulomb_of(axis)[0] == pytest.approx(found[1][0], abs=0.4)
    assert axis.gap.after < 0.0015
    assert axis.verdict == "explained"
    assert axis.gap.per_horizon["0.5 s"]["after"] < 0.3 * axis.gap.per_horizon["0.5 s"]["refitted"]
