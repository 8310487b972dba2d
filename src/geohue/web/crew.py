"""The worker processes of a server: a scene at a time in each, any of which can be ended."""

from __future__ import annotations

import contextlib
from collections import deque
from multiprocessing import get_context
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from threading import Condition, Thread
from time import monotonic

from geohue.web.limits import Limits
from geohue.web.store import Job, as_task
from geohue.web.work import work

_POLL = 0.05  # seconds between looks at whether a job was cancelled

DIED = "the scene took more memory than a worker may have, or broke it: give a smaller one"


class Crew:
    """Worker processes and the jobs that wait for them.

    Parameters
    ----------
    limits : Limits
    """

    def __init__(self, limits: Limits) -> None:
        self._limits = limits
        self._waiting: deque[Job] = deque()
        self._changed = Condition()
        self._closed = False
        self._threads = [
            Thread(target=self._tend, name=f"worker {i}", daemon=True)
            for i in range(limits.workers)
        ]
        for thread in self._threads:
            thread.start()

    @property
    def is_full(self) -> bool:
        """Whether no further job can wait."""
        return len(self._waiting) >= self._limits.waiting

    def submit(self, job: Job) -> bool:
        """Let a job wait for a worker; returns False, and does nothing, if too many wait."""
        with self._changed:
            if self.is_full or self._closed:
                return False
            self._waiting.append(job)
            self._changed.notify()
        return True

    def place(self, job: Job) -> int:
        """Return how many jobs are before this one; 0 for the next and those that do not wait."""
        with self._changed:
            return self._waiting.index(job) if job in self._waiting else 0

    def cancel(self, job: Job) -> None:
        """End a job, whether it waits or runs; nothing happens to one that ended."""
        with self._changed:
            if job in self._waiting:
                self._waiting.remove(job)
            if not job.ended:
                job.state = "cancelled"

    def close(self) -> None:
        """End all workers."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()
        for thread in self._threads:
            thread.join()

    def _tend(self) -> None:
        """Give jobs to one process, and start another where one had to be ended."""
        process, pipe = self._start()
        while (job := self._next()) is not None:
            if not self._follow(job, pipe):
                _end(process, pipe)
                process, pipe = self._start()
        _end(process, pipe)

    def _start(self) -> tuple[BaseProcess, Connection]:
        spawn = get_context("spawn")
        here, there = spawn.Pipe()
        process = spawn.Process(target=work, args=(there, self._limits), daemon=True)
        process.start()
        there.close()
        return process, here

    def _next(self) -> Job | None:
        with self._changed:
            while not self._waiting and not self._closed:
                self._changed.wait()
            if self._closed:
                return None
            job = self._waiting.popleft()
            job.state = "running"
            return job

    def _follow(self, job: Job, pipe: Connection) -> bool:
        """See a job to its end; returns whether its process can go on."""
        latest = monotonic() + self._limits.run_seconds
        try:
            pipe.send(as_task(job))
            while job.state == "running" and not self._closed:
                if pipe.poll(_POLL):
                    kind, value = pipe.recv()
                    if kind != "stage":
                        self._finish(job, "done" if kind == "done" else "failed", value)
                        return True
                    job.stage, job.progress = value
                elif monotonic() > latest:
                    cause = (
                        f"took longer than {self._limits.run_seconds:.0f} s: give a smaller scene"
                    )
                    self._finish(job, "failed", cause)
        except (EOFError, OSError):
            self._finish(job, "failed", DIED)
        return False

    def _finish(self, job: Job, state: str, text: str) -> None:
        with self._changed:  # a job that was cancelled meanwhile stays so
            if job.state == "running":
                job.state = "done" if state == "done" else "failed"
                job.error, job.progress = text, 1.0 if state == "done" else job.progress


def _end(process: BaseProcess, pipe: Connection) -> None:
    with contextlib.suppress(OSError):
        pipe.close()
    process.terminate()
    process.join(5)
    if process.is_alive():
        process.kill()
        process.join()
