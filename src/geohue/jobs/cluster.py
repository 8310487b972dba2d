"""Many independent jobs over the workers of a dask.distributed cluster."""

from __future__ import annotations

import logging
import pickle
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from itertools import islice
from queue import Empty, SimpleQueue
from threading import Lock
from typing import Any

from geohue._version import __version__
from geohue.errors import GeohueError
from geohue.jobs.crew import LOOK_S, Crew
from geohue.jobs.outcome import Job, Outcome, Result, attempt, error_text
from geohue.read.extras import optional
from geohue.read.files import reason

CONNECT_S = 5.0
"""Seconds in which a scheduler must answer."""

_DIED = "the process died (out of memory?)"
_TURN = Lock()  # one job at a time in a process, whose threads share limits and warning filters


def run_on_cluster(
    function: Callable[[Job], Result], jobs: Sequence[Job], scheduler: str
) -> Iterator[Outcome[Job, Result]]:
    """Run `function` on every job, on the workers of a cluster.

    A worker that dies loses nothing: the scheduler gives its jobs to others. A job that takes down
    every worker it comes to, as often as the scheduler's ``allowed-failures`` says, is tried alone
    once all others are done, and then gives an outcome with an error.

    Parameters
    ----------
    function : callable
        Importable by name on the workers.
    jobs : sequence
        What it is called with.
    scheduler : str
        The scheduler's address.

    Yields
    ------
    Outcome
        As jobs end.

    Raises
    ------
    GeohueError
        If the scheduler cannot be reached or goes away, no worker is there for a minute, or a
        worker has another version of geohue.

    Examples
    --------
    >>> from distributed import LocalCluster
    >>> small = dict(n_workers=1, threads_per_worker=1, processes=False, dashboard_address=":0")
    >>> with LocalCluster(**small) as cluster:
    ...     found = list(run_on_cluster(abs, [-1, 2], cluster.scheduler_address))
    >>> sorted(outcome.result for outcome in found)
    [1, 2]
    """
    if not jobs:
        return
    with _connected(scheduler) as client:
        crew = Crew(client, scheduler)
        lost: list[Job] = []
        yield from _stream(crew, function, jobs, lost)
        # Some of these died with a neighbour only: each gets a cluster of its own.
        for job in lost:
            alone: list[Job] = []
            yield from _stream(crew, function, [job], alone)
            for victim in alone:
                yield Outcome(victim, None, _DIED)


@contextmanager
def _connected(scheduler: str) -> Iterator[Any]:
    distributed = optional("distributed", "distributed", f"scheduler {scheduler}")
    try:
        _check_address(distributed, scheduler)
        client = distributed.Client(
            scheduler, timeout=CONNECT_S, set_as_default=False, name="geohue"
        )
    except (OSError, ValueError, TypeError) as error:
        raise GeohueError(
            f"{scheduler}: no dask scheduler to be reached ({reason(error)}); start one with "
            "'dask scheduler' and give its tcp://HOST:PORT"
        ) from error
    # What dask's client has to tell of a lost connection, tracebacks and all, an error tells.
    logger = logging.getLogger("distributed.client")
    before = logger.level
    logger.setLevel(logging.CRITICAL)
    try:
        with client:
            yield client
    finally:
        logger.setLevel(before)


def _check_address(distributed: Any, address: str) -> None:
    """Raise a ValueError for an address that no scheduler can have.

    A client that is given one waits for ten seconds at the exit and leaves a traceback there.
    """
    scheme, _ = distributed.comm.parse_address(address)
    distributed.comm.registry.get_backend(scheme)
    if scheme in ("tcp", "tls"):
        distributed.comm.get_address_host_port(address)
    if scheme == "tls":
        known = distributed.Security().get_connection_args("client")
        if known["ssl_context"] is None:
            raise ValueError("dask's configuration names no certificates for TLS")


def _stream(
    crew: Crew, function: Callable[[Job], Result], jobs: Sequence[Job], lost: list[Job]
) -> Iterator[Outcome[Job, Result]]:
    """Run jobs, a few for each worker under way; those that killed their workers go to `lost`."""
    waiting = iter(jobs)
    running: dict[str, tuple[Any, Job]] = {}
    ended: SimpleQueue[Any] = SimpleQueue()
    while True:
        for job in islice(waiting, max(0, crew.window - len(running))):
            future = _submit(crew, function, job)
            running[future.key] = future, job
            future.add_done_callback(ended.put)
        if not running:
            return
        done = _take(ended)
        those = [running.pop(future.key)[1] for future in done]
        for job, outcome in zip(those, _outcomes(crew, done, those), strict=True):
            if outcome is None:
                lost.append(job)
            else:
                yield outcome


def _take(queue: SimpleQueue[Any]) -> list[Any]:
    """Return all that is in a queue, none if nothing comes for a while."""
    try:
        found = [queue.get(timeout=LOOK_S)]
        while not queue.empty():
            found.append(queue.get())
    except Empty:
        return []
    return found


def _submit(crew: Crew, function: Callable[[Job], Result], job: Job) -> Any:
    # As bytes: dask looks into what it is given for tasks and collections of its own.
    try:
        return crew.client.submit(_call, __version__, pickle.dumps((function, job)), pure=False)
    except (OSError, RuntimeError) as error:
        raise crew.gone() from error


def _outcomes(
    crew: Crew, futures: list[Any], jobs: list[Job]
) -> Iterator[Outcome[Job, Any] | None]:
    """Return what became of jobs that have ended; None for one that killed its workers."""
    try:
        # One message for all: a message each is what would keep a large cluster waiting.
        answers = crew.wait(lambda: crew.client.gather(futures, asynchronous=True))
    except GeohueError:
        raise
    except Exception:
        answers = [_answer(crew, future) for future in futures]
    for job, answer in zip(jobs, answers, strict=True):
        if answer is None:
            yield None
            continue
        version, result, error = answer
        crew.check_version(version, "a worker that joined later")
        yield Outcome(job, result, error)


def _answer(crew: Crew, future: Any) -> tuple[str, Any, str | None] | None:
    """Return what `_call` has returned; None if it killed its workers."""
    from concurrent.futures import CancelledError

    from distributed.scheduler import KilledWorker

    try:
        answer: tuple[str, Any, str | None]
        (answer,) = crew.wait(lambda: crew.client.gather([future], asynchronous=True))
    except KilledWorker:
        return None
    except (CancelledError, OSError) as problem:
        raise crew.gone() from problem
    except Exception as problem:  # such as a result that cannot be sent
        return __version__, None, error_text(problem)
    return answer


def _call(version: str, payload: bytes) -> tuple[str, Any, str | None]:
    """Run a job on a worker; returns the worker's version, the result and the error."""
    if version != __version__:
        return __version__, None, None
    with _TURN:
        try:
            function, job = pickle.loads(payload)
        except Exception as error:
            return __version__, None, error_text(error)
        _, result, error_line = attempt(function, job)
        return __version__, result, error_line
