"""`cartgrasp study excitation` is wired: options go in, table, figure, claims and exit status come out."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.figure import Figure

from cartgrasp.studies import excitation
from cartgrasp.studies import excitation_report as merits
from cartgrasp.studies.findings import Claim

from .commands import run


@pytest.mark.parametrize(("holds", "status"), [(True, 0), (False, 1)])
@pytest.mark.parametrize("as_json", [True, False])
def test_it_is_wired(capsys, monkeypatch, tmp_path, holds, status, as_json):
    asked = []

    def run_seeds(seeds, workers, tell):
        asked.extend(seeds)
        return ["fixed", "chosen"]

    monkeypatch.setattr(excitation, "run_seeds", run_seeds)
    monkeypatch.setattr(merits, "claims", lambda drives: [Claim("here", "less", "0.5", holds)])
    monkeypatch.setattr(merits, "price_rows", lambda: [tuple("1234567")])
    monkeypatch.setattr(merits, "rows", lambda drives: [(d, *"123456") for d in drives])
    monkeypatch.setattr(merits, "as_dict", lambda drive: {"way": drive, "effort": np.pi})
    monkeypatch.setattr(merits, "figure", lambda drives: Figure())
    flags = ["--json"] if as_json else []
    answer = run(capsys, "study", "excitation", "--seeds", "2", "--seed", "7", "--out", tmp_path / "x", *flags)
    assert answer.status == status
    assert asked == [7, 8]
    assert (tmp_path / "x" / "excitation.md").read_text().startswith("# Excitation")
    assert (tmp_path / "x" / "excitation.png").exists()
    if as_json:
        assert answer.json["kept"] is holds
        assert [way["way"] for way in answer.json["ways"]] == ["fixed", "chosen"]
    else:
        assert "chosen" in answer.out


def test_no_runs_are_refused(capsys, tmp_path):
    run(capsys, "study", "excitation", "--seeds", "0", "--out", tmp_path / "x").refused(2, "--seeds")
