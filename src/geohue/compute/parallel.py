"""Work split over threads such that the result does not depend on their number."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from typing import TypeVar

from geohue.errors import GeohueError

Item = TypeVar("Item")
Result = TypeVar("Result")

BLOCK = 4096
"""Rows in one block: with 100 landmarks its affinities (1.6 MB) stay in a core's cache."""


class Workers:
    """A few threads that do independent pieces and hand back the results in order.

    Each piece is computed by one thread with a single-threaded BLAS, and pieces are cut by size
    alone: the number of threads changes when a piece is done, never what comes out.
    """

    def __init__(self, pool: ThreadPoolExecutor | None) -> None:
        self._pool = pool

    def map(self, function: Callable[[Item], Result], items: Iterable[Item]) -> Iterator[Result]:
        """Yield ``function(item)`` for each item, in the order of the items."""
        return map(function, items) if self._pool is None else self._pool.map(function, items)

    def map_blocks(
        self, function: Callable[[slice], Result], n: int, block: int = BLOCK
    ) -> Iterator[Result]:
        """Yield ``function(rows)`` for each block of at most `block` of `n` rows, in order."""
        return self.map(function, [slice(i, min(i + block, n)) for i in range(0, n, block)])


def cores() -> int:
    """Return the number of processor cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@contextmanager
def workers(threads: int | None = None) -> Iterator[Workers]:
    """Open `threads` threads (None: one a core) and keep BLAS to one thread each meanwhile.

    Examples
    --------
    >>> with workers(2) as team:
    ...     list(team.map_blocks(lambda rows: rows.stop - rows.start, 10, block=4))
    [4, 4, 2]
    """
    from threadpoolctl import threadpool_limits

    if threads is not None and threads < 1:
        raise GeohueError(f"threads is {threads}: expected at least 1")
    count = threads or cores()
    with threadpool_limits(limits=1, user_api="blas"):
        if count == 1:
            yield Workers(None)
            return
        with ThreadPoolExecutor(count) as pool:
            yield Workers(pool)
