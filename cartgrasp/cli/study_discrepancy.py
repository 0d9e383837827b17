"""`cartgrasp study discrepancy FOLDER`."""

from __future__ import annotations

from pathlib import Path

from ..studies.findings import Findings, Section
from ..studies.log_diagnoses import COLUMNS, claims, diagnose_all, log_folders
from .output import progress
from .study_report import finish, usual_workers


def run(folder: Path, jobs: int | None, as_json: bool) -> int:
    count = len(log_folders(folder))
    with progress(f"diagnosing {count} logs") as tell:
        found = diagnose_all(folder, min(jobs or usual_workers(), count), tell)
    promised = claims(found)
    sections = [
        Section("Diagnoses", COLUMNS, [one.cells for one in found], left=3),
        Section.of_claims("Claims", promised),
    ]
    told = Findings("Discrepancies", sections, {"logs": [one.as_dict() for one in found]}, promised)
    return finish("discrepancy", str(folder), told, folder, as_json)
