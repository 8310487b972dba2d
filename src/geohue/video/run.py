"""A whole sequence: read ahead, segment, write behind."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.video.outputs import Outputs
from geohue.video.queues import Feed, Sink
from geohue.video.segmenter import VideoSegmenter
from geohue.video.sources import Camera, Shot
from geohue.video.tracks import Sighting

Labels = NDArray[np.int32]
Made = tuple[Shot, Labels, list[Sighting]]
Show = Callable[[Shot, Labels], bool]
"""Called with each frame and its labels; false ends the run."""


@dataclass(slots=True)
class Report:
    """How a run went.

    Attributes
    ----------
    n_frames : int
        Frames that were segmented.
    skipped : list of (str, str)
        Frames that could not be read, and why.
    dropped : int
        Frames that a live run left out, so as not to fall behind.
    latencies : list of float
        Seconds from a frame's being read to its labels; of a recording, which is read ahead,
        those of its segmenting.
    work : list of float
        Seconds of segmenting each frame.
    seconds : float
        From the first frame to the last.
    interrupted : bool
    """

    n_frames: int = 0
    skipped: list[tuple[str, str]] = field(default_factory=list)
    dropped: int = 0
    latencies: list[float] = field(default_factory=list)
    work: list[float] = field(default_factory=list)
    seconds: float = 0.0
    interrupted: bool = False

    def summary(self) -> dict[str, Any]:
        """Return the figures, ready for JSON; times of frames without the first."""
        later = self.latencies[1:] or self.latencies
        percentiles = np.percentile(later, (50, 95, 99)) if later else (None,) * 3
        return {
            "n_frames": self.n_frames,
            "n_skipped": len(self.skipped),
            "n_dropped": self.dropped,
            "frames_per_second": _rounded(self.n_frames / self.seconds if self.seconds else None),
            "first_frame_s": _rounded(self.work[0] if self.work else None),
            "segmenting_s": _rounded(float(np.median(self.work[1:] or self.work or [0.0]))),
            "latency_s": {
                name: _rounded(value)
                for name, value in zip(("p50", "p95", "p99"), percentiles, strict=True)
            },
            "skipped": [{"frame": name, "error": why} for name, why in self.skipped],
            "interrupted": self.interrupted,
        }


def run_video(
    camera: Camera,
    segmenter: VideoSegmenter,
    outputs: Outputs | None = None,
    *,
    live: bool = False,
    show: Show | None = None,
    limit: int | None = None,
) -> Report:
    """Segment what a camera gives until it ends or the run is interrupted.

    Parameters
    ----------
    camera : Camera
        Closed at the end.
    segmenter : VideoSegmenter
    outputs : Outputs, optional
        What is written; finished at the end, also after Ctrl-C.
    live : bool
        Drop frames rather than fall behind.
    show : callable, optional
        Called with each frame and its labels; the run ends when it returns false.
    limit : int, optional
        Most frames to segment.

    Returns
    -------
    Report
    """
    report, start = Report(), time.perf_counter()
    feed = Feed(camera, drop=live)
    sink: Sink[Made] | None = None
    if outputs is not None:
        sink = Sink(lambda made: outputs.add(*made))
    try:
        while limit is None or report.n_frames < limit:
            item = feed.next()
            if item is None:
                break
            shot, read_at = item
            since = read_at if live else time.perf_counter()
            if not _step(shot, since, segmenter, sink, report, show):
                break
    except KeyboardInterrupt:
        report.interrupted = True
    finally:
        feed.close()
        report.dropped, report.seconds = feed.dropped, time.perf_counter() - start
        try:
            if sink is not None:
                sink.close()
        finally:
            if outputs is not None:
                outputs.finish(report.summary() | {"models": segmenter.models})
    return report


def _step(
    shot: Shot,
    since: float,
    segmenter: VideoSegmenter,
    sink: Sink[Made] | None,
    report: Report,
    show: Show | None,
) -> bool:
    """Segment one frame; false ends the run."""
    if shot.scene is None:
        report.skipped.append((shot.name, shot.error))
        return True
    begun = time.perf_counter()
    labels = segmenter.update(shot.scene, shot.pose, frame=shot.number).labels
    now = time.perf_counter()
    report.n_frames += 1
    report.work.append(now - begun)
    report.latencies.append(now - since)
    if sink is not None:
        sink.put((shot, labels, segmenter.seen))
    return show is None or show(shot, labels)


def _rounded(value: float | None) -> float | None:
    return None if value is None else round(float(value), 4)
