"""Every benchmark runs and writes its tables; how fast anything was is nobody's test."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from benchmarks import cold_start

ROOT = Path(__file__).parents[2]
TITLES = (
    "Allocation at given contacts",
    "Any solver by its name",
    "Bags",
    "Campaign",
    "Choice of contacts",
    "Convex relaxation of the contact choice",
    "Dynamics",
    "Estimators",
    "Filter step",
    "Plants",
    "What postures cost",
    "Start-up",
    "What a tick costs",
    "When to regrasp",
)


@pytest.mark.prove
def test_each_benchmark_runs(tmp_path):
    out = tmp_path / "results" / "benchmarks.md"
    command = [sys.executable, "-m", "benchmarks", "--quick", "--out", str(out)]
    threads = os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, env=threads)
    assert done.returncode == 0, done.stderr
    text = out.read_text(encoding="utf-8")
    assert all(f"## {title}" in text for title in TITLES)
    rows = [line.split(" | ") for line in text.splitlines() if line.startswith("| ") and "---" not in line]
    assert any("WrenchPlanner.plan" in row[0] for row in rows)
    assert any("daqp, bare" in row[0] and row[-1] == "40 of 40 |" for row in rows)
    assert "nan" not in text


def test_a_benchmark_runs(tmp_path):
    out = tmp_path / "results" / "benchmarks.md"
    command = [sys.executable, "-m", "benchmarks", "allocation", "dynamics", "--quick", "--out", str(out)]
    subprocess.run(command, check=True, capture_output=True, text=True, cwd=ROOT)
    text = out.read_text(encoding="utf-8")
    assert "## Allocation at given contacts" in text
    assert "WrenchPlanner.plan" in text
    assert "## Dynamics" in text
    assert "nan" not in text


def test_deadlines_are_told_for_every_status():
    command = [sys.executable, "-m", "benchmarks.deadlines", "--ticks", "60"]
    said = subprocess.run(command, check=True, capture_output=True, text=True, cwd=ROOT).stdout
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in said.splitlines()[2:]]
    assert {row[1] for row in rows} >= {"optimal", "infeasible", "relaxed", "invalid_input", "stale_estimate", "ok"}
    assert all(sum(map(int, row[6:])) == int(row[2]) for row in rows)


def test_a_cold_start_is_told_beside_another():
    one = dict.fromkeys((*cold_start.COLD, *cold_start.WARM, *cold_start.IMPORTS, "first update"), 2.0)
    lines = cold_start.table([one, {name: 2.0 * value for name, value in one.items()}], [one, one])
    assert "| cold: all, s of CPU | 2 | 4 | 0.50 |" in lines
    assert "| plan, median, µs | 2e+06 | 2e+06 | 1.00 |" in lines
