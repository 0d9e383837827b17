"""What learns from logs refuses one whose sensors are surely wrong, in the words of `cartgrasp check`."""

from dataclasses import replace

import numpy as np
import pytest

from cartgrasp.cart_file import load_cart
from cartgrasp.cli.sensors import check_logs, checked_log
from cartgrasp.errors import DataError
from cartgrasp.logs import ArmLog, read_log, write_log

from ..estimation.sensor_check.logs import two_hands, with_wrenches
from .commands import run

CART = "name: c\nmass: 24.0\ncom: [0.3, 0.05]\ninertia: 2.0\nconstraints:\n  - no_lateral_slip: {x: 0.0}\n"
COMMANDS = ("estimate", "identify", "discrepancy")
WRONG = {
    "sign": lambda log: with_wrenches(log, lambda w: -w),
    "unit": lambda log: with_wrenches(log, lambda w: 1e-3 * w),
    "axes": lambda log: with_wrenches(log, lambda w: w[:, [1, 0, 2, 4, 3, 5]]),
    "frame": lambda log: replace(log, velocity=_of_cart(log)),
}


def _of_cart(log):
    """Velocities along the cart's own axes."""
    c, s = np.cos(log.pose[:, 2]), np.sin(log.pose[:, 2])
    vx, vy, omega = log.velocity.T
    return np.column_stack([c * vx + s * vy, c * vy - s * vx, omega])


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("sensors")
    (path / "cart.yaml").write_text(CART, encoding="utf-8")
    sound = two_hands(0, duration=20.0)
    write_log(sound, path / "sound.csv")
    for kind, change in WRONG.items():
        write_log(change(sound), path / f"{kind}.csv")
    return path


def asked(capsys, folder, command, name, *more):
    return run(capsys, command, folder / name, "--cart", folder / "cart.yaml", "--json", *more)


@pytest.mark.some(1)
@pytest.mark.parametrize("kind", WRONG)
def test_the_same_words_as_check(capsys, folder, kind):
    """One line, which names the log and how to accept it; nothing on stdout."""
    told = asked(capsys, folder, "check", f"{kind}.csv")
    assert told.status == 3
    words = told.json["suspicions"][0]["words"]
    assert told.json["suspicions"][0]["kind"] == kind
    for command in COMMANDS:
        answer = asked(capsys, folder, command, f"{kind}.csv")
        answer.refused(3, folder / f"{kind}.csv", words, f"--accept {kind}")
        assert answer.err == told.err


@pytest.mark.some(1)
@pytest.mark.parametrize("command", ["estimate", "identify"])
def test_what_is_accepted_is_learned_from(capsys, folder, command):
    answer = asked(capsys, folder, command, "unit.csv", "--accept", "unit", "--accept", "scale")
    assert answer.status == 0
    assert answer.json["parameters"]["mass"]["value"] > 0
    asked(capsys, folder, command, "unit.csv", "--accept", "sign").refused(3, "--accept unit")


@pytest.mark.prove
def test_what_is_accepted_is_still_told(capsys, folder):
    answer = asked(capsys, folder, "discrepancy", "sign.csv", "--accept", "sign")
    assert answer.status == 0
    assert "nothing of this holds if sensors are wrong" in answer.json["sentence"]


@pytest.mark.parametrize("command", COMMANDS)
def test_a_kind_that_does_not_exist(capsys, folder, command):
    asked(capsys, folder, command, "sound.csv", "--accept", "mistakes").refused(2, "--accept mistakes", "axes, frame")


def test_one_wrong_log_of_several(capsys, folder):
    paths = [folder / "sound.csv", folder / "sign.csv"]
    run(capsys, "identify", *paths, "--cart", folder / "cart.yaml").refused(3, folder / "sign.csv", "--accept sign")


def test_glitches_are_no_wrong_sensors(folder):
    """Single rows that stand far off are left out by what learns, and so by what asks."""
    log = read_log(folder / "sound.csv")
    pose, arm = log.pose.copy(), log.arms["left"]
    pose[500::700, 0] += 40.0
    wrench = arm.wrench.copy()
    wrench[300::900] *= -1e4
    spoiled = replace(log, pose=pose, arms=log.arms | {"left": ArmLog(arm.contact, wrench)})
    assert not [one for one in checked_log(spoiled, load_cart(folder / "cart.yaml")).suspicions if one.is_refused]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda log: replace(log, time=log.time[0] + 1e8 * (log.time - log.time[0])), "times"),
        (lambda log: replace(log, pose=1e200 * log.pose), "SI units"),
        (lambda log: replace(log, pose=np.full_like(log.pose, np.nan)), "rows have a pose"),
    ],
)
def test_what_cannot_be_looked_at_is_not_suspected(folder, change, words):
    """`check` says why; what learns goes on, and says itself what it lacks."""
    log, cart = change(read_log(folder / "sound.csv")), load_cart(folder / "cart.yaml")
    with pytest.raises(DataError, match=words):
        checked_log(log, cart)
    assert check_logs([log], cart, ()) == [None]
