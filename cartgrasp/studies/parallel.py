"""The runs of a study, over processes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack
from typing import TypeVar

Job = TypeVar("Job")
Result = TypeVar("Result")
Progress = Callable[[float], None] | None
"""Is told the share done."""


def run_all(
    run: Callable[[Job], Result],
    jobs: Sequence[Job],
    workers: int = 1,
    progress: Progress = None,
) -> list[Result]:
    """`run` of each job, in their order, over `workers` processes (1: in this one)."""
    results = []
    with ExitStack() as stack:
        mapped = map if workers == 1 else stack.enter_context(ProcessPoolExecutor(workers)).map
        for result in mapped(run, jobs):
            results.append(result)
            if progress is not None:
                progress(len(results) / len(jobs))
    return results
