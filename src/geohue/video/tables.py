"""What is known of the tracks through time, as JSON and CSV."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from geohue.read.files import broken, read_bytes, reason
from geohue.results.atomic import atomic_write
from geohue.video.tracks import Sighting, Track

COLUMNS = (
    "track", "frame", "name", "size", "L", "a", "b", "x", "y", "z",
    "x_low", "y_low", "z_low", "x_high", "y_high", "z_high", "row", "column",
)  # fmt: skip
"""Columns of ``tracks.csv``: a row for each track and frame in which it is seen."""


class TrackTable:
    """Collects the sightings of a run.

    Examples
    --------
    >>> table = TrackTable()
    >>> color = place = np.zeros(3)
    >>> table.add("a.png", [Sighting(4, 0, 100, color, None, None, None, place[:2])])
    >>> table.tracks()[0]["id"], table.tracks()[0]["mean_size"]
    (4, 100.0)
    """

    def __init__(self, rows: list[tuple[Any, ...]] | None = None) -> None:
        self.rows = [] if rows is None else rows

    def add(self, name: str, seen: list[Sighting]) -> None:
        """Add the segments of a frame."""
        for one in seen:
            points = (one.center, one.low, one.high)
            places = [None] * 9 if one.center is None else _flat(points)
            self.rows.append(
                (one.track, one.frame, name, one.size, *_flat([one.color]), *places,
                 *_flat([one.place]))
            )  # fmt: skip

    def tracks(self) -> list[dict[str, Any]]:
        """Return each track, ready for JSON: when it was seen, its size, colour and place."""
        by_track: dict[int, list[tuple[Any, ...]]] = {}
        for row in self.rows:
            by_track.setdefault(row[0], []).append(row)
        return [_summary(track, rows) for track, rows in sorted(by_track.items())]

    def last(self) -> dict[int, Track]:
        """Return each track as it was last seen."""
        found: dict[int, Track] = {}
        for row in self.rows:
            known = found.get(row[0])
            one = _sighting(row)
            first, n = (one.frame, 1) if known is None else (known.first, known.n_frames + 1)
            found[one.track] = Track(one.track, first, one, n)
        return found

    def write_csv(self, path: Path) -> None:
        """Write a row for each sighting."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows(["" if value is None else value for value in row] for row in self.rows)
        with atomic_write(path) as temporary:
            temporary.write_text(text.getvalue())

    @classmethod
    def read_csv(cls, path: Path) -> TrackTable:
        """Read what `write_csv` wrote; GeohueError if it is anything else."""
        text = read_bytes(path).decode("utf-8", "replace")
        rows = list(csv.reader(io.StringIO(text)))
        if not rows or tuple(rows[0]) != COLUMNS:
            raise broken(path, "is no tracks.csv; give the folder of a run of geohue video")
        try:
            return cls([_parsed(row) for row in rows[1:]])
        except (ValueError, IndexError) as error:
            raise broken(path, f"has a damaged row ({reason(error)}); begin anew") from error


def write_json(path: Path, content: Mapping[str, Any]) -> None:
    """Write a JSON object, whole or not at all."""
    with atomic_write(path) as temporary:
        temporary.write_text(json.dumps(content, indent=1) + "\n")


def _parsed(row: list[str]) -> tuple[Any, ...]:
    if len(row) != len(COLUMNS):
        raise ValueError(f"{len(row)} columns")
    numbers = [None if value == "" else float(value) for value in row[4:]]
    return (int(row[0]), int(row[1]), row[2], int(row[3]), *numbers)


def _sighting(row: tuple[Any, ...]) -> Sighting:
    center, low, high = (None if row[7] is None else np.array(row[i : i + 3]) for i in (7, 10, 13))
    color, place = np.array(row[4:7]), np.array(row[16:18])
    return Sighting(row[0], row[1], row[3], color, center, low, high, place)


def _summary(track: int, rows: list[tuple[Any, ...]]) -> dict[str, Any]:
    sizes = np.array([row[3] for row in rows], np.float64)
    colors = np.array([row[4:7] for row in rows], np.float64)
    return {
        "id": track,
        "first_frame": rows[0][1],
        "last_frame": rows[-1][1],
        "n_frames": len(rows),
        "mean_size": round(float(sizes.mean()), 1),
        "mean_lab": [round(float(v), 2) for v in np.average(colors, axis=0, weights=sizes + 1e-9)],
        "frames": [row[1] for row in rows],
        "sizes": [row[3] for row in rows],
        "centers": [None if row[7] is None else list(row[7:10]) for row in rows],
        "boxes": [None if row[7] is None else [list(row[10:13]), list(row[13:16])] for row in rows],
    }


def _flat(vectors: Any) -> list[float]:
    return [round(float(value), 4) for vector in vectors for value in vector]
