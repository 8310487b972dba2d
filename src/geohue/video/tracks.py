"""Segments of one frame and the next: which are the same thing."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Labels = NDArray[np.int32]
Vector = NDArray[np.float64]

LEAST = 0.25
"""Score below which a segment is not a track's."""

MEMORY = 30
"""Frames for which a track that is not seen is remembered."""

COLOR = 15.0
"""Lab units between two mean colours that count as one deviation; those of L count half, as
exposure changes."""

REACH = 0.02
"""Share of its depth, or without depth of the picture, that a thing may move in a frame."""

BESIDE = 0.05
"""Share of the picture's sides by which a thing without depth may be displaced."""


@dataclass(frozen=True, slots=True, eq=False)
class Sighting:
    """What a track looks like in one frame.

    Attributes
    ----------
    track : int
        Its identity, the value in the labels.
    frame : int
        Counted from 0.
    size : int
        Pixels.
    color : (3,) float64
        Mean CIELab.
    center : (3,) float64 or None
        Mean position, in the world where the pose is known, else in the camera; None without depth.
    low, high : (3,) float64 or None
        Its box there, along the axes, from the 2nd to the 98th percentile: strays of a sensor must
        not stretch it.
    place : (2,) float64
        Mean row and column, as shares of height and width.
    """

    track: int
    frame: int
    size: int
    color: Vector
    center: Vector | None
    low: Vector | None
    high: Vector | None
    place: Vector


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """One thing through time.

    Attributes
    ----------
    id : int
        The value in the labels.
    first : int
        Frame in which it was first seen.
    last : Sighting
        What it looked like when it was last seen.
    n_frames : int
        In how many frames it was seen.
    """

    id: int
    first: int
    last: Sighting
    n_frames: int


def sightings(
    labels: Labels,
    lab: NDArray[np.floating],
    points: NDArray[np.floating],
    frame: int,
    scale: float = 1.0,
) -> list[Sighting]:
    """Describe each segment of a draft.

    Parameters
    ----------
    labels : (h, w) int32
        Segments 0..K-1, each with a pixel.
    lab, points : (h, w, 3) float
        Colours and positions; NaN where there is none.
    frame : int
        Its number.
    scale : float
        Pixels of the frame for each of the draft.

    Returns
    -------
    list of Sighting
        In the order of the segments; the track is the segment's number.
    """
    flat, count = labels.reshape(-1), np.bincount(labels.reshape(-1))
    y, x = ((np.indices(labels.shape)[i].reshape(-1) + 0.5) / labels.shape[i] for i in (0, 1))
    mean = np.stack([np.bincount(flat, v) / count for v in (*lab.reshape(-1, 3).T, y, x)], axis=1)
    order = np.argsort(flat, kind="stable")
    parts = np.split(points.reshape(-1, 3)[order], np.cumsum(count)[:-1])
    found = []
    for i, part in enumerate(parts):
        known = np.sort(part[np.isfinite(part[:, 2])].astype(np.float64), axis=0)
        n = len(known)
        center, low, high = (
            (known.mean(axis=0), known[n // 50], known[n - 1 - n // 50]) if n else (None,) * 3
        )
        size = round(float(count[i]) * scale)
        found.append(Sighting(i, frame, size, mean[i, :3], center, low, high, mean[i, 3:]))
    return found


class Tracker:
    """Gives segments the identities of the tracks that they continue.

    Parameters
    ----------
    memory : int
        Frames for which a track that is not seen is remembered.
    """

    def __init__(self, memory: int = MEMORY) -> None:
        self.memory = memory
        self.tracks: dict[int, Track] = {}
        self._next = 0

    def restore(self, tracks: dict[int, Track], following: int) -> None:
        """Go on with the tracks of an earlier run; new ones get numbers from `following`."""
        now = max((track.last.frame for track in tracks.values()), default=0)
        self.tracks, self._next = _remembered(tracks, now, self.memory), following

    def forget(self) -> None:
        """Let all tracks end, as after a cut."""
        self.tracks = {}

    @property
    def following(self) -> int:
        """The number of the next new track."""
        return self._next

    def identify(self, seen: list[Sighting], overlap: NDArray[np.float64]) -> list[Sighting]:
        """Decide which track each segment continues.

        The segments and tracks that fit best are paired (Hungarian method), by overlap, mean
        colour, place and size (`scores`); pairs below `LEAST` stay apart, and a segment that is
        left over begins a new track.

        Parameters
        ----------
        seen : list of Sighting
            The segments of a frame.
        overlap : (T, K) float64
            Intersection over union of each track of `tracks`, in their order, and each segment.

        Returns
        -------
        list of Sighting
            The same with their tracks.
        """
        from scipy.optimize import linear_sum_assignment

        old = list(self.tracks.values())
        value = scores(old, seen, overlap)
        now = seen[0].frame if seen else 0
        value[[now - track.last.frame > self.memory for track in old]] = 0
        track_of = np.full(len(seen), -1)
        for t, s in zip(*linear_sum_assignment(value, maximize=True), strict=True):
            if value[t, s] >= LEAST:
                track_of[s] = old[t].id
        named = []
        for one, track in zip(seen, track_of.tolist(), strict=True):
            if track < 0:
                track, self._next = self._next, self._next + 1
            named.append(replace(one, track=track))
        self._remember(named)
        return named

    def _remember(self, named: list[Sighting]) -> None:
        for one in named:
            known = self.tracks.get(one.track)
            first, n = (one.frame, 1) if known is None else (known.first, known.n_frames + 1)
            self.tracks[one.track] = Track(one.track, first, one, n)
        now = named[0].frame if named else 0
        self.tracks = _remembered(self.tracks, now, self.memory)


def _remembered(tracks: dict[int, Track], now: int, memory: int) -> dict[int, Track]:
    return {name: one for name, one in tracks.items() if now - one.last.frame <= memory}


def scores(
    tracks: list[Track], seen: list[Sighting], overlap: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return how well tracks and segments fit, (T, K) in 0..3.

    Twice the overlap, plus likeness of colour times nearness times the fourth root of the ratio
    of sizes: what comes out from behind something is small at first. Nearness is 1 in the same
    place and falls with the distance in units of the thing's radius and of how far it may have
    moved since it was last seen.

    Parameters
    ----------
    tracks : list of Track
        T tracks.
    seen : list of Sighting
        K segments of one frame.
    overlap : (T, K) float64
        Intersection over union.
    """
    if not tracks or not seen:
        return np.zeros((len(tracks), len(seen)))
    last = [track.last for track in tracks]
    away = _each(seen, "color") - _each(last, "color")[:, None]
    alike = np.exp(-((away * (0.5, 1.0, 1.0) / COLOR) ** 2).sum(axis=2))
    one, other = _each(last, "size")[:, None], _each(seen, "size")
    ratio = np.minimum(one, other) / np.maximum(np.maximum(one, other), 1)
    return np.asarray(2 * overlap + alike * _nearness(last, seen) * ratio**0.25)


def _nearness(last: list[Sighting], seen: list[Sighting]) -> NDArray[np.float64]:
    waited = _each(seen, "frame") - _each(last, "frame")[:, None]
    center, here = _each(last, "center"), _each(seen, "center")
    depth = np.sqrt((here**2).sum(axis=1))
    radius = np.sqrt(((_each(last, "high") - _each(last, "low")) ** 2).sum(axis=1)) / 2
    reach = np.maximum(radius[:, None] + REACH * depth * waited, 1e-12)
    away = ((here - center[:, None]) ** 2).sum(axis=2) / reach**2
    flat = ((_each(seen, "place") - _each(last, "place")[:, None]) ** 2).sum(axis=2)
    flat = flat / (BESIDE + REACH * waited) ** 2
    return np.asarray(np.exp(-np.where(np.isfinite(away), away, flat)))


def _each(sightings: list[Sighting], name: str) -> NDArray[np.float64]:
    """One of their values as an array, NaN where there is none."""
    none = np.full(3, np.nan)
    values = [getattr(one, name) for one in sightings]
    return np.array([none if value is None else value for value in values], np.float64)
