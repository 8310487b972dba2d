"""The jobs of a server, each with an unguessable name and a folder that goes with it."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from secrets import token_urlsafe
from threading import Lock
from time import monotonic
from typing import Any, Literal

from geohue.web.limits import Limits
from geohue.web.wishes import Wishes

State = Literal["queued", "running", "done", "failed", "cancelled"]

ENDED: tuple[State, ...] = ("done", "failed", "cancelled")

SCENE = "scene.pickle"
"""The scene of a job as it was read, so that other settings need not read it again."""

RUN = "run.pickle"
"""The segmentation of a job."""


@dataclass(slots=True, eq=False)
class Job:
    """One scene with one set of wishes.

    Attributes
    ----------
    key : str
        Its name: 192 bits of chance. Who knows it may see, cancel and remove the job.
    folder : Path
        Where its files are.
    wishes : Wishes
    files : dict of str to str
        The name in `folder` of each uploaded file, by its role.
    sample : str
        The built-in scene; empty for none.
    state, stage, progress, error
        How far it is: `progress` from 0 to 1, `error` one line for people.
    touched : float
        When it was last asked for, by the monotonic clock.
    """

    key: str
    folder: Path
    wishes: Wishes
    files: dict[str, str] = field(default_factory=dict)
    sample: str = ""
    state: State = "queued"
    stage: str = ""
    progress: float = 0.0
    error: str = ""
    touched: float = field(default_factory=monotonic)

    @property
    def ended(self) -> bool:
        """Whether nothing more will become of it."""
        return self.state in ENDED

    def status(self) -> dict[str, Any]:
        """Return how far it is, ready for JSON."""
        return {
            "id": self.key,
            "state": self.state,
            "stage": self.stage,
            "progress": round(self.progress, 3),
            "error": self.error or None,
        }


class Store:
    """All jobs, below one private temporary folder.

    Parameters
    ----------
    limits : Limits
    """

    def __init__(self, limits: Limits) -> None:
        self._limits = limits
        self._jobs: dict[str, Job] = {}
        self._lock = Lock()
        self.root = Path(tempfile.mkdtemp(prefix="geohue-serve-"))  # readable by its owner alone

    def new_folder(self) -> tuple[str, Path]:
        """Return an unguessable name and a new folder for it."""
        key = token_urlsafe(24)
        folder = self.root / key
        folder.mkdir(mode=0o700)
        return key, folder

    def add(self, job: Job) -> None:
        """Keep a job; jobs that ended and were not asked for longest go if there are too many."""
        with self._lock:
            self._jobs[job.key] = job
            ended = sorted((j for j in self._jobs.values() if j.ended), key=lambda j: j.touched)
            surplus = ended[: max(0, len(self._jobs) - self._limits.kept)]
        for old in surplus:
            self.remove(old)

    def find(self, key: str) -> Job | None:
        """Return a job by its name."""
        with self._lock:
            job = self._jobs.get(key)
        if job is not None:
            job.touched = monotonic()
        return job

    def remove(self, job: Job) -> None:
        """Forget a job and remove its files."""
        with self._lock:
            self._jobs.pop(job.key, None)
        shutil.rmtree(job.folder, ignore_errors=True)

    def sweep(self) -> None:
        """Remove jobs that ended and were not asked for since `Limits.keep_seconds`."""
        before = monotonic() - self._limits.keep_seconds
        with self._lock:
            old = [job for job in self._jobs.values() if job.ended and job.touched < before]
        for job in old:
            self.remove(job)

    def close(self) -> None:
        """Remove everything."""
        with self._lock:
            self._jobs.clear()
        shutil.rmtree(self.root, ignore_errors=True)

    def __len__(self) -> int:
        """Return the number of jobs."""
        return len(self._jobs)


def share_scene(source: Job, folder: Path) -> bool:
    """Give a new job's folder the scene of another job; returns whether that has one yet."""
    try:
        os.link(source.folder / SCENE, folder / SCENE)
    except FileNotFoundError:
        return False
    except OSError:  # a file system without links
        shutil.copyfile(source.folder / SCENE, folder / SCENE)
    return True


def as_task(job: Job) -> Mapping[str, Any]:
    """Return what a worker needs to know of a job."""
    return {
        "folder": job.folder,
        "wishes": job.wishes,
        "files": dict(job.files),
        "sample": job.sample,
    }
