"""The workers of a dask.distributed cluster, as they come and go."""

from __future__ import annotations

import warnings
from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager
from pkgutil import resolve_name
from time import monotonic
from typing import Any

from geohue._version import __version__
from geohue.errors import GeohueError, GeohueWarning

PATIENCE_S = 60.0
"""Seconds without any worker after which a run ends."""

LOOK_S = 2.0
"""Seconds between looks at who works."""

_AHEAD = (
    3  # jobs sent for each thread of the workers: they never wait, and the scheduler stays small
)


class Crew:
    """The workers of a cluster.

    Parameters
    ----------
    client : distributed.Client
        Connected to their scheduler.
    scheduler : str
        Its address, named in errors.

    Raises
    ------
    GeohueError
        If the scheduler goes away, no worker comes in time or one has another geohue.
    """

    def __init__(self, client: Any, scheduler: str) -> None:
        self.client = client
        self._scheduler = scheduler
        self._seen = self._looked = monotonic()
        self._threads = 0
        with self._reached():
            try:
                client.wait_for_workers(1, timeout=PATIENCE_S)
            except TimeoutError:
                raise self._deserted() from None
        self.look()
        self._check_threads()
        self._check_versions()

    @property
    def window(self) -> int:
        """How many jobs to have under way."""
        if monotonic() - self._looked > LOOK_S:
            self.look()
        return max(1, _AHEAD * self._threads)

    def look(self) -> None:
        """Count the workers' threads; raises if there are none for too long, or no scheduler."""
        with self._reached():
            self._threads = sum(self.client.nthreads().values())
        self._looked = monotonic()
        if self._threads:
            self._seen = self._looked
        elif self._looked - self._seen > PATIENCE_S:
            raise self._deserted()

    def wait(self, call: Callable[[], Awaitable[Any]]) -> Any:
        """Wait for dask's answer for as long as there are workers.

        A result that has gone with its worker is computed again, which without workers takes for
        ever.
        """
        timeout = LOOK_S
        while True:
            try:
                return self.client.sync(call, callback_timeout=timeout)
            except TimeoutError:
                self.look()
                timeout *= 2  # a large result may take its time

    def check_version(self, version: str, worker: str) -> None:
        """Raise an error if a version is not this one."""
        if version != __version__:
            raise GeohueError(
                f"{worker}: the worker has geohue {version} and this is {__version__}; install the "
                "same version everywhere"
            )

    def gone(self) -> GeohueError:
        """Return the error of a scheduler that does not answer any more."""
        return GeohueError(
            f"{self._scheduler}: the scheduler has gone or has dropped the jobs; what is done is "
            "kept: start it again and resume"
        )

    def _check_threads(self) -> None:
        with self._reached():
            several = any(count > 1 for count in self.client.nthreads().values())
        if several:
            warnings.warn(
                f"{self._scheduler}: workers with several threads; one works at a time in a "
                "process: start them with 'dask worker --nworkers N --nthreads 1'",
                GeohueWarning,
                stacklevel=3,
            )

    def _check_versions(self) -> None:
        with self._reached():
            found = self.client.run(resolve_name, "geohue._version:__version__", on_error="return")
        for worker, version in found.items():
            if isinstance(version, ImportError):
                raise GeohueError(f"{worker}: the worker has no geohue; install {__version__}")
            if isinstance(version, str):  # else it has just gone
                self.check_version(version, worker)

    def _deserted(self) -> GeohueError:
        return GeohueError(
            f"{self._scheduler}: no worker for {PATIENCE_S:g} s; start some with "
            f"'dask worker {self._scheduler} --nthreads 1' and resume"
        )

    @contextmanager
    def _reached(self) -> Iterator[None]:
        """Turn what dask raises when its scheduler goes away into an error of ours."""
        from concurrent.futures import CancelledError

        try:
            yield
        except (OSError, RuntimeError, CancelledError) as error:
            raise self.gone() from error
