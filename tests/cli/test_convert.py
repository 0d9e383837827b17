"""`topics` and `convert`, and bags where logs are asked for."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import numpy as np
import pytest

from cartgrasp.cli.output import check_writable
from cartgrasp.logs import read_log

from ..logs import bag_files as files
from ..logs.bag_files import MAP, push
from ..logs.test_tf_chains import robot
from .commands import CART, run
from .pushed_cart import as_csv, pushed_cart


@pytest.fixture
def csv(tmp_path):
    (tmp_path / "cart.yaml").write_text(CART)
    path = tmp_path / "run.csv"
    path.write_text(as_csv(pushed_cart()[:250]))
    return path


@pytest.mark.some(1)
@pytest.mark.parametrize("method", ["filter", "regressor"])
def test_estimate_through_mcap_is_estimate(capsys, tmp_path, csv, method):
    """There and back again, and straight from the bag: the same to round-off of times, headings and velocities."""
    bag, back = tmp_path / "run.mcap", tmp_path / "back.csv"
    assert run(capsys, "convert", csv, "--out", bag).status == 0
    assert run(capsys, "convert", bag, "--out", back).status == 0
    answers = []
    for log in (csv, bag, back):
        answer = run(capsys, "estimate", log, "--cart", tmp_path / "cart.yaml", "--method", method, "--json")
        answers.append(answer.json["parameters"])
    for other in answers[1:]:
        for name, values in answers[0].items():
            assert other[name]["value"] == pytest.approx(values["value"], rel=1e-9, abs=1e-9)
            assert other[name]["std"] == pytest.approx(values["std"], rel=1e-9, abs=1e-12)


def test_provenance(capsys, tmp_path, csv):
    answer = run(capsys, "convert", csv, "--out", tmp_path / "run.mcap", "--json")
    assert answer.json["rows"] == 250
    run(capsys, "convert", tmp_path / "run.mcap", "--out", tmp_path / "back.parquet", "--json")
    document = json.loads((tmp_path / "back.parquet.provenance.json").read_text())
    for part, name in ((document["log"], "back.parquet"), (document["source"]["files"][0], "run.mcap")):
        assert part == {"name": name, "sha256": hashlib.sha256((tmp_path / name).read_bytes()).hexdigest()}
    assert document["topics"]["arms"]["left"]["force"] == "on_cart"
    rows = [s["rows"] for s in document["steps"] if s["what"].startswith("rows at")]
    assert rows == [250]
    assert np.allclose(read_log(tmp_path / "back.parquet").table, read_log(csv).table, atol=1e-8)


def test_logs_of_one_name_keep_their_provenance(capsys, tmp_path, csv):
    """That of run.mcap had taken the place of run.parquet's."""
    (tmp_path / "new").mkdir()
    outs = [tmp_path / "new" / f"run.{kind}" for kind in ("csv", "parquet", "mcap")]
    told = [run(capsys, "convert", csv, "--out", out, "--json").json["provenance"] for out in outs]
    assert [json.loads(Path(one).read_text(encoding="utf-8"))["log"]["name"] for one in told] == [p.name for p in outs]


def test_from_a_bag_to_a_map_to_a_log(capsys, tmp_path):
    bag = files.write_ros1(tmp_path / "run.bag", push())
    answer = run(capsys, "topics", bag, "--json").json
    assert [(t["topic"], t["count"]) for t in answer["topics"]] == [("/left/wrench", 100), ("/odom", 100)]
    assert answer["topics"][0]["rate"] == pytest.approx(50)
    assert answer["topics"][0]["last"] == pytest.approx(1.98)
    own = tmp_path / "run.bag.topics.yaml"
    assert run(capsys, "topics", bag, "--out", own).status == 0
    run(capsys, "topics", bag, "--out", own).refused(2, own, "is there already")
    run(capsys, "convert", bag, "--out", tmp_path / "run.csv").refused(2, f"{own}:", "contact: is not stated")
    text = own.read_text()
    assert text == answer["proposal"]
    text = text.replace("contact: ", "contact: [-0.25, 0.2, 1.0]", 1).replace("force: ", "force: on_cart", 1)
    own.write_text(text)
    answer = run(capsys, "convert", bag, "--out", tmp_path / "run.csv")
    assert answer.status == 0
    assert "100 rows over 1.98 s, arms left" in answer.out
    log = read_log(tmp_path / "run.csv")
    assert np.array_equal(log.arms["left"].wrench, files.force_of(np.arange(0, 2, 0.02)))


def test_a_proposal_states_the_noise_of_poses(capsys, tmp_path):
    rng = np.random.default_rng(1)
    messages = []
    for t in np.arange(0, 5, 0.02):
        ns = files.stamp(t)
        noisy = files.path_of(t)[0] + rng.normal(0, [0.002, 0.002, 0.004])
        messages.append(("/tf", files.TF, ns, files.transforms(ns, ("map", "base", noisy))))
        for arm in ("left", "right"):
            reading = files.wrench(ns, files.force_of(t))
            messages.append((f"/robot/{arm}/ft", files.WRENCH, ns, reading))
    bag = files.write_mcap(tmp_path / "run.mcap", messages)
    text = run(capsys, "topics", bag, "--json").json["proposal"]
    for part in ("left:", "right:", "frame: map", "child: base", "velocity: none"):
        assert part in text
    position, heading = (
        float(text.split(f"{key}: ")[1].split("}")[0].split(",")[0]) for key in ("position", "heading")
    )
    assert position == pytest.approx(0.002, rel=0.2)
    assert heading == pytest.approx(0.004, rel=0.2)
    filled = text.replace("    contact: ", "    contact: [0, 0, 1]").replace("    force: ", "    force: on_cart")
    (tmp_path / "topics.yaml").write_text(filled)
    assert list(read_log(bag).arms) == ["left", "right"]


def test_a_chain_is_proposed_where_there_is_no_odometry(capsys, tmp_path):
    """map → odom every 0.2 s, base_link fixed in what moves at 50 Hz; a wheel turns faster than all."""
    wheel = [
        ("/tf", files.TF, ns, files.transforms(ns, ("base_link", "wheel", (0.0, 0.3, 0.0))))
        for ns in map(files.stamp, np.arange(0, 2, 0.005))
    ]
    bag = files.write_mcap(tmp_path / "run.mcap", sorted([*robot(), *wheel], key=lambda m: m[2]))
    text = run(capsys, "topics", bag, "--json").json["proposal"]
    for part in ("topic: /tf\n", "frame: map\n", "child: base_link\n", "max_gap: 1 ", "stamps: header", "clock: pose"):
        assert part in text
    assert "# composed along map → odom → base_footprint → base_link" in text
    assert "noise:" in text
    filled = text.replace("    contact: ", "    contact: [0, 0, 1]").replace("    force: ", "    force: on_cart")
    (tmp_path / "topics.yaml").write_text(filled)
    answer = run(capsys, "convert", bag, "--out", tmp_path / "run.csv")
    assert answer.status == 0
    assert "/tf map → odom: tf2_msgs/msg/TFMessage (role pose, samples 11," in answer.out
    assert "100 rows over 1.98 s" in answer.out
    both = files.write_mcap(tmp_path / "both.mcap", sorted([*robot(), *push()], key=lambda m: m[2]))
    assert "topic: /odom" in run(capsys, "topics", both, "--json").json["proposal"]


def test_nothing_to_propose(capsys, tmp_path):
    bag = files.write_mcap(tmp_path / "run.mcap", [m for m in push() if m[0] != "/odom"])
    answer = run(capsys, "topics", bag)
    assert answer.status == 0
    assert "/left/wrench" in answer.out
    assert "no map is proposed" in answer.err


def test_salvage_is_asked_for(capsys, tmp_path):
    bag = files.write_mcap(tmp_path / "run.mcap", push())
    (tmp_path / "topics.yaml").write_text(MAP)
    bag.write_bytes(bag.read_bytes()[:-5000])
    out = tmp_path / "run.csv"
    run(capsys, "convert", bag, "--out", out).refused(3, bag, "its end is missing", "--salvage")
    run(capsys, "topics", bag).refused(3, bag, "--salvage")
    run(capsys, "estimate", bag, "--cart", tmp_path / "cart.yaml").refused(2, "cart.yaml")
    assert not out.exists()
    answer = run(capsys, "convert", bag, "--out", out, "--salvage", "--json")
    assert answer.status == 0
    assert "lost: " in answer.err
    assert answer.json["lost"]
    assert json.loads((tmp_path / "run.csv.provenance.json").read_text())["lost"] == answer.json["lost"]
    assert 50 < len(read_log(out)) < 100


def test_a_recording_is_not_written_over(capsys, tmp_path, csv):
    """It is given as the folder that a recorder wrote; another log may stand in there."""
    folder = tmp_path / "recording"
    folder.mkdir()
    bag = files.write_mcap(folder / "run_0.mcap", push())
    (folder / "topics.yaml").write_text(MAP)
    before = bag.read_bytes()
    run(capsys, "convert", folder, "--out", bag).refused(2, "is of the recording")
    assert bag.read_bytes() == before
    for beside in ("run.csv", "cart.yaml"):
        (folder / beside).write_text("of the run before")
        check_writable(folder / beside, folder)


def test_wrong_usage(capsys, tmp_path, csv):
    run(capsys, "convert", csv).refused(2, "--out")
    run(capsys, "convert", csv, "--out", tmp_path / "run.xlsx").refused(2, ".csv, .parquet, .mcap")
    run(capsys, "convert", csv, "--out", csv).refused(2, "is read by this command")
    run(capsys, "convert", csv, "--out", tmp_path / "no" / "run.csv").refused(2, "no folder")
    run(capsys, "convert", csv, "--out", tmp_path / "b.csv", "--salvage").refused(2, "--salvage", "is for bags")
    run(capsys, "convert", tmp_path / "no.bag", "--out", tmp_path / "b.csv").refused(3, "no.bag", "no such file")
    (tmp_path / "map.yaml").write_text(MAP)
    options = ("--cart", tmp_path / "cart.yaml", "--topics", tmp_path / "map.yaml")
    run(capsys, "identify", csv, *options).refused(2, "a table is no bag")


def test_commands_take_bags_and_their_map(capsys, tmp_path, csv):
    bag = tmp_path / "run.mcap"
    run(capsys, "convert", csv, "--out", bag)
    (tmp_path / "bad.yaml").write_text("pose: {}\n")
    for command in ("estimate", "identify", "discrepancy"):
        options = ("--cart", tmp_path / "cart.yaml", "--topics", tmp_path / "bad.yaml")
        run(capsys, command, bag, *options).refused(2, "bad.yaml", "is missing")
