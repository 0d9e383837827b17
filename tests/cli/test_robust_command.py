"""`cartgrasp study robust` is wired: options go in, table, figure, claims and exit status come out."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.figure import Figure

from cartgrasp.studies import robust_margins
from cartgrasp.studies import robust_margins_report as merits
from cartgrasp.studies.findings import Claim

from .commands import run


@pytest.mark.parametrize(("holds", "status"), [(True, 0), (False, 1)])
@pytest.mark.parametrize("as_json", [True, False])
def test_it_is_wired(capsys, monkeypatch, tmp_path, holds, status, as_json):
    asked = []

    def run_seeds(seeds, workers, tell):
        asked.extend(seeds)
        return ["one", "other"]

    monkeypatch.setattr(robust_margins, "run_seeds", run_seeds)
    monkeypatch.setattr(merits, "claims", lambda runs: [Claim("here", "less", "0.5", holds)])
    monkeypatch.setattr(merits, "rows", lambda runs: [(one, *"123456") for one in runs])
    monkeypatch.setattr(merits, "as_dict", lambda one: {"seed": one, "margin": np.pi})
    monkeypatch.setattr(merits, "figure", lambda runs: Figure())
    flags = ["--json"] if as_json else []
    answer = run(capsys, "study", "robust", "--seeds", "2", "--seed", "7", "--out", tmp_path / "x", *flags)
    assert answer.status == status
    assert asked == [7, 8]
    assert (tmp_path / "x" / "robust.md").read_text().startswith("# Robust margins")
    assert (tmp_path / "x" / "robust.png").exists()
    if as_json:
        assert answer.json["kept"] is holds
        assert [one["seed"] for one in answer.json["runs"]] == ["one", "other"]
    else:
        assert "other" in answer.out


def test_no_runs_are_refused(capsys, tmp_path):
    run(capsys, "study", "robust", "--seeds", "0", "--out", tmp_path / "x").refused(2, "--seeds")
