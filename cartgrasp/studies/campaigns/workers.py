"""Where jobs are done: in this process, over cores (joblib), or on a cluster (dask.distributed)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

from ...errors import CartgraspError, UsageError
from .job import Job, JobResult, code_version, work

Workers = Callable[[Sequence[Job]], Iterator[JobResult]]
"""Yields what is done as it gets done, in any order."""

CONNECT_TIMEOUT = 10
"""s."""
MAX_WORKER_LOSSES = 3
"""Times in a row that workers may die without anything done."""


def here(jobs: Sequence[Job]) -> Iterator[JobResult]:
    """One after the other."""
    for job in jobs:
        yield work(job, code_version())


def over_cores(count: int) -> Workers:
    """Over so many processes. When one is killed, what was under way is done again."""

    def done(jobs: Sequence[Job]) -> Iterator[JobResult]:
        from joblib.externals.loky.process_executor import TerminatedWorkerError

        left, losses = {job.key: job for job in jobs}, 0
        while left:
            before = len(left)
            try:
                for one in _in_processes(list(left.values()), count):
                    del left[one.key]
                    yield one
            except TerminatedWorkerError:
                losses = losses + 1 if len(left) == before else 0
                if losses == MAX_WORKER_LOSSES:
                    why = "is there memory enough? try fewer with --workers"
                    raise CartgraspError(f"campaign: worker processes died {losses} times in a row; {why}") from None

    return here if count == 1 else done


def on_cluster(address: str) -> Workers:
    """On the workers of a Dask scheduler, which does again what a killed one had."""

    def done(jobs: Sequence[Job]) -> Iterator[JobResult]:
        from distributed import as_completed
        from distributed.scheduler import KilledWorker

        version = code_version()
        with _client(address) as client:
            futures = [client.submit(work, job, version, key=f"cartgrasp-{job.key}", pure=False) for job in jobs]
            try:
                for future in as_completed(futures, loop=client.loop):
                    yield future.result()
                    future.release()
            except KilledWorker as error:
                raise CartgraspError(f"campaign: a job killed each worker that it was given to: {error}") from error

    return done


def _in_processes(jobs: Sequence[Job], count: int) -> Iterator[JobResult]:
    from joblib import Parallel, delayed, parallel_config

    version = code_version()
    with parallel_config(backend="loky", inner_max_num_threads=1):
        parallel = Parallel(n_jobs=min(count, len(jobs)), return_as="generator_unordered", batch_size=1)
        yield from parallel(delayed(work)(job, version) for job in jobs)


def _client(address: str) -> Any:
    try:
        from distributed import Client
    except ImportError as error:
        raise UsageError("--scheduler needs Dask: in cartgrasp's clone, pip install '.[dask]'") from error
    try:
        return Client(address, timeout=CONNECT_TIMEOUT, set_as_default=False)
    except (OSError, ValueError) as error:
        why = "no scheduler answers there; start one with `dask scheduler`"
        raise UsageError(f"--scheduler {address}: {why} ({error})") from error
