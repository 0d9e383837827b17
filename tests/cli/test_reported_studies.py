"""`cartgrasp study effort` and `safety` are wired: options go in, table, figure, claims and exit status come out."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.figure import Figure

from cartgrasp.studies import effort, effort_report, safety, safety_report
from cartgrasp.studies.findings import Claim, Findings, Section

from .commands import run


def findings(found):
    """Of runs that are words."""
    promised = [Claim("here", "less", "0.5", found == ["one", "other"])]
    table = Section("By word", ("word", "length"), [(one, str(len(one))) for one in found])
    runs = [{"word": one, "margin": np.pi} for one in found]
    return Findings("Words", [table, Section.of_claims("Claims", promised)], {"runs": runs}, promised)


@pytest.mark.parametrize("found", [["one", "other"], ["none"]])
@pytest.mark.parametrize("as_json", [True, False])
@pytest.mark.parametrize(("study", "report"), [(effort, effort_report), (safety, safety_report)])
def test_they_are_wired(capsys, monkeypatch, tmp_path, study, report, found, as_json):
    asked = []

    def run_seeds(seeds, workers, tell):
        asked.extend(seeds)
        return found

    monkeypatch.setattr(study, "run_seeds", run_seeds)
    monkeypatch.setattr(report, "findings", findings)
    monkeypatch.setattr(report, "figure", lambda found: Figure())
    name, out = study.__name__.rpartition(".")[2], tmp_path / "x"
    flags = ["--json"] if as_json else []
    answer = run(capsys, "study", name, "--seeds", "2", "--seed", "7", "--out", out, *flags)
    assert answer.status == (found == ["none"])
    assert asked == [7, 8]
    assert (out / f"{name}.md").read_text().startswith("# ")
    assert (out / f"{name}.png").exists()
    assert ('"margin"' in answer.out) is as_json


@pytest.mark.parametrize("name", ["effort", "safety"])
def test_no_runs_are_refused(capsys, tmp_path, name):
    run(capsys, "study", name, "--seeds", "0", "--out", tmp_path / "x").refused(2, "--seeds")
