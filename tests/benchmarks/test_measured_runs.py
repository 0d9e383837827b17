"""The commands on a made log in place of a measured one: what they say is kept, and what fails is a row."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from benchmarks.measured import __main__ as program
from benchmarks.measured import carts, running
from benchmarks.measured.logs import LOGS, MeasuredLog
from benchmarks.measured.running import Job, jobs_of, run
from benchmarks.measured.truths import Interval, Truth
from benchmarks.measured.variants import AS_IT_IS, VARIANTS
from cartgrasp.effects import RollingResistance
from cartgrasp.logs import write_log

from .measured_logs import DATA, needs_data, pushed_on_a_rail

CART = carts.on_a_rail("made", 14.0, 1.0).with_effect(RollingResistance(0.01))
MADE = MeasuredLog("made", "made.csv", CART, Truth(mass=Interval(19.5, 20.5, "kg", "as it was made")))
GUESSED = next(variant for variant in VARIANTS if variant.guess == 3.0)
HALF = next(variant for variant in VARIANTS if variant.name == "half the rows")


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    """A folder with one log."""
    folder = tmp_path_factory.mktemp("data")
    write_log(pushed_on_a_rail(), folder / MADE.path)
    return folder


def test_what_a_command_says_is_kept(data, tmp_path, monkeypatch):
    monkeypatch.setattr(running, "COMMANDS", ("identify",))
    job = Job(MADE, HALF, data, tmp_path / "kept")
    found = run(job)
    assert found.errors == ()
    mass = found.said("identify")["parameters"]["mass"]
    assert abs(mass["value"] - 20.0) < max(3 * mass["std"], 0.3)
    (kept,) = job.kept.glob("*.json")
    document = json.loads(kept.read_text())
    assert (document["log"], document["variant"]) == ("made", "half the rows")
    document["identify"]["seconds"] = 1234.5
    kept.write_text(json.dumps(document))
    assert run(job).answers["identify"].seconds == 1234.5
    other = replace(MADE, cart=carts.guessed(CART, 15.0))
    monkeypatch.setattr(running, "_asked", lambda *_: running.Answer(error="asked anew"))
    assert run(replace(job, log=other)).errors == ("identify: asked anew",)
    monkeypatch.setattr(running, "code_version", lambda: "another")
    assert run(job).errors == ("identify: asked anew",)


def test_what_a_command_refuses_is_its_last_words(data, tmp_path, monkeypatch):
    monkeypatch.setattr(running, "COMMANDS", ("identify",))
    (data / "broken.csv").write_text("t,x,y,theta\n0,0,0,zero\n")
    broken = replace(MADE, name="broken", path="broken.csv")
    (error,) = run(Job(broken, AS_IT_IS, data, tmp_path)).errors
    assert error.startswith("identify: status 3, ")
    assert "broken.csv" in error
    assert str(data) not in error
    (unread,) = run(Job(broken, HALF, data, tmp_path)).errors
    assert "broken.csv" in unread
    assert str(data) not in unread


def test_what_takes_too_long_is_ended(data, tmp_path, monkeypatch):
    monkeypatch.setattr(running, "LONGEST", 0.05)
    (error,) = run(Job(MADE, AS_IT_IS, data, tmp_path)).errors
    assert error == "estimate, identify, discrepancy: has not ended after 0.05 s"


def test_what_is_slow_is_asked_again_and_the_shorter_time_told(monkeypatch):
    times = iter([30.0, 4.0])
    monkeypatch.setattr(running, "_asked_once", lambda *_: running.Answer({"of": "both"}, seconds=next(times)))
    assert running._asked("identify", *[None] * 3).seconds == 4.0


def test_guesses_are_of_the_true_mass_where_it_is_known(tmp_path):
    assert Job(MADE, AS_IT_IS, tmp_path, tmp_path).guess == 14.0
    assert Job(MADE, GUESSED, tmp_path, tmp_path).guess == 60.0
    given = replace(MADE, truth=Truth(mass=None))
    assert Job(given, GUESSED, tmp_path, tmp_path).guess == 42.0


def test_logs_as_they_are_come_first(tmp_path):
    jobs = jobs_of(LOGS, tmp_path, tmp_path, with_variants=True)
    assert [job.log for job in jobs[: len(LOGS)]] == list(LOGS)
    assert all(job.variant is AS_IT_IS for job in jobs[: len(LOGS)])
    assert not any(job.variant is AS_IT_IS for job in jobs[len(LOGS) :])
    assert len(jobs_of(LOGS, tmp_path, tmp_path, with_variants=False)) == len(LOGS)


def test_the_program_writes_what_it_prints(data, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(program, "LOGS", (MADE,))
    monkeypatch.setattr(running, "_asked", lambda *_: running.Answer(error="status 3, no"))
    out = tmp_path / "new" / "section.md"
    words = ["measured", "--data", str(data), "--kept", str(tmp_path / "kept"), "--out", str(out)]
    monkeypatch.setattr("sys.argv", [*words, "--processes", "1", "--only", "as it is", "half"])
    program.main()
    printed = capsys.readouterr()
    assert out.read_text() == printed.out.removesuffix("\n")
    assert "- made, half the rows: estimate, identify, discrepancy: status 3, no" in printed.out
    assert "[2/2] made, half the rows: " in printed.err or "[2/2] made, as it is: " in printed.err
    monkeypatch.setattr("sys.argv", [*words, "--only", "nothing such"])
    with pytest.raises(SystemExit, match="nothing such"):
        program.main()
    monkeypatch.setattr("sys.argv", ["measured", "--data", str(tmp_path / "none")])
    with pytest.raises(SystemExit, match="no such folder"):
        program.main()


@needs_data
@pytest.mark.parametrize("log", LOGS, ids=lambda log: log.name)
def test_each_measured_log_is_there(log):
    assert (DATA / log.path).is_file()
