"""Every benchmark runs and writes its tables; how fast anything was is nobody's test."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
TITLES = (
    "Allocation at given contacts",
    "Bags",
    "Campaign",
    "Choice of contacts",
    "Convex relaxation of the contact choice",
    "Dynamics",
    "Estimators",
    "Filter step",
    "Plants",
    "Start-up",
    "What a tick costs",
    "When to regrasp",
)


def test_each_benchmark_runs(tmp_path):
    out = tmp_path / "results" / "benchmarks.md"
    command = [sys.executable, "-m", "benchmarks", "--quick", "--out", str(out)]
    threads = os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    subprocess.run(command, check=True, capture_output=True, cwd=ROOT, env=threads)
    text = out.read_text(encoding="utf-8")
    assert all(f"## {title}" in text for title in TITLES)
    rows = [line.split(" | ") for line in text.splitlines() if line.startswith("| ") and "---" not in line]
    assert any("WrenchPlanner.plan" in row[0] for row in rows)
    assert any("daqp, bare" in row[0] and row[-1] == "40 of 40 |" for row in rows)
    assert "nan" not in text
