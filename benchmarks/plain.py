"""The compiled cut against the same cut written plainly: array operations in double precision.

    python -m benchmarks.plain FOLDER [--protocol nyu] [-k 6] [--limit N] [--processes 2]

Both segment every frame of FOLDER with the preset of the paper, the weight searched by each on its
own. Printed: VoI of both against the true labels, the share of pixels with the same label, how many
frames chose the same weight, and the processor's seconds.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from time import process_time
from unittest.mock import patch

import numpy as np
from numpy.typing import NDArray

import geohue
from geohue.compute.arrays import Floats
from geohue.jobs.pool import run_jobs
from geohue.measures.contingency import contingency_table
from geohue.measures.crop import PROTOCOLS, Crop
from geohue.measures.partition import information_of
from geohue.ncut import nystrom
from geohue.ncut.affinity import affinity
from geohue.segmentation.result import Segmentation
from geohue.studies.benchmark.frames import find_frames, load_frame
from geohue.studies.items import Item


@dataclass(frozen=True, eq=False)
class PlainKernel:
    """What `geohue.ncut.kernel.Kernel` does, as one would write it down."""

    landmarks: NDArray[np.float64]
    scale: float

    @classmethod
    def of(cls, landmarks: Floats, scale: float) -> PlainKernel:
        """Take the landmarks as they are."""
        return cls(landmarks.astype(np.float64), scale)

    def __call__(self, vectors: Floats) -> Floats:
        """Return the affinities."""
        return affinity(vectors.astype(np.float64), self.landmarks, self.scale)

    def column_sums(self, vectors: Floats) -> Floats:
        """Return the sums over the points."""
        return np.asarray(self(vectors).sum(axis=0))

    def gram(self, vectors: Floats, to_degree: Floats) -> Floats:
        """Return C^T D^-1 C."""
        c = self(vectors)
        c /= np.sqrt(np.maximum(c @ to_degree, 1))[:, None]
        return np.asarray(c.T @ c)

    def project(self, vectors: Floats, basis: Floats) -> Floats:
        """Return C times the basis."""
        return np.asarray(self(vectors) @ basis)

    def nearest(self, vectors: Floats, basis: Floats, centers: Floats) -> NDArray[np.int32]:
        """Return the nearest centre."""
        rows = self.project(vectors, basis)
        rows /= np.linalg.norm(rows, axis=1)[:, None]
        scores = rows @ centers.T - 0.5 * (centers**2).sum(axis=1)
        return np.asarray(scores.argmax(axis=1), np.int32)


@contextmanager
def plain_cut() -> Iterator[None]:
    """Let the library cut with `PlainKernel`."""
    with patch.object(nystrom, "Kernel", PlainKernel):
        yield


@dataclass(frozen=True, slots=True)
class Pair:
    """One frame, both ways: (plain, compiled)."""

    voi: tuple[float, float]
    weight: tuple[float, float]
    seconds: tuple[float, float]
    alike: float
    alike_at_one: float


def compare(frame: Item, crop: Crop | None, k: int) -> Pair:
    """Segment a frame both ways; `alike_at_one` is with the weight 1 for both."""
    scene, truth = load_frame(frame, crop)
    mine, mine_seconds = timed(scene, k, "auto")
    with plain_cut():
        plain, plain_seconds = timed(scene, k, "auto")
        plain_one, _ = timed(scene, k, 1.0)
    mine_one, _ = timed(scene, k, 1.0)
    return Pair(
        (variation(plain.labels, truth), variation(mine.labels, truth)),
        (plain.weight, mine.weight),
        (plain_seconds, mine_seconds),
        float((plain.labels == mine.labels).mean()),
        float((plain_one.labels == mine_one.labels).mean()),
    )


def timed(scene: geohue.Scene, k: int, weight: float | str) -> tuple[Segmentation, float]:
    """Segment with one thread; returns the processor's seconds too."""
    start = process_time()
    seg = geohue.segment(scene, k, weight, components=True, threads=1)  # type: ignore[arg-type]
    return seg, process_time() - start


def variation(labels: NDArray[np.int32], truth: NDArray[np.int32]) -> float:
    """Variation of information in bits."""
    return information_of(contingency_table(labels, truth)).total


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--protocol", choices=sorted(PROTOCOLS))
    parser.add_argument("-k", type=int, default=6)
    parser.add_argument("--limit", type=int)
    parser.add_argument("--processes", type=int, default=2)
    given = parser.parse_args()
    work = partial(compare, crop=PROTOCOLS.get(given.protocol), k=given.k)
    frames = find_frames(given.folder, given.limit)
    pairs = [out.result for out in run_jobs(work, frames, given.processes) if out.result]
    voi, seconds = np.array([p.voi for p in pairs]), np.array([p.seconds for p in pairs])
    step = voi[:, 1] - voi[:, 0]
    alike = np.array([p.alike for p in pairs])
    same = np.mean([p.weight[0] == p.weight[1] for p in pairs])
    print(f"{len(pairs)} frames, K = {given.k}, components\n")
    print("| | plain | compiled |\n| --- | ---: | ---: |")
    print("| VoI, bits | {:.4f} | {:.4f} |".format(*voi.mean(axis=0)))
    print("| processor, s | {:.2f} | {:.2f} |\n".format(*np.median(seconds, axis=0)))
    error = step.std() / np.sqrt(len(step))
    print(f"VoI differs by {step.mean():+.4f} ± {error:.4f} bits, {step.mean() / voi.mean():+.2%}.")
    print(f"The same weight in {same:.0%} of the frames.")
    print(f"Pixels alike, weight searched: mean {alike.mean():.6f}, least {alike.min():.6f}.")
    alike = np.array([p.alike_at_one for p in pairs])
    print(f"Pixels alike, weight 1: mean {alike.mean():.6f}, least {alike.min():.6f}.")


if __name__ == "__main__":
    main()
