"""A scheduler with worker processes, on this machine."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest


@pytest.fixture(scope="session")
def cluster() -> Iterator[Any]:
    """A scheduler with two worker processes, which come again when they are killed."""
    distributed = pytest.importorskip("distributed", reason="needs geohue[distributed]")
    import dask

    # A job may take one worker down and be tried again.
    with (
        dask.config.set({"distributed.scheduler.allowed-failures": 1}),
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address="127.0.0.1:0"
        ) as running,
    ):
        yield running


@pytest.fixture
def in_process() -> Iterator[Any]:
    """What starts a scheduler with so many workers in this process, ended with the test."""
    distributed = pytest.importorskip("distributed", reason="needs geohue[distributed]")
    started = []

    def start(workers: int, threads: int = 1) -> Any:
        started.append(
            distributed.LocalCluster(
                n_workers=workers,
                threads_per_worker=threads,
                processes=False,
                protocol="inproc",
                dashboard_address="127.0.0.1:0",
            )
        )
        return started[-1]

    yield start
    for running in started:
        running.close()
