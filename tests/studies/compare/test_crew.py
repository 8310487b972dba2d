"""Processes side by side: answers, and every way in which a job can fail."""

from __future__ import annotations

import multiprocessing

from geohue.studies.compare.crew import Outcome, run_crew
from studies.compare import _faults


def outcomes(
    jobs: list[str], processes: int, timeout: float = 60
) -> dict[str, Outcome[str, tuple[str, int]]]:
    done = list(run_crew(_faults.work, jobs, processes, timeout))
    assert sorted(outcome.job for outcome in done) == sorted(jobs)
    return {outcome.job: outcome for outcome in done}


def test_a_process_does_one_job_after_the_other_in_their_order() -> None:
    done = list(run_crew(_faults.work, ["a", "b", "c"], 1, 60))
    assert [outcome.job for outcome in done] == ["a", "b", "c"]
    assert len({outcome.answer[1] for outcome in done if outcome.answer}) == 1


def test_each_failure_is_that_of_its_own_job() -> None:
    done = outcomes(["raise", "kill", "a", "exit", "b", "unsendable", "c"], 2)
    assert {job: outcome.error for job, outcome in done.items()} == {
        "raise": "KeyError: 'gone'",
        "kill": "the process died (signal 9; out of memory?)",
        "exit": "the process died (exit status 3)",
        "unsendable": "the process died (exit status 1)",
        "a": None,
        "b": None,
        "c": None,
    }
    assert all(done[job].answer is not None for job in "abc")


def test_a_job_that_never_ends_is_ended() -> None:
    done = outcomes(["sleep", "a"], 2, timeout=8)
    assert done["sleep"].error == "not done after 8 s"
    assert done["a"].error is None


def test_no_process_stays_behind() -> None:
    before = set(multiprocessing.active_children())  # other tests keep a cluster
    crew = run_crew(_faults.work, ["a", "sleep", "b"], 2, 60)
    next(crew)
    crew.close()  # type: ignore[attr-defined]
    assert set(multiprocessing.active_children()) <= before
