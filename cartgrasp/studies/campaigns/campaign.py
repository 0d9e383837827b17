"""A study run to its end: what is there is left alone, so a campaign that was killed goes on where it was."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from .job import Study
from .results import Results
from .workers import Workers


def run_campaign(
    study: Study, results: Results, workers: Workers, progress: Callable[[float], None] | None = None
) -> list[dict[str, Any]]:
    """All results, in the jobs' order; `progress` is told the share done."""
    jobs = study.jobs()
    keys = [job.key for job in jobs]
    left = [job for job, key in zip(jobs, keys, strict=True) if not results.has(key)]
    for count, done in enumerate(workers(left) if left else (), 1):
        results.keep(done)
        if progress is not None:
            progress((len(jobs) - len(left) + count) / len(jobs))
    return results.read(keys)
