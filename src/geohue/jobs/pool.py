"""Many independent jobs over a few processes, none of which can stop the others."""

from __future__ import annotations

import os
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context, parent_process
from threading import Thread
from typing import Generic, NamedTuple, TypeVar

Job = TypeVar("Job")
Result = TypeVar("Result")


class Outcome(NamedTuple, Generic[Job, Result]):
    """What became of a job: its result, or the text of what went wrong."""

    job: Job
    result: Result | None
    error: str | None


def run_jobs(
    function: Callable[[Job], Result], jobs: Sequence[Job], processes: int = 1
) -> Iterator[Outcome[Job, Result]]:
    """Run `function` on every job.

    A job that raises, or whose process dies, gives an outcome with an error; all others run. The
    numerical libraries of each process keep to one thread.

    Parameters
    ----------
    function : callable
        Importable by name, as its process imports it.
    jobs : sequence
        What it is called with.
    processes : int
        How many work at a time; with 1 the jobs run in the calling process, in order.

    Yields
    ------
    Outcome
        As jobs end.

    Examples
    --------
    >>> [outcome.result for outcome in run_jobs(abs, [-1, 2])]
    [1, 2]
    """
    if processes == 1:
        for job in jobs:
            yield _attempt(function, job)
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
            yield Outcome(victim, None, "the process died (out of memory?)")


def _attempt(function: Callable[[Job], Result], job: Job) -> Outcome[Job, Result]:
    from threadpoolctl import threadpool_limits

    try:
        with threadpool_limits(1):
            return Outcome(job, function(job), None)
    except Exception as error:  # any failure is a result here
        return Outcome(job, None, _text(error))


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
                job = waiting.pop()
                running[pool.submit(function, job)] = job
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
                    yield Outcome(job, None, _text(error))
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


def _text(error: BaseException) -> str:
    return " ".join(f"{type(error).__name__}: {error}".split())


def one_thread() -> None:
    """Keep this process's numerical libraries to one thread each."""
    import cv2
    from threadpoolctl import threadpool_limits

    threadpool_limits(1)
    cv2.setNumThreads(1)
