"""The runs of a study, over processes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from typing import TypeVar

Job = TypeVar("Job")
Result = TypeVar("Result")


def run_all(
    run: Callable[[Job], Result],
    jobs: Sequence[Job],
    workers: int = 1,
    progress: Callable[[float], None] | None = None,
) -> list[Result]:
    """`run` of each job, in their order, over `workers` processes (1: in this one); `progress` is told the share."""
    results = []
    for result in _mapped(run, jobs, workers):
        results.append(result)
        if progress is not None:
            progress(len(results) / len(jobs))
    return results


def _mapped(run: Callable[[Job], Result], jobs: Sequence[Job], workers: int) -> Iterator[Result]:
    if workers == 1:
        yield from map(run, jobs)
        return
    with ProcessPoolExecutor(workers) as pool:
        yield from pool.map(run, jobs)
