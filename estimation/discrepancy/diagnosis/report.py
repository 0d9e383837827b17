"""What a diagnosis leaves behind: report.json, cart.yaml, report.html and figures."""

from __future__ import annotations

import json
import os
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cartgrasp.strict_json import finite
from cartgrasp.writing import together, write_atomically

from ..findings.verdicts import verdict

if TYPE_CHECKING:
    from ..search.model import Model
    from ..search.scored_candidates import SearchStep
    from .diagnosis import Diagnosis


class Report:
    """Report of one diagnosis."""

    def __init__(self, diagnosis: Diagnosis) -> None:
        self.diagnosis = diagnosis

    def as_dict(self) -> dict[str, Any]:
        found = self.diagnosis
        return {
            "verdict": found.verdict,
            "sentence": found.sentence,
            "warnings": list(found.warnings),
            "where": [asdict(one) for one in found.where],
            "effects": [effect.as_dict() for effect in found.effects],
            "named": found.named_share,
            "parameter_mismatch": found.parameter_mismatch,
            "unexplained": found.unexplained,
            "gap": found.gap.as_dict(),
            "impacts": [one.as_dict() for one in found.impacts],
            "refit_refused": found.is_refused,
            "steps": [_of_step(step, found.final) for step in found.steps],
            "logs": [asdict(check) for check in found.checks],
            "bands": [None if band is None else asdict(band) for band in found.bands],
            "isolability": {key: one.as_dict() for key, one in found.isolability.items()},
            "residual_maps": [one.as_dict() for one in found.residual_maps],
            "next_experiment": list(found.next_experiment.words),
            "next_reference": None if found.next_reference is None else asdict(found.next_reference),
        }

    def save(self, folder: str | os.PathLike[str]) -> Path:
        """Writes all into a folder, which is made, all at one go; the last is report.json."""
        from .figures import figures
        from .page import page

        folder = Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        drawn = figures(self.diagnosis)
        with together():
            for name, svg in drawn.items():
                write_atomically(folder / f"{name}.svg", svg)
            self.diagnosis.cart.save(folder / "cart.yaml")
            write_atomically(folder / "report.html", page(self, drawn))
            document = json.dumps(finite(self.as_dict()), indent=1, allow_nan=False)
            write_atomically(folder / "report.json", document + "\n")
        return folder


def _of_step(step: SearchStep, final: Model) -> dict[str, Any]:
    told = (
        {
            "name": one.candidate.name,
            "key": one.key,
            "score": float(one.gain),
            "tried": one.tried,
            "verdict": verdict(step, one, final),
        }
        for one in step.attempts
    )
    return {"added": step.added.key if step.added else None, "candidates": list(told)}
