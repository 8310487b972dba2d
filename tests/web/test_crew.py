"""Workers, jobs and their files."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from time import monotonic, sleep

import pytest

from geohue.web.crew import Crew
from geohue.web.limits import Limits
from geohue.web.store import Job, Store
from geohue.web.wishes import Wishes


@pytest.fixture
def store() -> Iterator[Store]:
    made = Store(Limits(kept=3, keep_seconds=0.05))
    yield made
    made.close()
    assert not made.root.exists()


def _job(store: Store, sample: str = "boxes") -> Job:
    key, folder = store.new_folder()
    job = Job(key, folder, Wishes(preset="fast"), sample=sample)
    store.add(job)
    return job


def test_names_cannot_be_guessed_and_folders_are_private(store: Store) -> None:
    jobs = [_job(store) for _ in range(20)]
    assert len({job.key for job in jobs}) == 20
    assert all(len(job.key) == 32 for job in jobs)
    assert jobs[0].folder.parent.stat().st_mode & 0o077 == 0


def test_jobs_that_ended_go_after_a_time_and_others_stay(store: Store) -> None:
    ended, running = _job(store), _job(store)
    ended.state, running.state = "done", "running"
    sleep(0.1)
    store.sweep()
    assert store.find(ended.key) is None
    assert not ended.folder.exists()
    assert store.find(running.key) is running


def test_of_too_many_jobs_the_one_looked_at_longest_ago_goes(store: Store) -> None:
    jobs = [_job(store) for _ in range(3)]
    for job in jobs:
        job.state = "done"
    store.find(jobs[0].key)
    _job(store)
    assert [store.find(job.key) is not None for job in jobs] == [True, False, True]
    assert len(store) == 3


def _ended(job: Job) -> Job:
    latest = monotonic() + 60
    while not job.ended and monotonic() < latest:
        sleep(0.02)
    return job


def test_a_job_that_takes_too_long_ends_and_the_next_one_runs(store: Store) -> None:
    crew = Crew(Limits(run_seconds=0.2, waiting=2))
    try:
        jobs = [_job(store, "motorcycle-matched") for _ in range(4)]
        taken = [crew.submit(job) for job in jobs[:3]]
        assert taken[:2] == [True, True]
        assert "took longer than 0 s" in _ended(jobs[0]).error
        crew.cancel(jobs[1])
        assert jobs[1].state == "cancelled"
    finally:
        crew.close()
    assert not crew.submit(jobs[3])


def test_a_worker_that_dies_is_told_and_replaced(
    store: Store, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr("geohue.web.crew.work", _dies_once)
    crew = Crew(Limits())
    try:
        first, second = _job(store, str(tmp_path / "mark")), _job(store, str(tmp_path / "mark"))
        assert crew.submit(first)
        assert crew.submit(second)
        assert "memory" in _ended(first).error
        assert _ended(second).state == "done"
    finally:
        crew.close()


def _dies_once(pipe: object, _: Limits) -> None:
    """Stands for a worker whose first task takes its process down."""
    import os
    from multiprocessing.connection import Connection

    assert isinstance(pipe, Connection)
    mark = Path(pipe.recv()["sample"])
    if not mark.exists():
        mark.touch()
        os._exit(9)
    pipe.send(("done", ""))
    pipe.recv()
