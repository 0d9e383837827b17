"""`cartgrasp discrepancy` and `cartgrasp study discrepancy`: what they leave, and what they refuse in one line."""

from __future__ import annotations

import json
import math
import re
import shutil
from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.sealed.generate import generate
from cartgrasp import load_cart
from cartgrasp.cli.log_inputs import Sources
from cartgrasp.effects import KNOWN_EFFECTS
from cartgrasp.logs import read_log, write_log

from .commands import run, run_quietly

KEYS = {"verdict", "where", "effects", "parameter_mismatch", "unexplained", "gap", "steps"}
EFFECT_KEYS = {"name", "probability", "parameters", "confusable_with", "gap_share"}
VERDICTS = {"no_discrepancy", "explained", "partly_explained", "unexplained"}
SCRIPT = "<script>alert(1)<!--&"
POSE, WRENCH = ("x", "y", "theta"), ("fx", "fy", "fz", "tx", "ty", "tz")
SECONDS = 15
"""Of the log: enough to name what it holds."""


@pytest.fixture(scope="module")
def sealed(tmp_path_factory):
    """Lines of a log with rolling resistance, as cells, and the text of its cart file."""
    folder = tmp_path_factory.mktemp("sealed")
    (name,) = generate(folder, ["rolling_resistance"], [0], "straight")
    log, cart = folder / "logs" / name / "run.csv", folder / "logs" / name / "cart.yaml"
    lines = log.read_text(encoding="utf-8").splitlines()[: 100 * SECONDS + 1]
    return SimpleNamespace(table=[line.split(",") for line in lines], cart=cart.read_text(encoding="utf-8"))


def log_file(folder, table, name="run.csv"):
    path = folder / name
    path.write_text("\n".join(",".join(row) for row in table) + "\n", encoding="utf-8")
    return path


@pytest.fixture
def diagnose(capsys, tmp_path, sealed):
    """Runs the command on a table, or on the sealed one."""

    def diagnosed(table=None, *flags, cart=sealed.cart):
        log = log_file(tmp_path, sealed.table if table is None else table)
        (tmp_path / "cart.yaml").write_text(cart, encoding="utf-8")
        return run(capsys, "discrepancy", log, "--cart", tmp_path / "cart.yaml", "--json", *flags)

    return diagnosed


@pytest.fixture(scope="module")
def made(tmp_path_factory, sealed):
    """One run, of a log and a cart with unpleasant names."""
    folder = tmp_path_factory.mktemp("made")
    log = log_file(folder, sealed.table, f"{SCRIPT}.csv")
    cart = folder / "cart.yaml"
    cart.write_text(sealed.cart.replace("name: cart", f'name: "{SCRIPT}"'), encoding="utf-8")
    answer = run_quietly("discrepancy", log, "--cart", cart, "--out", folder / "deep" / "out", "--json")
    return SimpleNamespace(answer=answer, out=folder / "deep" / "out", log=log)


def column(table, name):
    return table[0].index(name)


def spoiled(table, rows, names, cell):
    """The same with `cell` at data rows (counted from 0) and columns; names of wrenches are of each arm."""
    table = [list(row) for row in table]
    places = [i for i, name in enumerate(table[0]) if name in names or name.split(".")[-1] in names]
    assert places
    for i in range(len(table) - 1)[rows]:
        for place in places:
            table[i + 1][place] = cell
    return table


# --- what comes out -----------------------------------------------------------------------------------------


def test_the_document_is_the_contracts(made):
    assert made.answer.status == 0, made.answer.err
    document = made.answer.json
    assert set(document) >= KEYS
    assert document["verdict"] in VERDICTS
    assert {e["name"] for e in document["effects"]} == {"rolling_resistance"}
    for effect in document["effects"]:
        assert set(effect) >= EFFECT_KEYS
        assert 0 < effect["probability"] <= 1
        assert 0 <= effect["gap_share"] <= 1
        assert set(effect["confusable_with"]) <= set(KNOWN_EFFECTS)
        for parameter in effect["parameters"].values():
            assert set(parameter) == {"value", "std", "unit"}
            assert parameter["std"] > 0
    for one in document["where"]:
        assert {"start", "stop", "coordinate", "condition", "size", "share"} <= set(one)
        assert one["coordinate"] in ("forward_force", "yaw_moment", "lateral_velocity")
        assert one["start"] < one["stop"]
    assert {"mass", "com_x", "com_y", "inertia", "viscous_drag"} <= set(document["parameter_mismatch"])
    for entry in document["parameter_mismatch"].values():
        assert set(entry) == {"nominal", "refitted", "std"}
    gap = document["gap"]
    assert {"metric", "before", "refitted", "after", "noise_floor", "per_coordinate"} <= set(gap)
    assert gap["after"] < gap["refitted"] < gap["before"]
    assert {"size", "depends_on"} <= set(document["unexplained"])
    assert document["impacts"] == []
    assert document["steps"][0]["added"] == "rolling_resistance"
    assert all({"name", "score", "verdict"} <= set(c) for step in document["steps"] for c in step["candidates"])


def test_the_terminal_tells_the_cart_what_was_added_and_what_to_do_next(capsys, monkeypatch, tmp_path, sealed):
    """The same numbers as the document. A cart without wheels is told to list them; the motion to run next can be
    written, unless it was."""
    monkeypatch.setenv("COLUMNS", "120")
    log, out = log_file(tmp_path, sealed.table), tmp_path / "out"
    cart = re.sub(r"\nwheels:\n( .*\n|-.*\n)*", "\n", sealed.cart)
    (tmp_path / "cart.yaml").write_text(cart, encoding="utf-8")
    answer = run(capsys, "discrepancy", log, "--cart", tmp_path / "cart.yaml", "--out", out)
    assert answer.status == 0
    assert "lists no wheels" in answer.out
    assert "next.yaml" in answer.out
    document = json.loads((out / "report.json").read_text(encoding="utf-8"))
    rows = [line.split() for line in answer.out.splitlines()]
    (mass,) = (row for row in rows if row[:1] == ["mass"])
    told, (effect,) = document["parameter_mismatch"]["mass"], document["effects"]
    assert [float(cell) for cell in mass[1:4]] == pytest.approx(
        [told[k] for k in ("nominal", "refitted", "std")], rel=0.05
    )
    assert mass[4:] == ["kg", "yes"]
    (added,) = (row for row in rows if row[:1] == ["rolling_resistance"])
    value = effect["parameters"]["coefficient"]
    assert float(added[1]) == pytest.approx(effect["probability"], abs=0.01)
    assert [float(cell) for cell in added[3:5]] == pytest.approx([value["value"], value["std"]], rel=0.05)


def test_the_folder_holds_the_same(made):
    assert {"report.json", "report.html", "cart.yaml"} <= {path.name for path in made.out.iterdir()}
    assert len(list(made.out.glob("*.svg"))) > 1
    assert json.loads((made.out / "report.json").read_text(encoding="utf-8")) == made.answer.json
    cart, document = load_cart(made.out / "cart.yaml"), made.answer.json
    assert cart.name == SCRIPT
    assert cart.inertia.mass == pytest.approx(document["parameter_mismatch"]["mass"]["refitted"])
    rolling = next(e for e in cart.effects if e.name == "rolling_resistance")
    assert math.isclose(rolling.coefficient, document["effects"][0]["parameters"]["coefficient"]["value"])


def test_the_page_opens_offline_and_runs_nothing(made):
    page = (made.out / "report.html").read_text(encoding="utf-8")
    assert "<script" not in page
    assert "&lt;script&gt;alert(1)" in page
    policy = page[page.index("Content-Security-Policy") :].partition(">")[0]
    assert "default-src 'none'" in policy
    assert "script-src" not in policy
    for text in (page, *(path.read_text(encoding="utf-8") for path in made.out.glob("*.svg"))):
        assert "src=" not in text
        assert "@import" not in text
        assert not [link for link in text.split("href=")[1:] if link[:2] not in ('"#', "'#")]
        links = re.findall(r'https?:[^"]*', text)
        assert all(link.startswith("http://www.w3.org/") for link in links)  # names of what SVG is, not addresses
    assert "<svg" in page


@pytest.mark.prove
def test_samples_that_are_missing(diagnose, sealed):
    table = spoiled(sealed.table, slice(300, 360), POSE, "nan")
    answer = diagnose(spoiled(table, slice(1000, 1040), WRENCH, ""))
    assert answer.status == 0, answer.err
    document = answer.json
    assert document["logs"][0]["rows_with_wrenches"] < len(sealed.table) - 40
    assert "rolling_resistance" in [e["name"] for e in document["effects"]]


@pytest.mark.prove
def test_a_slower_force_sensor(diagnose, sealed):
    """Which tells a wrench in every second row."""
    answer = diagnose(spoiled(sealed.table, slice(None, None, 2), WRENCH, ""))
    assert answer.status == 0, answer.err
    assert [e["name"] for e in answer.json["effects"]] == ["rolling_resistance"]


@pytest.mark.parametrize("noise", [0.0, 5e-4])
def test_a_standing_cart(diagnose, sealed, noise):
    """It is pushed, and whatever holds it has no name; the gap is its noise, and the cart stays as the file says."""
    random = np.random.default_rng(0)
    table = [list(row) for row in sealed.table[:601]]
    for row in table[1:]:
        for name in POSE:
            row[column(table, name)] = f"{noise * random.standard_normal():.6g}"
    answer = diagnose(table)
    assert answer.status == 0, answer.err
    document = answer.json
    gap = document["gap"]
    assert gap["before"] == gap["after"] == pytest.approx(2**0.5 * noise, rel=0.2, abs=1e-5)
    assert document["effects"] == []
    for name in ("mass", "viscous_drag"):
        one = document["parameter_mismatch"][name]
        assert one["refitted"] == pytest.approx(one["nominal"], rel=1e-3)


# --- what is refused ----------------------------------------------------------------------------------------


def test_a_column_that_is_missing(diagnose, tmp_path, sealed):
    table = [list(row) for row in sealed.table]
    table[0][column(table, "theta")] = "thta"
    diagnose(table).refused(3, f"{tmp_path / 'run.csv'}:1", "theta")


@pytest.mark.parametrize("cell", ["abc", "1,5", "inf", "--"])
def test_a_bad_cell(diagnose, tmp_path, sealed, cell):
    diagnose(spoiled(sealed.table, slice(40, 41), ("y",), cell)).refused(3, f"{tmp_path / 'run.csv'}:42")


@pytest.mark.parametrize("back", [0, 1], ids=["duplicated", "backward"])
def test_a_clock_that_does_not_run(diagnose, tmp_path, sealed, back):
    earlier = sealed.table[50 - back][0]
    diagnose(spoiled(sealed.table, slice(50, 51), ("t",), earlier)).refused(3, f"{tmp_path / 'run.csv'}:52", "t:")


@pytest.mark.parametrize("rows", [0, 1, 2, 99, 350, 401])
def test_too_short_a_log(diagnose, tmp_path, sealed, rows):
    diagnose(sealed.table[: rows + 1]).refused(3, tmp_path / "run.csv")


@pytest.mark.parametrize(
    ("rows", "names", "cell", "why"),
    [
        (slice(None), POSE, "nan", "pose"),
        (slice(None), WRENCH, "", "wrench of arm arm"),
        (slice(None), WRENCH, "0", "all its wrenches are zero"),
        (slice(600, None), WRENCH, "1e300", ""),
        (slice(600, None), POSE, "1e100", "SI units"),
    ],
    ids=["no pose", "no wrench", "no sensor", "huge forces", "far away"],
)
def test_nothing_to_learn_from(diagnose, tmp_path, sealed, rows, names, cell, why):
    diagnose(spoiled(sealed.table, rows, names, cell)).refused(3, tmp_path / "run.csv", why)


def test_a_cart_that_jumps(diagnose, tmp_path, sealed):
    table = [list(row) for row in sealed.table[:1001]]
    for row in table[601:]:
        row[column(table, "x")] = repr(float(row[column(table, "x")]) + 5.0)
    diagnose(table).refused(3, tmp_path / "run.csv", "jumps")


def test_wrong_usage(capsys, diagnose, tmp_path, sealed):
    log = log_file(tmp_path, sealed.table)
    cart = tmp_path / "cart.yaml"
    diagnose(None, log).refused(2, log, "is given twice")
    copy = log.with_name("copy.csv")
    copy.write_bytes(log.read_bytes())
    diagnose(None, copy).refused(2, copy, f"holds the rows of {log}")
    run(capsys, "discrepancy", log).refused(2, "--cart is missing")
    run(capsys, "discrepancy").refused(2, "LOG")
    run(capsys, "discrepancy", tmp_path / "no.csv", "--cart", cart).refused(3, "no.csv")
    run(capsys, "discrepancy", log, "--cart", tmp_path / "no.yaml").refused(2, "no.yaml")
    diagnose(None, "--out", log).refused(2, "--out", "can't be made")


def test_a_cart_file_with_a_mistake(diagnose, tmp_path, sealed):
    line = 1 + next(i for i, text in enumerate(sealed.cart.splitlines()) if text.startswith("mass:"))
    wrong = sealed.cart.replace("mass: ", "mass: -")
    diagnose(None, cart=wrong).refused(2, f"{tmp_path / 'cart.yaml'}:{line}", "mass")


# --- a study of many logs -----------------------------------------------------------------------------------


def put(folder, name, sealed, table):
    (folder / "logs" / name).mkdir(parents=True)
    (folder / "logs" / name / "cart.yaml").write_text(sealed.cart, encoding="utf-8")
    return log_file(folder / "logs" / name, table)


def test_a_study_goes_on_where_it_was(capsys, tmp_path, sealed, made):
    put(tmp_path, "a", sealed, sealed.table)
    shutil.copytree(made.out, tmp_path / "logs" / "a" / "out")
    bad = put(tmp_path, "b", sealed, spoiled(sealed.table, slice(40, 41), ("y",), "abc"))
    short = put(tmp_path, "c", sealed, sealed.table[:1301])
    write_log(read_log(short), short.with_suffix(".parquet"))
    short.unlink()
    two = put(tmp_path, "d", sealed, sealed.table)
    shutil.copy(two, two.with_suffix(".mcap"))
    answer = run(capsys, "study", "discrepancy", tmp_path, "--jobs", "1", "--json")
    assert answer.status == 1
    a, b, c, d = answer.json["logs"]
    assert (a["verdict"], a["effects"], a["seconds"]) == ("explained", ["rolling_resistance"], None)
    assert f"{bad}:42" in b["failure"]
    assert c["verdict"] in VERDICTS
    assert c["seconds"] > 0
    assert "run.csv and run.mcap" in d["failure"]
    assert not (bad.parent / "out").exists()
    assert (tmp_path / "discrepancy.md").read_text(encoding="utf-8").startswith("# Discrepancies")

    report = tmp_path / "logs" / "c" / "out" / "report.json"
    before = report.stat().st_mtime_ns
    shutil.rmtree(bad.parent)
    shutil.rmtree(two.parent)
    again = run(capsys, "study", "discrepancy", tmp_path, "--jobs", "2")
    assert again.status == 0, again.err
    assert "rolling_resistance" in again.out
    assert report.stat().st_mtime_ns == before


def test_a_study_of_nothing(capsys, tmp_path):
    run(capsys, "study", "discrepancy", tmp_path / "no").refused(2, tmp_path / "no", "run.csv")
    run(capsys, "study", "discrepancy", tmp_path, "--jobs", "0").refused(2, "--jobs")


def test_a_reader_that_goes_away_loses_no_report(monkeypatch, tmp_path):
    from cartgrasp.cli import discrepancy

    saved = []
    found = SimpleNamespace(report=SimpleNamespace(as_dict=dict, save=saved.append))

    def broken(document):
        raise BrokenPipeError

    monkeypatch.setattr(discrepancy, "cart_and_logs", lambda *a: (SimpleNamespace(name="cart"), []))
    monkeypatch.setattr(discrepancy, "diagnose", lambda *a, **_: found)
    monkeypatch.setattr(discrepancy, "print_json", broken)
    with pytest.raises(BrokenPipeError):
        discrepancy.run(Sources((log_file(tmp_path, []),)), tmp_path, as_json=True)
    assert saved == [tmp_path]
