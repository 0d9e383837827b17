"""An ablation of a workflow that is made up: what is run, what is kept, and the table of what came of it."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace

import pytest

from benchmarks.ablation import __main__ as program
from benchmarks.ablation import running
from benchmarks.ablation.cases import Case, Mark, MeasuredCase, SealedCase, sealed_cases, spread
from benchmarks.ablation.every import CONSTANTS
from benchmarks.ablation.running import Job, Watch, run, unnoticed, wanted
from benchmarks.ablation.table import affected, rows, section
from cartgrasp.errors import DataError
from estimation.discrepancy.search import gains

from .test_sealed_score import CART, effect, entry, report

BY_NAME = {c.full_name: c for c in CONSTANTS}
WORTH, SURE = BY_NAME["gains.MIN_GAIN_NATS"], BY_NAME["gains.GAIN_SIGMAS"]
TURNING = BY_NAME["candidates.DRAGS_TOLD_BY_TURNING"]


@dataclass(frozen=True)
class Made(Case):
    """A log in which something gains so much; it is named from `gains.MIN_GAIN_NATS` on, and should be."""

    gain: float
    kind_: str = "single"
    folder: Path = Path()

    @property
    def name(self):
        return f"gain {self.gain:g}"

    @property
    def kind(self):
        return self.kind_

    @property
    def what(self):
        return "made"

    @property
    def files(self):
        return (self.folder / "run.csv",) if self.folder != Path() else ()

    def read(self):
        return self.gain, None

    def mark(self, report, failure):
        named = bool(report and report["effects"])
        return Mark(named != (self.kind_ == "nothing"), int(named and self.kind_ == "nothing"), 0.01 * self.gain)


@pytest.fixture
def asked(monkeypatch):
    """The gains that were diagnosed, in order, each with MIN_GAIN_NATS (10 here) where it is read."""
    found = []
    monkeypatch.setattr(gains, "MIN_GAIN_NATS", 10.0)

    def diagnose(gain, cart):
        assert cart is None
        found.append((gain, gains.MIN_GAIN_NATS))
        if gain < 0:
            raise DataError("no such gain")
        effects = [{"name": "push", "label": "", "probability": 0.9}] if gain >= gains.MIN_GAIN_NATS else []
        told = {"verdict": "told", "effects": effects, "unexplained": {}, "gap": float("nan"), "other": 1}
        return SimpleNamespace(report=SimpleNamespace(as_dict=lambda: told))

    monkeypatch.setattr(running, "diagnose", diagnose)
    return found


def options_of(kept):
    return SimpleNamespace(kept=kept, processes=1)


def test_a_constant_is_moved_while_a_log_is_diagnosed(asked, tmp_path):
    (_, base), (_, moved) = (run(job, tmp_path) for job in (Job(Made(12.0)), Job(Made(12.0), WORTH, "1.3")))
    assert asked == [(12.0, 10.0), (12.0, 13.0)]
    assert (len(base.report["effects"]), len(moved.report["effects"])) == (1, 0)
    assert base.digest != moved.digest
    assert "other" not in base.report
    assert base.report["gap"] is None  # JSON has no NaN
    assert gains.MIN_GAIN_NATS == 10.0


def test_what_is_kept_is_not_run_again(asked, tmp_path, monkeypatch):
    (tmp_path / "run.csv").write_text("a log")
    kept = tmp_path / "kept"
    job = Job(Made(12.0, folder=tmp_path), WORTH, "0.7")
    first = run(job, kept)
    assert run(job, kept) == first
    assert len(asked) == 1
    (path,) = kept.glob("*.json")
    document = json.loads(path.read_text())
    assert (document["case"], document["constant"], document["move"]) == (
        "single: gain 12",
        "gains.MIN_GAIN_NATS",
        "0.7",
    )
    for number, change in enumerate(
        (
            lambda: run(Job(job.case), kept),
            lambda: run(Job(job.case, WORTH, "1.3"), kept),
            lambda: run(Job(job.case, SURE, "0.7"), kept),
            lambda: (tmp_path / "run.csv").write_text("another log") and run(job, kept),
            lambda: monkeypatch.setattr(running, "code_version", lambda: "another") or run(job, kept),
        ),
        2,
    ):
        change()
        assert len(asked) == number


def test_a_log_that_fails_is_an_answer(asked, tmp_path):
    _, answer = run(Job(Made(-1.0)), tmp_path)
    assert (answer.report, answer.failure) == (None, "no such gain")
    assert run(Job(Made(-1.0)), tmp_path)[1] == answer
    assert len(asked) == 1


def test_what_nothing_notices_is_not_run(asked, tmp_path):
    """A gain of 100 is named whatever WORTH is, one of 12 if it is off or less, one of 5 only if it is off."""
    cases = [Made(100.0), Made(12.0), Made(5.0)]
    answers = program.ablated(cases, [WORTH, SURE], ("off", "0.7", "1.3"), options_of(tmp_path))
    as_it_is, watched, moved = asked[:3], asked[3:6], asked[6:]
    assert as_it_is == [(gain, 10.0) for gain in (100.0, 12.0, 5.0)]
    assert [gain for gain, *_ in watched] == [100.0, 12.0, 5.0]
    assert moved == [(5.0, 0.0), (12.0, 13.0)]
    assert len(answers) == 3 + 3 + 3 * 6
    for case in cases:
        base = answers[Job(case).place]
        for job in wanted([case], [WORTH, SURE], ("off", "0.7", "1.3")):
            direct = run(job, tmp_path)[1]
            assert (direct.digest == base.digest) == (answers[job.place].digest == base.digest)


@pytest.mark.usefixtures("asked")
def test_a_log_that_can_not_be_followed_is_run(monkeypatch):
    case = Made(100.0)
    job, watch = Job(case, WORTH, "0.7"), Watch(case, (WORTH,), ("0.7",))
    base, followed = Job(case).ask(), watch.ask()

    def told(watched):
        return unnoticed(job, {Job(case).place: base, watch.place: watched})

    assert told(followed) is base
    assert told(replace(followed, noticed=((WORTH.full_name, "0.7"),))) is None
    assert told(replace(followed, digest="of another run")) is None
    monkeypatch.setattr(running, "diagnose", lambda *_: {}[gains.MIN_GAIN_NATS])
    lost = watch.ask()
    assert lost.failure.startswith("can't be followed: ")
    assert told(lost) is None


def test_a_constant_that_has_no_such_value_is_not_moved():
    jobs = list(wanted([Made(1.0)], [TURNING, WORTH], ("off", "0.7")))
    assert [(job.constant.name, job.move) for job in jobs] == [
        ("DRAGS_TOLD_BY_TURNING", "off"),
        ("MIN_GAIN_NATS", "off"),
        ("MIN_GAIN_NATS", "0.7"),
    ]


def test_the_table_counts_what_each_value_costs(asked, tmp_path):
    cases = [Made(100.0), Made(12.0), Made(5.0, "nothing")]
    moves = ("off", "0.7", "1.3")
    answers = program.ablated(cases, [WORTH, SURE], moves, options_of(tmp_path))
    text = section(rows(cases, [WORTH, SURE], moves, answers))
    table = [line[2:-2].split(" | ") for line in text.splitlines() if line.startswith("| ")]
    cells = [dict(zip(table[0], line, strict=True)) for line in table[2:]]
    right = [c["right"] for c in cells]
    assert right == ["3 of 3", "2 of 3 (-1)", "3 of 3", "2 of 3 (-1)", "3 of 3", "3 of 3", "3 of 3"]
    assert [c["nothing"] for c in cells[:4]] == ["1/1", "0/1", "1/1", "1/1"]
    assert [c["single"] for c in cells[:4]] == ["2/2", "2/2", "2/2", "1/2"]
    assert [c["false names"] for c in cells[:4]] == ["0", "1", "0", "0"]
    assert {c["mass"] for c in cells} == {"12.00 %"}
    assert [c["to"] for c in cells[1:4]] == ["0", "7", "13"]
    assert cells[1]["changed"] == "1 (1 all)"
    assert "Switched off without any change: `gains.GAIN_SIGMAS`." in text
    assert "Switched off, fewer logs are right: `gains.MIN_GAIN_NATS`." in text
    assert "Moved, they cost more than 1 % of the logs: `gains.MIN_GAIN_NATS`." in text


def test_affected_logs_are_counted(asked, tmp_path):
    """WORTH is 10: as above, and on a log without a gain nothing can be said."""
    cases, moves = [Made(100.0), Made(12.0), Made(5.0), Made(-1.0)], ("off", "1.3")
    text = affected(
        [WORTH, TURNING, SURE], moves, program.watched(cases, [WORTH, TURNING, SURE], moves, options_of(tmp_path))
    )
    assert len(asked) == 4
    counts = {
        line.split(" | ")[0]: line[2:-2].split(" | ")[-2:] for line in text.splitlines() if line.startswith("| `")
    }
    assert counts == {
        "| `gains.MIN_GAIN_NATS`": ["1", "1"],
        "| `candidates.DRAGS_TOLD_BY_TURNING`": ["3", "-"],
        "| `gains.GAIN_SIGMAS`": ["0", "0"],
    }
    assert "Not followed: single: gain -1, no such gain." in text


def test_few_logs_are_of_all_kinds():
    cases = [Made(float(i), kind) for kind, n in (("nothing", 5), ("single", 5), ("pair", 1)) for i in range(n)]
    assert [c.kind for c in spread(cases, 6)] == ["single", "pair", "nothing", "single", "nothing", "single"]
    assert len(spread(cases, 100)) == 11


def sealed_log(folder, name, *effects, **more):
    truth = {"case": "+".join(e["name"] for e in effects) or "nothing", "effects": list(effects), "cart": CART, **more}
    (folder / "truth").mkdir(exist_ok=True)
    (folder / "truth" / f"{name}.json").write_text(json.dumps(truth))


def test_sealed_logs_sit_their_own_exam(tmp_path):
    sealed_log(tmp_path, "a", effect("rolling_resistance"))
    sealed_log(tmp_path, "b", effect("wind", outside=True))
    sealed_log(tmp_path, "c", effect("floor_slope"), proof=True)
    first, second = sealed_cases([tmp_path])
    assert (first.name, first.kind, second.kind) == ("a", "single", "outside")
    told = report("explained", entry("rolling_resistance"), entry("floor_slope"))
    told["parameter_mismatch"] = {"mass": {"nominal": 30.0, "refitted": 21.0, "std": 0.1}}
    assert first.mark(told, "") == Mark(False, 1, 0.05)
    assert first.mark(report("explained", entry("rolling_resistance")), "") == Mark(True, 0, None)
    law = entry("learned_force") | {"law": {"of": "time", "period": None}}
    assert second.mark(report("explained", law), "") == Mark(True, 0, None)
    assert not second.mark(report("unexplained"), "").is_right
    assert first.mark(None, "why") == Mark(False, 0, None)


def test_measured_logs_sit_their_own_exam():
    """A cart that stands, and a wheelchair of 75 to 130 kg with rolling resistance, `measured/truths.py`."""
    by_name = {case.name: case for case in (MeasuredCase(Path("nowhere"), i) for i in range(7))}
    still, chair = by_name["still"], by_name["wheelchair"]
    push = {"name": "external_push", "probability": 0.9, "parameters": {}}
    assert still.mark({"effects": []}, "").is_right
    assert still.mark({"effects": [push]}, "") == Mark(False, 1, None)
    assert still.mark({"effects": [push | {"probability": 0.4}]}, "").wrong == 0
    assert still.mark(None, "why") == Mark(False, 0, None)
    drag = {
        "name": "rolling_resistance",
        "probability": 0.9,
        "parameters": {"coefficient": {"value": 0.014, "std": 0.001}},
    }
    told = {"effects": [drag], "parameter_mismatch": {"mass": {"refitted": 100.0, "std": 5.0}}}
    assert chair.mark(told, "").is_right
    told["parameter_mismatch"]["mass"]["refitted"] = 30.0
    assert not chair.mark(told, "").is_right


def test_cases_can_be_told_apart_by_what_they_follow_from(tmp_path):
    sealed_log(tmp_path, "a", effect("rolling_resistance"))
    case = SealedCase(tmp_path, "a")
    assert [p.name for p in case.files] == ["run.csv", "cart.yaml"]


def test_the_program_says_what_it_can_not_do(capsys, monkeypatch, tmp_path):
    def exits(*words):
        monkeypatch.setattr("sys.argv", ["ablation", *words])
        with pytest.raises(SystemExit):
            program.main()
        return capsys.readouterr().err

    nowhere = ("--data", str(tmp_path / "none"))
    assert "no logs: give folders" in exits(*nowhere)
    assert "in the name of no constant" in exits("--only", "NOTHING_OF_THIS_NAME", *nowhere)
    assert "only a, b, r are ablated" in exits("--groups", "c", *nowhere)
    assert "is no factor" in exits("--moves", "off,-1", *nowhere)
    monkeypatch.setattr("sys.argv", ["ablation", "--list"])
    program.main()
    listed = capsys.readouterr().out.splitlines()
    assert len(listed) == len(CONSTANTS) + 2
    assert any(line.startswith("| `gains.MIN_GAIN_NATS` | a | 10 | 0 | ") for line in listed)
