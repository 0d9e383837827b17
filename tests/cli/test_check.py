"""`cartgrasp check`: what is suspected of a log's sensors, as a document, in words, and as an exit status."""

import json
from dataclasses import replace

import numpy as np
import pytest

from cartgrasp.logs import write_log

from ..estimation.sensor_check.logs import NOISE, late, two_hands, with_wrenches
from .commands import run

CART = "name: c\nmass: 24.0\ncom: [0.3, 0.05]\ninertia: 2.0\nconstraints:\n  - no_lateral_slip: {x: 0.0}\n"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("check")
    (path / "cart.yaml").write_text(CART, encoding="utf-8")
    sound = two_hands(0)
    write_log(sound, path / "sound.csv")
    write_log(late(sound, 0.05), path / "late.csv")
    write_log(with_wrenches(sound, lambda w: -w), path / "reversed.csv")
    write_log(replace(sound, pose=sound.pose * [1, 1, -1]), path / "mirrored.csv")
    return path


def checked(capsys, folder, name, *more):
    answer = run(capsys, "check", str(folder / name), "--cart", str(folder / "cart.yaml"), "--json", *more)
    return answer.status, json.loads(answer.out), answer.err


def test_a_sound_log(capsys, folder):
    status, document, _ = checked(capsys, folder, "sound.csv")
    assert status == 0
    assert document["suspicions"] == []
    assert document["arms"] == ["left", "right"]
    assert document["rows"] == len(two_hands(0))
    assert document["rate"] == pytest.approx(100.0)
    assert document["span"] == pytest.approx(two_hands(0).duration)
    speed = two_hands(0).velocity[:, :2]
    assert document["travelled"] == pytest.approx(
        0.01 * (speed**2).sum(axis=1) @ (speed**2).sum(axis=1) ** -0.5, rel=0.01
    )


def test_late_velocities_are_told_and_stop_nothing(capsys, folder):
    status, document, _ = checked(capsys, folder, "late.csv")
    assert status == 0
    assert {(one["kind"], one["where"]) for one in document["suspicions"]} == {("lag", "velocity"), ("lag", "yaw_rate")}
    assert document["suspicions"][0]["factor"] == pytest.approx(0.05, abs=0.001)


@pytest.mark.some(1)
@pytest.mark.parametrize("name", ["reversed.csv", "mirrored.csv"])
def test_a_wrong_sign_stops_unless_accepted(capsys, folder, name):
    status, document, err = checked(capsys, folder, name)
    assert status == 3
    assert document["suspicions"][0]["kind"] == "sign"
    assert document["suspicions"][0]["words"] in err
    assert "--accept sign" in err
    assert checked(capsys, folder, name, "--accept", "sign")[0] == 0


def test_without_a_cart_only_motion_is_judged(capsys, folder):
    answer = run(capsys, "check", str(folder / "late.csv"))
    assert answer.status == 0
    assert "49.8 ± 0.3 ms late" in answer.err
    assert run(capsys, "check", str(folder / "reversed.csv")).status == 0


def test_what_the_log_holds(capsys, folder):
    """Against the wrenches, poses and velocities themselves."""
    log = two_hands(0)
    document = checked(capsys, folder, "sound.csv")[1]
    pose, velocity, left, _ = document["sensors"]
    assert [one["where"] for one in document["sensors"]] == ["pose", "velocity", "left", "right"]
    assert pose["noise"] == pytest.approx([NOISE[0]] * 2, rel=0.1)
    assert velocity["noise"] == pytest.approx([NOISE[1]] * 2, rel=0.1)
    assert (pose["missing"], pose["largest"]) == (0.0, [None, None])
    force = np.linalg.norm(log.arms["left"].wrench[:, :3], axis=1)
    assert left["largest"][0] == pytest.approx(force.max())
    speed = np.hypot(*log.velocity[:, :2].T)
    assert document["fastest"] == pytest.approx(speed.max(), abs=5 * NOISE[1])
    smooth = np.convolve(np.gradient(speed, 0.01), np.ones(30) / 30, mode="valid")
    assert document["hardest"] > 0.9 * np.abs(smooth).max()
    shown = run(capsys, "check", folder / "sound.csv", "--cart", folder / "cart.yaml")
    assert "nothing is suspected" in shown.err
    assert {"pose", "velocity", "left", "right"} <= {line.split(" ")[0] for line in shown.out.splitlines()}


def test_a_picture(capsys, folder):
    picture = folder / "log.svg"
    checked(capsys, folder, "reversed.csv", "--out", picture)
    assert "sign: left" in picture.read_text(encoding="utf-8")
    run(capsys, "check", folder / "sound.csv", "--out", folder / "log.txt").refused(2, "--out", ".png, .svg, .pdf")


@pytest.mark.some(1)
@pytest.mark.parametrize("command", ["estimate", "identify"])
def test_what_learns_begins_with_a_look(capsys, tmp_path, command):
    """In few lines, or under a key of its JSON, with the same words as `check`."""
    cart, log = ("--cart", tmp_path / "cart.yaml"), tmp_path / "late.csv"
    (tmp_path / "cart.yaml").write_text(CART, encoding="utf-8")
    write_log(late(two_hands(0, duration=15.0), 0.05), log)
    shown = run(capsys, command, log, *cart)
    document = checked(capsys, tmp_path, "late.csv")[1]
    head = shown.err.splitlines()
    assert head[0].startswith(f"{log}: {document['rows']} rows over 15.0 s at 100 Hz")
    assert "left up to" in head[0]
    for line, one in zip(head[1:], document["suspicions"], strict=False):
        assert line == f"  suspected with {one['probability']:.2f}, {one['kind']}: {one['words']}"
    answer = run(capsys, command, log, *cart, "--json")
    assert not set(head) & set(answer.err.splitlines()) - {line for line in head if "first guess stays" in line}
    assert answer.json["checked"] == [document]


def test_a_kind_that_does_not_exist(capsys, folder):
    answer = run(capsys, "check", str(folder / "sound.csv"), "--accept", "mistakes")
    assert answer.status == 2
    assert "mistakes" in answer.err
