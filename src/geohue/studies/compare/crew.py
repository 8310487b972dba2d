"""Jobs side by side in processes, each with a time limit, none of which can stop the others.

`geohue.jobs.pool` is for many jobs of which all should end well; here every job is answered
for by itself, so that a process can be ended in the middle of one.
"""

from __future__ import annotations

import os
import signal
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing import get_context, parent_process
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess
from threading import Thread
from time import monotonic
from typing import Any, Generic, NamedTuple, TypeVar

Job = TypeVar("Job")
Answer = TypeVar("Answer")

_PATIENCE = 5.0
"""Seconds for a process that was told to end."""


class Outcome(NamedTuple, Generic[Job, Answer]):
    """What became of a job: its answer, or what went wrong."""

    job: Job
    answer: Answer | None
    error: str | None


@dataclass(slots=True)
class _Hand:
    """A process and what it is doing."""

    process: SpawnProcess
    line: Connection
    job: Any = None
    until: float = 0.0

    def begin(self, job: object, timeout: float) -> None:
        self.job, self.until = job, monotonic() + timeout
        with suppress(OSError):  # it may have died: so says the line when it is read
            self.line.send(job)

    def end(self) -> None:
        self.line.close()
        self.process.terminate()
        self.process.join(_PATIENCE)
        if self.process.is_alive():
            self.process.kill()
            self.process.join()


def run_crew(
    function: Callable[[Job], Answer], jobs: Sequence[Job], processes: int, timeout: float
) -> Iterator[Outcome[Job, Answer]]:
    """Run `function` on every job, never in the calling process, with one thread each.

    Parameters
    ----------
    function : callable
        Importable by name, or a `functools.partial` of one, as its process imports it.
    jobs : sequence
        What it is called with.
    processes : int
        How many work at a time.
    timeout : float
        Seconds for one job, after which its process is ended.

    Yields
    ------
    Outcome
        As jobs end. A job that raises, takes too long, or whose process dies has an error.

    Examples
    --------
    >>> sorted(outcome.answer for outcome in run_crew(abs, [-1, 2], 1, 60))
    [1, 2]
    """
    waiting = deque(jobs)
    idle: list[_Hand] = []
    busy: list[_Hand] = []
    try:
        while waiting or busy:
            while waiting and len(busy) < processes:
                hand = idle.pop() if idle else _hire(function)
                busy.append(hand)
                hand.begin(waiting.popleft(), timeout)
            first = min(hand.until for hand in busy)
            ready = wait([hand.line for hand in busy], max(0.0, first - monotonic()))
            for hand in list(busy):
                outcome = _outcome(hand, hand.line in ready, timeout)
                if outcome is not None:
                    busy.remove(hand)
                    if hand.process.is_alive() and not hand.line.closed:
                        idle.append(hand)
                    yield outcome
    finally:
        for hand in (*busy, *idle):
            hand.end()


def _hire(function: Callable[[Any], Any]) -> _Hand:
    context = get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=_serve, args=(theirs, function), daemon=True)
    process.start()
    theirs.close()
    return _Hand(process, ours)


def _outcome(hand: _Hand, ready: bool, timeout: float) -> Outcome[Any, Any] | None:
    """Return what became of a hand's job, or None while it is under way."""
    if ready:
        try:
            return Outcome(hand.job, *hand.line.recv())
        except (EOFError, OSError):
            hand.process.join(_PATIENCE)
            code = hand.process.exitcode
            hand.end()
            return Outcome(hand.job, None, f"the process died ({_cause(code)})")
    if monotonic() >= hand.until:
        hand.end()
        return Outcome(hand.job, None, f"not done after {timeout:g} s")
    return None


def _cause(code: int | None) -> str:
    """Say what an exit code means.

    Examples
    --------
    >>> _cause(3), _cause(-9)
    ('exit status 3', 'signal 9; out of memory?')
    """
    if code is None or code >= 0:
        return f"exit status {code}"
    return f"signal {-code}" + ("; out of memory?" if code == -9 else "")


def _serve(line: Connection, function: Callable[[Any], Any]) -> None:
    """Answer jobs until nobody asks any more."""
    from geohue.jobs.pool import one_thread

    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent is interrupted too, and ends us
    Thread(target=_end_with_parent, daemon=True).start()
    one_thread()
    while True:
        try:
            job = line.recv()
        except (EOFError, OSError):
            return
        line.send(_attempt(function, job))


def _attempt(function: Callable[[Job], Answer], job: Job) -> tuple[Answer | None, str | None]:
    from geohue.errors import GeohueError

    try:
        return function(job), None
    except GeohueError as error:
        return None, " ".join(str(error).split())
    except Exception as error:  # any failure is an answer here
        return None, " ".join(f"{type(error).__name__}: {error}".split())


def _end_with_parent() -> None:
    """End this process when the one that started it is killed: nobody else would."""
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
