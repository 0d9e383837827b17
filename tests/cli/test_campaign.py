"""`cartgrasp campaign`: studies go in, results, summary, figure and exit status come out."""

from __future__ import annotations

import json

from .commands import CART, run
from .pushed_cart import as_csv, pushed_cart

RUNS = """\
name: few [runs]
runs: 2
closed_loop:
  cart: cart.yaml
  duration: 1.0
  arms:
    - {name: hand, contacts: [[-0.25, 0.0, 1.0]], limits: {force: [90, 60, 60], moment: [20, 20, 20]}}
drawn:
  mass: {uniform: [15, 45]}
"""
LOGS = """\
logs:
  files: ["*.csv"]
  cart: cart.yaml
"""


def study(folder, text):
    (folder / "cart.yaml").write_text(CART, encoding="utf-8")
    (folder / "study.yaml").write_text(text, encoding="utf-8")
    return folder / "study.yaml"


def test_runs_of_drawn_carts(capsys, tmp_path):
    path, out = study(tmp_path, RUNS), tmp_path / "out"
    answer = run(capsys, "campaign", path, "--out", out, "--workers", 1)
    assert answer.status == 0
    assert "few [runs]: 2 runs, 100.0 % of the plans optimal" in answer.out
    assert "mass, kg" in answer.out
    assert (out / "campaign.png").is_file()
    assert len(list((out / "results").iterdir())) == 2
    again = run(capsys, "campaign", path, "--out", out, "--workers", 1, "--json")
    assert again.json == json.loads((out / "campaign.json").read_text())
    mass = again.json["parameters"][0]
    assert (mass["name"], mass["unit"], mass["runs"]) == ("mass", "kg", 2)
    assert again.json["tracking"]["rms"]["largest"] < 0.05


def test_logs_of_which_one_is_none(capsys, tmp_path):
    path, out = study(tmp_path, LOGS), tmp_path / "out"
    (tmp_path / "a.csv").write_text(as_csv(pushed_cart()[:300]))
    (tmp_path / "b.csv").write_text("t,x\n1,2\n")
    answer = run(capsys, "campaign", path, "--out", out, "--workers", 1, "--json")
    assert answer.status == 1
    assert "1 failed" in answer.err
    assert "b.csv" in answer.err
    good, bad = answer.json["logs"]
    assert good["log"].endswith("a.csv")
    alone = run(capsys, "estimate", tmp_path / "a.csv", "--cart", tmp_path / "cart.yaml", "--json").json
    assert good["mass"] == alone["parameters"]["mass"]["value"]
    assert answer.json["parameters"]["mass"]["logs"] == 1
    assert "failure" in bad
    assert "1 failed" in run(capsys, "campaign", path, "--out", out, "--workers", 1).err


def test_it_refuses(capsys, tmp_path):
    path = study(tmp_path, RUNS)
    run(capsys, "campaign", tmp_path / "no.yaml").refused(2, "no.yaml")
    run(capsys, "campaign", path, "--workers", 0).refused(2, "--workers")
    run(capsys, "campaign", path, "--out", path).refused(2, "--out", "name another folder")
    path.write_text(RUNS.replace("runs: 2", "rums: 2"))
    run(capsys, "campaign", path, "--out", tmp_path / "o").refused(2, "study.yaml:2:1", "rums")
    assert not (tmp_path / "o").exists()
