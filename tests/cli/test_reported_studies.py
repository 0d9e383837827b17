"""`cartgrasp study effort` and `safety` are wired: options go in, table, figure, claims and exit status come out."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.figure import Figure

from cartgrasp.cli import study_report
from cartgrasp.studies.claims import Claim

from .commands import run


class Report:
    """Of runs that are words."""

    def tables(self, found):
        return [("By word", ("word", "length"), [(one, str(len(one))) for one in found])]

    def claims(self, found):
        return [Claim("here", "less", "0.5", found == ["one", "other"])]

    def as_dict(self, one):
        return {"word": one, "margin": np.pi}

    def figure(self, found):
        return Figure()


@pytest.mark.parametrize("found", [["one", "other"], ["none"]])
@pytest.mark.parametrize("as_json", [True, False])
def test_they_are_wired(capsys, tmp_path, found, as_json):
    asked = []

    def run_seeds(seeds, workers, tell):
        asked.extend(seeds)
        return found

    out = tmp_path / "x"
    status = study_report.run_study(("words", "Words"), run_seeds, Report(), out, as_json, 7, 2)
    assert status == (found == ["none"])
    assert asked == [7, 8]
    assert (out / "words.md").read_text().startswith("# Words")
    assert (out / "words.png").exists()
    assert ('"margin"' in capsys.readouterr().out) is as_json


@pytest.mark.parametrize("name", ["effort", "safety"])
def test_no_runs_are_refused(capsys, tmp_path, name):
    run(capsys, "study", name, "--seeds", "0", "--out", tmp_path / "x").refused(2, "--seeds")
