"""Jobs side by side in processes of this machine, none of which can stop the others.

Each process is told one job at a time, so that it is known which job one has died of, and one that
takes too long can be ended in the middle of it.
"""

from __future__ import annotations

import math
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
from typing import Any

from geohue.jobs.outcome import Job, Outcome, Result, attempt, error_text

_PATIENCE = 5.0
"""Seconds for a process that was told to end."""


@dataclass(slots=True, eq=False)
class _Hand:
    """A process and what it is doing."""

    process: SpawnProcess
    line: Connection
    job: Any = None
    until: float = math.inf
    died: bool = False

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

    @property
    def ended(self) -> bool:
        """Whether it takes no more jobs."""
        return self.line.closed or not self.process.is_alive()


def run_in_processes(
    function: Callable[[Job], Result],
    jobs: Sequence[Job],
    processes: int,
    timeout: float | None = None,
) -> Iterator[Outcome[Job, Result]]:
    """Run `function` on every job, never in the calling process, with one thread each.

    A job whose process died is tried once more when the others are done, alone: it may have died
    of the memory that they took.

    Parameters
    ----------
    function : callable
        Importable by name, or a `functools.partial` of one; sent once to each process.
    jobs : sequence
        What it is called with.
    processes : int
        How many work at a time.
    timeout : float, optional
        Seconds for one job, after which its process is ended.

    Yields
    ------
    Outcome
        As jobs end. A job that raises, takes too long, or whose process dies has an error.

    Examples
    --------
    >>> sorted(outcome.result for outcome in run_in_processes(abs, [-1, 2], 1))
    [1, 2]
    """
    limit = math.inf if timeout is None else timeout
    lost: list[Job] = []
    yield from _run(function, jobs, processes, limit, lost)
    for job in lost:
        yield from _run(function, [job], 1, limit, None)


def _run(
    function: Callable[[Job], Result],
    jobs: Sequence[Job],
    processes: int,
    timeout: float,
    lost: list[Job] | None,
) -> Iterator[Outcome[Job, Result]]:
    """Run jobs; one whose process died goes to `lost`, or has an outcome if that is None."""
    waiting = deque(jobs)
    idle: list[_Hand] = []
    busy: list[_Hand] = []
    try:
        while waiting or busy:
            while waiting and len(busy) < processes:
                busy.append(idle.pop() if idle else _hire(function))
                try:
                    busy[-1].begin(waiting[0], timeout)
                except Exception as error:  # it cannot be sent
                    idle.append(busy.pop())
                    yield Outcome(waiting[0], None, error_text(error))
                waiting.popleft()
            for hand in _ready(busy):
                busy.remove(hand)
                outcome = _outcome(hand, timeout)
                if not hand.ended:
                    idle.append(hand)
                if hand.died and lost is not None:
                    lost.append(hand.job)
                else:
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


def _ready(busy: Sequence[_Hand]) -> list[_Hand]:
    """Wait for an answer or the end of somebody's time; returns those concerned, if any."""
    first = min((hand.until for hand in busy), default=0.0)
    left = None if first == math.inf else max(0.0, first - monotonic())
    ready = wait([hand.line for hand in busy], left)
    return [hand for hand in busy if hand.line in ready or monotonic() >= hand.until]


def _outcome(hand: _Hand, timeout: float) -> Outcome[Any, Any]:
    """Return what became of a job whose process has answered, has died or is to be ended."""
    if not hand.line.poll():
        hand.end()
        return Outcome(hand.job, None, f"not done after {timeout:g} s")
    try:
        return Outcome(hand.job, *hand.line.recv())
    except (EOFError, OSError):
        hand.died = True
        hand.process.join(_PATIENCE)
        code = hand.process.exitcode
        hand.end()
        return Outcome(hand.job, None, f"the process died ({_cause(code)})")


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
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent is interrupted too, and ends us
    Thread(target=_end_with_parent, daemon=True).start()
    while True:
        try:
            job = line.recv()
        except (EOFError, OSError):
            return
        except Exception as error:  # such as one of a module that cannot be imported here
            line.send((None, error_text(error)))
            continue
        _, result, error_line = attempt(function, job)
        try:
            line.send((result, error_line))
        except Exception as error:  # such as a result that cannot be sent
            line.send((None, error_text(error)))


def _end_with_parent() -> None:
    """End this process when the one that started it is killed: nobody else would."""
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
