"""The two passes, as jobs that know nothing of each other and can run anywhere."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from geohue.large.fit import Fitted, segments_of
from geohue.large.moments import Moments, merge
from geohue.large.sample import SAMPLE_ROW
from geohue.large.vectors import raw_values
from geohue.read.clouds.chunk import Chunk, Chunks

BLOCK = 250_000
"""Points in memory at a time. Fixed, as sums are taken block by block: the result then depends
neither on the memory nor on the processes. Five of the usual chunks of a LAZ file."""

JOB = 4 * BLOCK
"""Points in a job: what a killed run may have to do again."""


@dataclass(frozen=True, slots=True, eq=False)
class MeasureJob:
    """A stretch to measure.

    Attributes
    ----------
    source : Chunks
        The cloud.
    start, stop : int
        The stretch.
    cues : {"fusion", "color", "geometry"}
        The cues in use.
    rows : (m,) int64
        Points of the sample that lie in it, in increasing order.
    """

    source: Chunks
    start: int
    stop: int
    cues: str
    rows: NDArray[np.int64]


def measure(job: MeasureJob) -> tuple[Moments, NDArray[np.void]]:
    """Return the moments of a stretch and its part of the sample, (m,) `SAMPLE_ROW`."""
    parts = []
    sample = np.empty(len(job.rows), SAMPLE_ROW)
    for start, (xyz, rgb) in _blocks(job.source, job.start, job.stop):
        _, values = raw_values(xyz, rgb, job.cues)
        parts.append(Moments.of(values))
        slots = slice(*np.searchsorted(job.rows, (start, start + len(xyz))))
        inside = job.rows[slots] - start
        sample["xyz"][slots], sample["rgb"][slots] = xyz[inside], rgb[inside]
    return merge(parts), sample


@dataclass(frozen=True, slots=True)
class Target:
    """A file of rows, one for each point, that jobs fill in side by side.

    Attributes
    ----------
    path : Path
        The file, which exists in its full size.
    start : int
        Byte at which the first row begins.
    row : numpy.dtype
        Of the fields that there are: region, label, scalar_label, xyz, rgb.
    """

    path: Path
    start: int
    row: np.dtype[np.void]

    def write(self, at: int, **columns: NDArray[np.generic]) -> None:
        """Write the rows from number `at` on."""
        rows = np.empty(len(columns["label"]), self.row)
        for name in self.row.names or ():
            rows[name] = columns[name]
        with self.path.open("r+b") as file:
            file.seek(self.start + at * self.row.itemsize)
            file.write(rows.tobytes())
            file.flush()
            os.fsync(file.fileno())


@dataclass(frozen=True, slots=True, eq=False)
class LabelJob:
    """A stretch to label.

    Attributes
    ----------
    source : Chunks
        The cloud.
    start, stop : int
        The stretch.
    fitted : Fitted
        What labels it.
    targets : tuple of Target
        Where the labels go.
    """

    source: Chunks
    start: int
    stop: int
    fitted: Fitted
    targets: tuple[Target, ...]


def label(job: LabelJob) -> list[int]:
    """Write the labels of a stretch; returns how many points each part has, none last."""
    counts = np.zeros(len(job.fitted.order) + 1, np.int64)
    for start, (xyz, rgb) in _blocks(job.source, job.start, job.stop):
        parts = job.fitted.parts(xyz, rgb)
        labels = segments_of(job.fitted, parts)
        counts += np.bincount(np.where(parts < 0, len(counts) - 1, parts), minlength=len(counts))
        for target in job.targets:
            target.write(start, region=parts, label=labels, scalar_label=labels, xyz=xyz, rgb=rgb)
    return counts.tolist()


def _blocks(source: Chunks, start: int, stop: int) -> Iterator[tuple[int, Chunk]]:
    """Yield the blocks of a stretch, each with the number of its first point."""
    try:
        for first in range(start, stop, BLOCK):
            yield first, source.read(first, min(first + BLOCK, stop))
    finally:
        source.close()
