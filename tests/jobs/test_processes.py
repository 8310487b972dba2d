"""Processes side by side: answers, and every way in which a job can fail."""

from __future__ import annotations

import multiprocessing
import os
import signal
import time
from pathlib import Path

import pytest

from geohue.errors import GeohueError
from geohue.jobs.outcome import Outcome
from geohue.jobs.pool import run_jobs
from geohue.jobs.processes import run_in_processes
from jobs import faults


def outcomes(
    jobs: list[str], processes: int, timeout: float = 60
) -> dict[str, Outcome[str, tuple[str, int]]]:
    done = list(run_in_processes(faults.work, jobs, processes, timeout))
    assert sorted(outcome.job for outcome in done) == sorted(jobs)
    return {outcome.job: outcome for outcome in done}


def test_a_process_does_one_job_after_the_other_in_their_order() -> None:
    done = list(run_in_processes(faults.work, ["a", "b", "c"], 1, 60))
    assert [outcome.job for outcome in done] == ["a", "b", "c"]
    assert len({outcome.result[1] for outcome in done if outcome.result}) == 1


def test_each_failure_is_that_of_its_own_job() -> None:
    done = outcomes(["raise", "kill", "a", "exit", "b", "unsendable", "c"], 2)
    assert {job: outcome.error for job, outcome in done.items()} == {
        "raise": "KeyError: 'gone'",
        "kill": "the process died (signal 9; out of memory?)",
        "exit": "the process died (exit status 3)",
        "unsendable": done["unsendable"].error,
        "a": None,
        "b": None,
        "c": None,
    }
    assert all(done[job].result is not None for job in "abc")
    assert "pickle" in (done["unsendable"].error or "")


def test_a_job_that_never_ends_is_ended() -> None:
    done = outcomes(["sleep", "a"], 2, timeout=8)
    assert done["sleep"].error == "not done after 8 s"
    assert done["a"].error is None


def test_no_process_stays_behind() -> None:
    before = set(multiprocessing.active_children())  # other tests keep a cluster
    crew = run_in_processes(faults.work, ["a", "sleep", "b"], 2, 60)
    next(crew)
    crew.close()  # type: ignore[attr-defined]
    assert set(multiprocessing.active_children()) <= before


def test_a_job_that_cannot_be_sent_or_read_is_an_outcome() -> None:
    jobs = [lambda: 0, faults.Unreadable(), "a"]
    done = list(run_in_processes(str, jobs, 1))
    assert "pickle" in (done[0].error or "")
    assert done[1].error == "RuntimeError: never read"
    assert done[2].result == "a"


def test_one_that_died_is_tried_again_alone(tmp_path: Path) -> None:
    # The first try leaves a file and dies, the second finds it: another job's memory is gone.
    jobs = [tmp_path / name for name in "abc"]
    done = list(run_in_processes(faults.die_once, jobs, 2))
    assert {outcome.job: outcome.result for outcome in done} == dict.fromkeys(jobs, 2)
    assert all(outcome.error is None for outcome in done)


def test_a_time_limit_is_kept_where_the_jobs_run_one_by_one() -> None:
    (late,) = run_jobs(faults.work, ["sleep"], processes=1, timeout=4)
    assert late.error == "not done after 4 s"
    (here,) = run_jobs(faults.work, ["a"])
    assert here.result == ("a", os.getpid())
    with pytest.raises(GeohueError, match="leave out the timeout or the scheduler"):
        list(run_jobs(faults.work, ["a"], scheduler="tcp://127.0.0.1:9", timeout=4))
    with pytest.raises(GeohueError, match="timeout is nan"):
        list(run_jobs(faults.work, ["a"], timeout=float("nan")))


def test_the_reason_is_what_the_user_reads() -> None:
    assert Outcome(1, None, "GeohueError: no such file").reason == "no such file"
    assert Outcome(1, None, "KeyError: 'a'").reason == "KeyError: 'a'"
    assert Outcome(1, 2, None).reason == ""


def test_dead_process_costs_its_own_job_only() -> None:
    # All of these signals are harmless, but for one.
    jobs = [signal.SIGCHLD, signal.SIGURG, signal.SIGKILL, signal.SIGWINCH]
    outcomes = {o.job: o.error for o in run_jobs(signal.raise_signal, jobs, processes=2)}
    died = "the process died (signal 9; out of memory?)"
    assert outcomes == dict.fromkeys(jobs) | {signal.SIGKILL: died}


def test_a_process_may_die_while_the_caller_is_busy() -> None:
    die = "import os, time; time.sleep(0.5); os._exit(1)"
    jobs = ["1", die, "2", "3"]
    outcomes: dict[str, str | None] = {}
    for outcome in run_jobs(exec, jobs, processes=2):
        time.sleep(0 if outcomes else 1)
        outcomes[outcome.job] = outcome.error
    assert outcomes == dict.fromkeys(jobs) | {die: "the process died (exit status 1)"}
