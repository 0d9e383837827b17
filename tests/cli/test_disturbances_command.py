"""`cartgrasp study disturbances` is wired."""

from __future__ import annotations

import pytest

from cartgrasp.studies import disturbances
from cartgrasp.studies import disturbances_report as merits
from cartgrasp.studies.findings import Claim

from .commands import run


@pytest.mark.parametrize(("holds", "status"), [(True, 0), (False, 1)])
def test_it_is_wired(capsys, monkeypatch, tmp_path, holds, status):
    asked = []
    monkeypatch.setattr(disturbances, "run_seeds", lambda seeds, workers, tell: asked.extend(seeds) or ["one"])
    monkeypatch.setattr(merits, "claims", lambda runs: [Claim("push", "less", "0.5", holds)])
    monkeypatch.setattr(merits, "rows", lambda runs: [("push", "ours", *"123456789")])
    monkeypatch.setattr(merits, "as_dict", lambda one: {"way": one})
    out = tmp_path / "x"
    answer = run(capsys, "study", "disturbances", "--runs", "2", "--seed", "7", "--out", out, "--json")
    assert (answer.status, asked, answer.json["kept"]) == (status, [7, 8], holds)
    assert (out / "disturbances.md").read_text().startswith("# Disturbances")
