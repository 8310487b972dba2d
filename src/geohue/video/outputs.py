"""The folder of a run: overlay video, label maps, tracks, fused cloud, and how to go on with it."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue._version import __version__
from geohue.datasets.frames import Frame
from geohue.errors import GeohueError
from geohue.read.files import broken, read_bytes, reason
from geohue.read.images.pictures import read_written_labels
from geohue.results.folder import Kind, check_result_folder, move_results
from geohue.results.labels import write_labels
from geohue.results.picture import overlay
from geohue.video.encode import VideoWriter
from geohue.video.fused import FusedCloud
from geohue.video.segmenter import VideoSegmenter
from geohue.video.sources import Shot
from geohue.video.tables import TrackTable, write_json
from geohue.video.tracks import Sighting

Labels = NDArray[np.int32]

VIDEO = Kind(
    "video.json",
    frozenset({"video.json", "tracks.json", "tracks.csv", "cloud.ply", "labels"})
    | {"overlay.webm", "overlay.mp4"},
    frozenset({"overlay.more.webm", "overlay.more.mp4"}),
)
"""What ``geohue video`` writes."""

SAVE_EVERY = 100
"""Frames after which the tables are written, lest a killed run has none."""


@dataclass(frozen=True, slots=True)
class Wishes:
    """What is written, and how the run was asked for.

    Attributes
    ----------
    kind : str
        "webm", "mp4" or "none".
    rate : float
        Frames a second of the video.
    voxel : float or None
        Edge of the voxels of the fused cloud; None for no cloud.
    labels : bool
        Whether label maps are written; without them a run cannot be resumed.
    settings : dict
        What must be the same for a run to be resumed.
    """

    kind: str
    rate: float
    voxel: float | None
    labels: bool
    settings: Mapping[str, Any]


class Outputs:
    """Writes a run to a folder, frame by frame.

    Parameters
    ----------
    folder : Path
        Made if it is missing.
    wishes : Wishes
    earlier : Earlier, optional
        What a run that is resumed had done; without it an earlier run's files are removed.
    overwrite : bool
        Whether to write into a folder that has other files than those of an earlier run.

    Raises
    ------
    GeohueError
        If an encoder is missing, or the folder has other files or cannot be written to.
    """

    def __init__(
        self,
        folder: Path,
        wishes: Wishes,
        earlier: Earlier | None = None,
        *,
        overwrite: bool = False,
    ) -> None:
        check_result_folder(folder, VIDEO, overwrite=overwrite)
        self._folder, self._wishes = folder, wishes
        self._table = TrackTable() if earlier is None else earlier.table
        self._frames: list[str] = [] if earlier is None else list(earlier.frames)
        self._cloud = None if wishes.voxel is None else FusedCloud(wishes.voxel)
        self._video: VideoWriter | None = None
        self._whole: Path | None = None
        if wishes.kind != "none":
            path = folder / f"overlay.{wishes.kind}"
            old = path if earlier is not None and path.exists() else None
            self._whole, begun = (
                (path, folder / f"overlay.more.{wishes.kind}")
                if old
                else (
                    None,
                    path,
                )
            )
            copied = 0 if earlier is None else len(earlier.frames)
            self._video = VideoWriter(begun, wishes.rate, old, copied)
            self._begun = begun
        if earlier is None:
            move_results({}, folder, VIDEO)
            self._save({"interrupted": True})  # from now on the folder is that of a run

    def add(self, shot: Shot, labels: Labels, seen: Sequence[Sighting]) -> None:
        """Write a frame."""
        assert shot.scene is not None
        if self._video is not None:
            self._video.write(overlay(shot.scene.colors, labels))
        if self._wishes.labels:
            write_labels(self._folder / "labels" / shot.name.replace("/", "_"), labels)
        if self._cloud is not None:
            self._cloud.add(shot.scene, labels, shot.pose)
        self._table.add(shot.name, list(seen))
        self._frames.append(shot.name)
        if len(self._frames) % SAVE_EVERY == 0:
            self._save({"interrupted": True})

    def fuse(self, frame: Frame) -> None:
        """Add a frame of the run that is resumed to the cloud."""
        if self._cloud is not None:
            labels = read_written_labels(self._folder / "labels" / frame.name.replace("/", "_"))
            self._cloud.add(frame.scene(), labels, frame.T_world_camera)

    def finish(self, summary: Mapping[str, Any]) -> None:
        """Close the video, and write the tables and the cloud."""
        try:
            if self._video is not None:
                self._video.close()
                if self._whole is not None and self._begun.exists():
                    self._begun.replace(self._whole)
        finally:
            self._save(summary)
        if self._cloud is not None and len(self._cloud):
            self._cloud.write(self._folder / "cloud.ply")

    def _save(self, summary: Mapping[str, Any]) -> None:
        self._table.write_csv(self._folder / "tracks.csv")
        write_json(self._folder / "tracks.json", {"tracks": self._table.tracks()})
        last = self._table.rows[-1][1] if self._table.rows else -1
        facts = {"version": __version__, **self._wishes.settings, "last_frame": last, **summary}
        write_json(self._folder / "video.json", {**facts, "frames": self._frames})


@dataclass(frozen=True, slots=True, eq=False)
class Earlier:
    """What a run that is resumed had done.

    Attributes
    ----------
    table : TrackTable
        Its sightings.
    frames : tuple of str
        Names of the frames it segmented.
    last : int
        Number of the last of them.
    """

    table: TrackTable
    frames: tuple[str, ...]
    last: int


def read_earlier(folder: Path, settings: Mapping[str, Any]) -> Earlier | None:
    """Read what an earlier run left in a folder; None if there was none.

    Raises
    ------
    GeohueError
        If its files are damaged, or it was run with other settings.
    """
    file = folder / "video.json"
    if not file.exists():
        return None
    try:
        facts = json.loads(read_bytes(file))
        frames, last = tuple(map(str, facts["frames"])), int(facts["last_frame"])
    except (ValueError, KeyError, TypeError) as error:
        raise broken(file, f"is damaged ({reason(error)}); choose another folder") from error
    for name, value in settings.items():
        if facts.get(name) != value:
            raise GeohueError(
                f"{folder}: was begun with {name} {facts.get(name)!r}, not {value!r}: "
                "resume with the same, or choose another folder"
            )
    return Earlier(TrackTable.read_csv(folder / "tracks.csv"), frames, last) if frames else None


def go_on(segmenter: VideoSegmenter, folder: Path, earlier: Earlier, frame: Frame) -> None:
    """Bring a segmenter to where an earlier run was.

    Parameters
    ----------
    segmenter : VideoSegmenter
        One that has seen no frame.
    folder : Path
        Of the run.
    earlier : Earlier
        What it did.
    frame : Frame
        The last frame that it segmented.
    """
    labels = read_written_labels(folder / "labels" / frame.name.replace("/", "_"))
    tracks = earlier.table.last()
    segmenter.resume(frame.scene(), labels, tracks, earlier.last, frame.T_world_camera)
