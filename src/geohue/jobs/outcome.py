"""What becomes of a job, wherever it ran."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Generic, NamedTuple, TypeVar

from geohue.errors import GeohueError

Job = TypeVar("Job")
Result = TypeVar("Result")


class Outcome(NamedTuple, Generic[Job, Result]):
    """What became of a job: its result, or the text of what went wrong."""

    job: Job
    result: Result | None
    error: str | None

    @property
    def reason(self) -> str:
        """What went wrong, to be read by the user: an error of ours without its class."""
        return (self.error or "").removeprefix(f"{GeohueError.__name__}: ")


def attempt(function: Callable[[Job], Result], job: Job) -> Outcome[Job, Result]:
    """Run a job here, with numerical libraries of one thread; any failure is a result.

    Examples
    --------
    >>> attempt(len, 3).error
    "TypeError: object of type 'int' has no len()"
    """
    try:
        with one_thread():
            return Outcome(job, function(job), None)
    except Exception as error:
        return Outcome(job, None, error_text(error))


@contextmanager
def one_thread() -> Iterator[None]:
    """Keep the numerical libraries to one thread each, for a while."""
    import cv2
    from threadpoolctl import threadpool_limits

    before = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        with threadpool_limits(1):
            yield
    finally:
        cv2.setNumThreads(before)


def error_text(error: BaseException) -> str:
    """Return an exception as one line."""
    return " ".join(f"{type(error).__name__}: {error}".split())
