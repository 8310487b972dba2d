"""The environment of the peers, and the process in it that runs them."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import venv
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from types import TracebackType
from typing import Any

import numpy as np
from numpy.typing import NDArray

PACKAGES = (
    "torch<2.14",
    "ncut-pytorch==3.2.*",
    "nystrom-ncut==0.3.*",
    "einops",  # which nystrom-ncut needs and does not ask for
    "scikit-learn",
    "scikit-image",
)


def python_of(folder: Path) -> Path:
    """Return the interpreter of the peers' environment, which is made if it is not there."""
    python = folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    stamp = folder / "packages.json"
    wanted = json.dumps(PACKAGES)
    if not (stamp.is_file() and stamp.read_text("utf-8") == wanted):
        if folder.exists() and any(folder.iterdir()):
            sys.exit(
                f"{folder}: not an environment of these peers; remove it or give another --env"
            )
        print(f"making an environment with the peers in {folder}", file=sys.stderr)
        venv.create(folder, with_pip=True, symlinks=os.name != "nt")
        subprocess.run([python, "-m", "pip", "install", "--quiet", *PACKAGES], check=True)
        stamp.write_text(wanted, "utf-8")
    return python


@dataclass(frozen=True, slots=True, eq=False)
class Answer:
    """What a peer made of some points.

    Attributes
    ----------
    labels : (N,) or (H, W) int32
    seconds : float
        In all, and of these `embedding` for the eigenvectors or features alone.
    processor : float
        Processor seconds of all threads, which other work on the machine hardly changes.
    """

    labels: NDArray[np.int32]
    seconds: float
    embedding: float
    processor: float


class Peers:
    """A long-lived process in the peers' environment.

    Arrays travel as files; imports, reading and writing are outside the times.
    """

    def __init__(self, python: Path, folder: Path, threads: int) -> None:
        self._folder = folder
        limits = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), str(threads))
        self._process = subprocess.Popen(
            [str(python), str(Path(__file__).with_name("worker.py")), str(threads)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            env=os.environ | limits,
        )
        self.versions: dict[str, str] = self._read()

    def run(
        self, method: str, points: NDArray[Any], landmarks: NDArray[np.int64], **settings: float
    ) -> Answer:
        """Let a peer label the points (or the picture)."""
        assert self._process.stdin is not None
        np.save(self._folder / "points.npy", points)
        np.save(self._folder / "landmarks.npy", landmarks)
        order = {"method": method, "folder": str(self._folder), "settings": settings}
        print(json.dumps(order), file=self._process.stdin, flush=True)
        answer = self._read()
        if "error" in answer:
            raise RuntimeError(f"{method}: {answer['error']}")
        labels = np.load(self._folder / "labels.npy")
        return Answer(labels, answer["seconds"], answer["embedding"], answer["processor"])

    def _read(self) -> dict[str, Any]:
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if not line:
            raise RuntimeError(f"the peers' process ended with {self._process.wait()}")
        return dict(json.loads(line))

    def __enter__(self) -> Peers:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        at: TracebackType | None,
    ) -> None:
        assert self._process.stdin is not None
        self._process.stdin.close()
        self._process.wait()


@contextmanager
def open_peers(environment: Path, threads: int) -> Iterator[Peers]:
    """Start the peers' process, in an environment that is made if need be."""
    python = python_of(environment)
    with TemporaryDirectory() as folder, Peers(python, Path(folder), threads) as peers:
        yield peers
