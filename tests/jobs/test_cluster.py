"""Jobs on real worker processes of a dask cluster: the same results, and nothing lost."""

from __future__ import annotations

import csv
import os
import signal
import warnings
from pathlib import Path
from time import sleep, time
from typing import Any

import numpy as np
import pytest

from geohue._version import __version__
from geohue.cli.app import run as command
from geohue.errors import GeohueError, GeohueWarning
from geohue.jobs import cluster as module
from geohue.jobs import crew
from geohue.jobs.pool import run_jobs
from geohue.results.png import write_png
from geohue.studies.batch import Settings, batch, find_items
from jobs.frames import (
    HEIGHT,
    TAKES_S,
    WIDTH,
    answer_of_another_version,
    note_and_square,
    write_frames,
)


def worker_pids(cluster: Any) -> list[int]:
    return [worker.pid for worker in cluster.workers.values() if worker.pid is not None]


def look_often(monkeypatch: pytest.MonkeyPatch) -> None:
    for place in (crew, module):
        monkeypatch.setattr(place, "LOOK_S", 0.1)


def test_outcomes_are_those_of_this_process(cluster: Any) -> None:
    jobs = ["1", "x", "3", "", "-5"]
    here = {o.job: o for o in run_jobs(int, jobs)}
    there = {o.job: o for o in run_jobs(int, jobs, scheduler=cluster.scheduler_address)}
    assert here == there
    assert there["x"].error == "ValueError: invalid literal for int() with base 10: 'x'"


def test_killed_worker_loses_no_job(cluster: Any, tmp_path: Path) -> None:
    jobs = [(i, str(tmp_path)) for i in range(8)]
    results: dict[int, int | None] = {}
    killed = None
    for outcome in run_jobs(note_and_square, jobs, scheduler=cluster.scheduler_address):
        assert outcome.error is None
        results[outcome.job[0]] = outcome.result
        last = max(tmp_path.iterdir(), key=lambda file: file.stat().st_mtime_ns)
        number, pid = (int(part) for part in last.name.split("-"))
        # Not one that has ended and whose result is here already: a job takes longer than that.
        is_young = time() - last.stat().st_mtime < TAKES_S / 2
        if killed is None and number not in results and is_young:
            killed = number
            os.kill(pid, signal.SIGKILL)
    assert results == {i: i * i for i in range(8)}
    assert len(list(tmp_path.glob(f"{killed}-*"))) >= 2  # begun, cut off and begun again


def test_job_that_kills_its_workers_costs_itself_only(cluster: Any) -> None:
    # All of these signals are harmless, but for one.
    jobs = [signal.SIGCHLD, signal.SIGURG, signal.SIGKILL, signal.SIGWINCH]
    found = run_jobs(signal.raise_signal, jobs, scheduler=cluster.scheduler_address)
    died = "the process died (out of memory?)"
    assert {o.job: o.error for o in found} == dict.fromkeys(jobs) | {signal.SIGKILL: died}


def test_batch_survives_a_killed_worker_and_a_damaged_frame(cluster: Any, tmp_path: Path) -> None:
    folder = write_frames(tmp_path / "frames", 6)
    (folder / "0002" / "depth.png").write_bytes(b"no picture")
    write_png(folder / "0004" / "depth.png", np.zeros((HEIGHT, WIDTH), np.uint16))
    items, _ = find_items(folder)
    settings = Settings(k=2, preset="fast")
    batch(items, tmp_path / "here", settings)
    shots: list[str] = []

    def shoot_once(done: int, total: int, text: str) -> None:
        if not shots:
            os.kill(worker_pids(cluster)[0], signal.SIGKILL)
        shots.append(f"{done}/{total} {text[4:6]}")

    batch(
        items,
        tmp_path / "there",
        settings,
        scheduler=cluster.scheduler_address,
        progress=shoot_once,
    )
    assert [shot[:3] for shot in shots] == [f"{i}/6" for i in range(1, 7)]
    assert sorted(shot[4:] for shot in shots) == ["", "", "", "", ": ", ": "]
    rows = [untimed(tmp_path / place / "batch.csv") for place in ("here", "there")]
    assert rows[0] == rows[1]
    assert [row["name"] for row in rows[0] if row["error"]] == ["0002", "0004"]
    for name in ("0000", "0001", "0003", "0005"):
        files = [(tmp_path / place / name / "labels.png") for place in ("here", "there")]
        assert files[0].read_bytes() == files[1].read_bytes()


def test_benchmark_takes_a_scheduler(
    cluster: Any,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)  # the workers are elsewhere
    truth = np.ones((HEIGHT, WIDTH), np.uint16)
    truth[:, WIDTH // 2 :] = 2
    write_png(write_frames(Path("frames"), 1) / "0000" / "labels.png", truth)
    given = ["benchmark", "frames", "-k", "2", "--presets", "fast", "--no-plots"]
    there = ["--scheduler", cluster.scheduler_address]
    assert command([*given, "-o", "here"]) == 0
    assert command([*given, "-o", "there", *there]) == 0
    rows = [untimed(tmp_path / place / "frames.csv") for place in ("here", "there")]
    assert rows[0] == rows[1]
    assert float(rows[1][0]["voi_bits"]) == 0
    assert command([*given, "-o", "third", "--processes", "2", *there]) == 2
    assert "both say where to work: give one" in capsys.readouterr().err


def untimed(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as file:
        return [{k: v for k, v in row.items() if k != "seconds"} for row in csv.DictReader(file)]


def test_command_takes_a_scheduler(
    cluster: Any,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    write_frames(tmp_path / "frames", 2)
    monkeypatch.chdir(tmp_path)  # the workers are elsewhere
    given = ["-k", "2", "--preset", "fast", "--scheduler", cluster.scheduler_address]
    assert command(["batch", "frames", "-o", "out", *given]) == 0
    assert "2 of 2 frame(s) segmented" in capsys.readouterr().out
    assert (tmp_path / "out" / "0001" / "labels.png").exists()


def test_few_jobs_are_under_way(in_process: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    submit = module._submit
    sent: list[int] = []

    def note_and_submit(workers: Any, function: Any, job: int) -> Any:
        sent.append(job)
        return submit(workers, function, job)

    monkeypatch.setattr(module, "_submit", note_and_submit)
    address = in_process(2).scheduler_address
    for done, _ in enumerate(run_jobs(abs, range(40), scheduler=address)):
        assert len(sent) <= done + 2 * 3
    assert sent == list(range(40))


@pytest.mark.parametrize(
    ("address", "says"),
    [
        ("carrier-pigeon://10.0.0.1", "unknown address scheme"),
        ("10.0.0.1", "missing port"),
        ("tcp://10.0.0.1:port", "invalid literal"),
        ("tls://10.0.0.1:9", "no certificates"),
    ],
)
def test_address_that_no_scheduler_has(
    address: str, says: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    distributed = pytest.importorskip("distributed", reason="needs geohue[distributed]")
    # A client with such an address would leave a traceback at the exit.
    monkeypatch.setattr(distributed, "Client", lambda *_, **__: pytest.fail("a client was made"))
    with pytest.raises(GeohueError, match=f"no dask scheduler to be reached .*{says}"):
        list(run_jobs(abs, [1], scheduler=address))


def test_scheduler_that_is_not_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("distributed", reason="needs geohue[distributed]")
    monkeypatch.setattr(module, "CONNECT_S", 0.3)
    with pytest.raises(
        GeohueError, match=r"^tcp://127\.0\.0\.1:9: no dask scheduler to be reached"
    ):
        list(run_jobs(abs, [1], scheduler="tcp://127.0.0.1:9"))
    assert list(run_jobs(abs, [], scheduler="tcp://127.0.0.1:9")) == []
    write_frames(tmp_path / "frames", 1)
    given = ["batch", str(tmp_path / "frames"), "-o", str(tmp_path / "out"), "--preset", "fast"]
    assert command([*given, "--scheduler", "tcp://127.0.0.1:9"]) == 2
    told = capsys.readouterr().err
    assert "geohue: error: tcp://127.0.0.1:9: no dask scheduler" in told
    assert command(given) == 0  # what was not begun need not be resumed


def test_scheduler_without_workers(in_process: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(crew, "PATIENCE_S", 0.3)
    with pytest.raises(GeohueError, match=r"no worker for 0\.3 s; start some with 'dask worker"):
        list(run_jobs(abs, [1], scheduler=in_process(0).scheduler_address))


def test_workers_that_go_and_do_not_come_back(
    in_process: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(crew, "PATIENCE_S", 0.3)
    look_often(monkeypatch)
    cluster = in_process(1)
    outcomes = run_jobs(abs, range(50), scheduler=cluster.scheduler_address)
    assert next(outcomes).error is None
    cluster.scale(0)
    with pytest.raises(GeohueError, match="no worker for"):
        list(outcomes)


def test_results_that_go_with_their_worker(
    in_process: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(crew, "PATIENCE_S", 0.3)
    look_often(monkeypatch)
    cluster, take = in_process(1), module._take

    def take_and_lose(queue: Any) -> list[Any]:
        found = take(queue)
        if found:  # the jobs have ended, and nobody has their results yet
            cluster.scale(0)
            while cluster.scheduler.workers:
                sleep(0.01)
        return found

    monkeypatch.setattr(module, "_take", take_and_lose)
    with pytest.raises(GeohueError, match="no worker for"):
        list(run_jobs(abs, range(3), scheduler=cluster.scheduler_address))


def test_scheduler_that_goes(in_process: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "CONNECT_S", 0.3)
    cluster = in_process(1)
    outcomes = run_jobs(abs, range(500), scheduler=cluster.scheduler_address)
    assert next(outcomes).error is None
    cluster.close()
    with pytest.raises(GeohueError, match="the scheduler has gone or has dropped the jobs"):
        list(outcomes)


@pytest.mark.parametrize("asked", ["wait_for_workers", "nthreads", "run"])
def test_scheduler_that_goes_before_the_first_job(
    in_process: Any, monkeypatch: pytest.MonkeyPatch, asked: str
) -> None:
    distributed = pytest.importorskip("distributed", reason="needs geohue[distributed]")
    monkeypatch.setattr(module, "CONNECT_S", 0.3)
    cluster, call = in_process(1), getattr(distributed.Client, asked)

    def go_and_call(client: Any, *given: Any, **named: Any) -> Any:
        cluster.close()
        return call(client, *given, **named)

    monkeypatch.setattr(distributed.Client, asked, go_and_call)
    with pytest.raises(GeohueError, match="the scheduler has gone or has dropped the jobs"):
        list(run_jobs(abs, [1], scheduler=cluster.scheduler_address))


def test_other_version_on_a_worker(in_process: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    address = in_process(1).scheduler_address
    with monkeypatch.context() as patch:
        patch.setattr(crew, "__version__", "99.0")
        message = rf"has geohue {__version__} and this is 99\.0; install the same version"
        with pytest.raises(GeohueError, match=message):
            list(run_jobs(abs, [1], scheduler=address))
    # One that joins after the look at all workers.
    monkeypatch.setattr(module, "_call", answer_of_another_version)
    with pytest.raises(GeohueError, match=r"^a worker that joined later: .* has geohue 0\.0 and"):
        list(run_jobs(abs, [1], scheduler=address))


def test_worker_refuses_jobs_of_another_version() -> None:
    assert module._call("99.0", b"never read") == (__version__, None, None)


def test_job_that_a_worker_cannot_import_is_an_outcome() -> None:
    _, result, error = module._call(__version__, b"cno_such_module\nf\n.")
    assert (result, error) == (None, "ModuleNotFoundError: No module named 'no_such_module'")


def test_several_threads_a_worker_are_pointed_out(in_process: Any) -> None:
    address = in_process(1, threads=2).scheduler_address
    with pytest.warns(GeohueWarning, match="workers with several threads"):
        assert sorted(o.result or 0 for o in run_jobs(abs, [-1, 2], scheduler=address)) == [1, 2]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert next(run_jobs(abs, [-1], scheduler=in_process(1).scheduler_address)).result == 1
