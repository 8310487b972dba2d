"""Many independent jobs, wherever they run, none of which can stop the others."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from geohue.errors import GeohueError
from geohue.jobs.outcome import Job, Outcome, Result, attempt
from geohue.jobs.processes import run_in_processes

__all__ = ["Outcome", "run_jobs"]


def run_jobs(
    function: Callable[[Job], Result],
    jobs: Sequence[Job],
    processes: int = 1,
    scheduler: str | None = None,
    timeout: float | None = None,
) -> Iterator[Outcome[Job, Result]]:
    """Run `function` on every job.

    A job that raises, takes too long, or whose process dies, gives an outcome with an error; all
    others run. The numerical libraries keep to one thread in each process. Where the jobs run does
    not change their results.

    Parameters
    ----------
    function : callable
        Importable by name, as its process imports it, or a `functools.partial` of one.
    jobs : sequence
        What it is called with.
    processes : int
        How many work at a time; with 1 and no `timeout` the jobs run in the calling process, in
        order.
    scheduler : str, optional
        Address of a dask scheduler, such as ``"tcp://10.0.0.1:8786"``: its workers run the jobs,
        and `processes` counts for nothing. They see the same files under the same names.
    timeout : float, optional
        Seconds for one job; not with a scheduler, whose workers cannot be ended by us.

    Yields
    ------
    Outcome
        As jobs end.

    Raises
    ------
    GeohueError
        If the scheduler cannot be reached, has no workers or ones with another geohue; for a
        timeout that is not positive, or beside a scheduler.

    Examples
    --------
    >>> [outcome.result for outcome in run_jobs(abs, [-1, 2])]
    [1, 2]
    """
    check_timeout(timeout, scheduler)
    if scheduler is not None:
        from geohue.jobs.cluster import run_on_cluster

        yield from run_on_cluster(function, jobs, scheduler)
    elif processes == 1 and timeout is None:
        for job in jobs:
            yield attempt(function, job)
    else:
        yield from run_in_processes(function, jobs, processes, timeout)


def check_timeout(timeout: float | None, scheduler: str | None = None) -> None:
    """Raise `GeohueError` unless this is a time limit for jobs that run there.

    Examples
    --------
    >>> check_timeout(0)
    Traceback (most recent call last):
    geohue.errors.GeohueError: timeout is 0: expected a positive number of seconds
    """
    if timeout is None:
        return
    if not 0 < timeout < float("inf"):
        raise GeohueError(f"timeout is {timeout:g}: expected a positive number of seconds")
    if scheduler is not None:
        raise GeohueError(
            "a time limit needs processes of this machine: leave out the timeout or the scheduler"
        )
