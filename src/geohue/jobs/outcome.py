"""What becomes of a job, wherever it ran."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, NamedTuple, TypeVar

Job = TypeVar("Job")
Result = TypeVar("Result")

DIED = "the process died (out of memory?)"
"""Error of a job that took every process down that it ran in."""


class Outcome(NamedTuple, Generic[Job, Result]):
    """What became of a job: its result, or the text of what went wrong."""

    job: Job
    result: Result | None
    error: str | None


def attempt(function: Callable[[Job], Result], job: Job) -> Outcome[Job, Result]:
    """Run a job here, with numerical libraries of one thread; any failure is a result.

    Examples
    --------
    >>> attempt(len, 3).error
    "TypeError: object of type 'int' has no len()"
    """
    from threadpoolctl import threadpool_limits

    try:
        with threadpool_limits(1):
            return Outcome(job, function(job), None)
    except Exception as error:
        return Outcome(job, None, error_text(error))


def error_text(error: BaseException) -> str:
    """Return an exception as one line."""
    return " ".join(f"{type(error).__name__}: {error}".split())
