"""Many independent jobs over a few processes, none of which can stop the others."""

from __future__ import annotations

import os
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context, parent_process
from threading import Thread

from geohue.jobs.outcome import DIED, Job, Outcome, Result, attempt, error_text

__all__ = ["Outcome", "one_thread", "run_jobs"]


def run_jobs(
    function: Callable[[Job], Result],
    jobs: Sequence[Job],
    processes: int = 1,
    scheduler: str | None = None,
) -> Iterator[Outcome[Job, Result]]:
    """Run `function` on every job.

    A job that raises, or whose process dies, gives an outcome with an error; all others run. The
    numerical libraries of each process keep to one thread. Where the jobs run does not change
    their results.

    Parameters
    ----------
    function : callable
        Importable by name, as its process imports it.
    jobs : sequence
        What it is called with.
    processes : int
        How many work at a time; with 1 the jobs run in the calling process, in order.
    scheduler : str, optional
        Address of a dask scheduler, such as ``"tcp://10.0.0.1:8786"``: its workers run the jobs,
        and `processes` counts for nothing. They see the same files under the same names.

    Yields
    ------
    Outcome
        As jobs end.

    Raises
    ------
    GeohueError
        If the scheduler cannot be reached, has no workers or ones with another geohue.

    Examples
    --------
    >>> [outcome.result for outcome in run_jobs(abs, [-1, 2])]
    [1, 2]
    """
    if scheduler is not None:
        from geohue.jobs.cluster import run_on_cluster

        yield from run_on_cluster(function, jobs, scheduler)
        return
    if processes == 1:
        for job in jobs:
            yield attempt(function, job)
        return
    lost: list[Job] = []
    rest = list(jobs)
    while rest:
        rest = yield from _run_pool(function, rest, processes, lost)
    # One of these took its process down, and the others with it: each gets one of its own.
    for job in lost:
        alone: list[Job] = []
        yield from _run_pool(function, [job], 1, alone)
        for victim in alone:
            yield Outcome(victim, None, DIED)


def _run_pool(
    function: Callable[[Job], Result], jobs: list[Job], processes: int, lost: list[Job]
) -> Generator[Outcome[Job, Result], None, list[Job]]:
    """Run jobs until all are done or a process dies; returns those not begun.

    Those under way when a process died are added to `lost`.
    """
    waiting = jobs[::-1]
    running: dict[Future[Result], Job] = {}
    pool = ProcessPoolExecutor(processes, get_context("spawn"), initializer=_begin)
    try:
        while waiting or running:
            while waiting and len(running) < processes:
                try:
                    future = pool.submit(function, waiting[-1])
                except BrokenProcessPool:  # a process died while the caller had the last outcome
                    lost += running.values()
                    return waiting[::-1]
                running[future] = waiting.pop()
            done, _ = wait(running, return_when=FIRST_COMPLETED)
            for future in done:
                error = future.exception()
                if isinstance(error, BrokenProcessPool):
                    lost += running.values()
                    return waiting[::-1]
                job = running.pop(future)
                if error is None:
                    yield Outcome(job, future.result(), None)
                else:
                    yield Outcome(job, None, error_text(error))
    finally:
        pool.shutdown(wait=True, cancel_futures=True)
    return []


def _begin() -> None:
    """Prepare a process of the pool."""
    one_thread()
    Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    """End this process when the one that started it is killed: nobody else would."""
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def one_thread() -> None:
    """Keep this process's numerical libraries to one thread each."""
    import cv2
    from threadpoolctl import threadpool_limits

    threadpool_limits(1)
    cv2.setNumThreads(1)
