"""Speed, steadiness and quality of segmented sequences.

    python -m benchmarks.video DATA [--presets fast best] [--only simulated panned ...]

simulated: 90 frames of `geohue.simulate.moving` (320 x 240, Kinect), with exact truth and motion.
panned: 15 labelled frames of NYU (test part), each seen through a window that moves 5 pixels a
frame across it for 12 frames, with fresh noise: real pictures, true labels, exact motion.
sevenscenes: 40 frames with poses; motion is the reprojection. ist_maizena2: 11 frames,
unregistered.

Every frame is segmented by `VideoSegmenter` and alone by `segment`; the segments of the frames
alone get the names of those before that they overlap most along the motion, as many as can be.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from benchmarks.splits import part
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from geohue import Intrinsics, Scene, VideoSegmenter, segment
from geohue.datasets import open_dataset
from geohue.measures import (
    flicker,
    identity_switches,
    steadiness,
    variation_of_information,
)
from geohue.measures.crop import PROTOCOLS
from geohue.simulate.moving import moving_scene
from geohue.studies.benchmark.frames import find_frames, load_frame

Labels = NDArray[np.int32]
Places = NDArray[np.int64]

LOST = 0.03
"""Relative difference of depth beyond which a pixel is not the same as before."""


class Moment(NamedTuple):
    """A frame of a sequence; the truth is -1 where there is none."""

    scene: Scene
    pose: NDArray[np.float64] | None
    truth: Labels | None
    target: Places | None  # of the pixels of the frame before


def landing(moved: NDArray[np.float64], scene: Scene) -> Places:
    """Where points in the camera of a frame are seen in it, -1 where something else is."""
    camera, shape = scene.intrinsics, scene.shape
    assert camera is not None
    assert scene.depth is not None
    with np.errstate(invalid="ignore", divide="ignore"):
        u = np.rint(camera.fx * moved[..., 0] / moved[..., 2] + camera.cx)
        v = np.rint(camera.fy * moved[..., 1] / moved[..., 2] + camera.cy)
        inside = (u >= 0) & (v >= 0) & (u < shape[1]) & (v < shape[0]) & (moved[..., 2] > 0)
        place = np.where(inside, v * shape[1] + u, -1).astype(np.int64)
        there = scene.depth.reshape(-1)[place]
        same = inside & (np.abs(there - moved[..., 2]) < LOST * moved[..., 2])
    return np.where(same, place, -1)


def simulated(_: Path) -> Iterator[list[Moment]]:
    """The moving room; each point moves with its thing."""
    moments: list[Moment] = []
    last = None
    for frame in moving_scene(sensor="kinect"):
        target = None
        if last is not None:
            world = last.scene.points.astype(np.float64) @ last.pose[:3, :3].T + last.pose[:3, 3]
            world = world + (frame.places - last.places)[last.truth]
            moved = (world - frame.pose[:3, 3]) @ frame.pose[:3, :3]
            target = landing(moved, frame.scene)
            seen = target >= 0
            seen[seen] = frame.truth.reshape(-1)[target[seen]] == last.truth[seen]
            target = np.where(seen, target, -1)
        moments.append(Moment(frame.scene, frame.pose, frame.truth, target))
        last = frame
    yield moments


def panned(data: Path) -> Iterator[list[Moment]]:
    """A window that moves over labelled frames."""
    names = part("nyuv2", "test")[::8][:15]
    for frame in find_frames(data / "nyuv2"):
        if frame.name not in names:
            continue
        scene, truth = load_frame(frame, PROTOCOLS["nyu"])
        assert scene.depth is not None
        assert scene.intrinsics is not None
        rng, lens, moments = np.random.default_rng(0), scene.intrinsics, []
        height, width = scene.shape[0] - 24, scene.shape[1] - 60
        for i in range(12):
            y, x = 2 * i, 5 * i
            window = slice(y, y + height), slice(x, x + width)
            depth = scene.depth[window].astype(np.float64)
            depth = depth + rng.normal(0, 0.0015, depth.shape) * depth**2
            noisy = scene.colors[window] + rng.normal(0, 2, (height, width, 3))
            colors = np.clip(np.rint(noisy), 0, 255).astype(np.uint8)
            camera = Intrinsics(lens.fx, lens.fy, lens.cx - x, lens.cy - y, width, height)
            rows, columns = np.indices((height, width))
            rows, columns = rows - 2, columns - 5
            inside = (rows >= 0) & (columns >= 0)
            target = np.where(inside, rows * width + columns, -1)
            one = Scene.from_rgbd(colors, depth, camera)
            moments.append(Moment(one, None, truth[window] - 1, target if i else None))
        yield moments


def recorded(data: Path, name: str) -> Iterator[list[Moment]]:
    """A recording; with poses its pixels are followed by reprojection."""
    moments: list[Moment] = []
    last = None
    for frame in open_dataset(data / name):
        scene, pose, target = frame.scene(), frame.T_world_camera, None
        if last is not None and pose is not None and last.T_world_camera is not None:
            way = np.linalg.inv(pose) @ last.T_world_camera
            moved = moments[-1].scene.points @ way[:3, :3].T + way[:3, 3]
            target = landing(moved, scene)
        moments.append(Moment(scene, pose, None, target))
        last = frame
    yield moments


def renamed(labels: Labels, before: Labels | None, target: Places | None, free: int) -> Labels:
    """Give the segments of a frame alone the names of those that they overlap most."""
    n = int(labels.max()) + 1
    names = np.arange(free, free + n)
    if before is not None:
        if target is None:
            target = np.arange(labels.size).reshape(labels.shape)
        seen = target >= 0
        old, new = before[seen], labels.reshape(-1)[target[seen]]
        table = np.zeros((int(old.max()) + 1, n))
        np.add.at(table, (old, new), 1)
        for a, b in zip(*linear_sum_assignment(table, maximize=True), strict=True):
            if table[a, b] > 0:
                names[b] = a
    return names[labels].astype(np.int32)


class Run(NamedTuple):
    """The labels of a sequence, with the seconds of each frame."""

    labels: list[Labels]
    seconds: list[float]
    tracks: int


def by_video(moments: list[Moment], preset: str, poses: bool) -> Run:
    """Segment a sequence with identities; making each scene from its arrays counts."""
    labels, seconds = [], []
    with VideoSegmenter(preset) as video:
        for moment in moments:
            start, scene = time.perf_counter(), moment.scene
            if scene.depth is not None:
                scene = Scene.from_rgbd(scene.colors, scene.depth, scene.intrinsics)
            labels.append(video.update(scene, moment.pose if poses else None).labels)
            seconds.append(time.perf_counter() - start)
        return Run(labels, seconds, video.tracker.following)


def alone(moments: list[Moment], preset: str) -> Run:
    """Segment each frame by itself."""
    labels: list[Labels] = []
    seconds, free = [], 0
    for moment in moments:
        start = time.perf_counter()
        found = segment(moment.scene, preset=preset).labels
        seconds.append(time.perf_counter() - start)
        labels.append(renamed(found, labels[-1] if labels else None, moment.target, free))
        free = max(free, int(labels[-1].max()) + 1)
    return Run(labels, seconds, free)


def figures(moments: list[Moment], run: Run) -> list[float]:
    """VoI, kept, kept at borders, flicker, switches, segments, tracks, first, p50, p95, p99."""
    pairs = list(zip(moments, run.labels, strict=True))
    truth = [(m.truth, found) for m, found in pairs if m.truth is not None]
    voi = [variation_of_information(found + 1, true + 1).total for true, found in truth]
    steady = [
        steadiness(a, b, moment.target)
        for moment, a, b in zip(moments[1:], run.labels, run.labels[1:], strict=False)
        if moment.target is not None
    ]
    targets = [moment.target for moment in moments[1:] if moment.target is not None]
    switches = identity_switches([t for t, _ in truth], [found for _, found in truth], least=60)
    late = 1000 * np.percentile(run.seconds[1:], (50, 95, 99))
    return [
        float(np.mean(voi)) if voi else np.nan,
        *(np.mean([s[:2] for s in steady], axis=0) if steady else (np.nan, np.nan)),
        flicker(run.labels, targets) if len(targets) > 1 else np.nan,
        float(sum(switches.values())) if truth else np.nan,
        float(np.mean([len(np.unique(found)) for found in run.labels])),
        float(run.tracks),
        1000 * run.seconds[0],
        *late,
    ]


def main() -> None:
    """Print a row for each sequence, preset and way."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("data", type=Path)
    parser.add_argument("--presets", nargs="+", default=["fast", "best"])
    parser.add_argument("--only", nargs="+")
    given = parser.parse_args()
    kinds: dict[str, Callable[[Path], Iterator[list[Moment]]]] = {
        "simulated": simulated,
        "panned": panned,
        "sevenscenes": lambda data: recorded(data, "sevenscenes"),
        "ist_maizena2": lambda data: recorded(data, "ist_maizena2/cam1"),
    }
    print(
        "| sequence | preset | way | VoI | kept | at borders | flicker | switches | K | tracks "
        "| first ms | p50 | p95 | p99 |"
    )
    print("|---|---|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|")
    for kind in given.only or kinds:
        rows: dict[tuple[str, str], list[list[float]]] = {}
        for moments in kinds[kind](given.data):
            for preset in given.presets:
                runs = {"video": by_video(moments, preset, False), "alone": alone(moments, preset)}
                if moments[0].pose is not None:
                    runs["video, poses"] = by_video(moments, preset, True)
                for way, run in runs.items():
                    rows.setdefault((preset, way), []).append(figures(moments, run))
        for (preset, way), found in rows.items():
            v = np.mean(found, axis=0)
            print(
                f"| {kind} | {preset} | {way} | {v[0]:.3f} | {100 * v[1]:.2f} % "
                f"| {100 * v[2]:.2f} % | {100 * v[3]:.3f} % | {v[4]:.1f} | {v[5]:.1f} "
                f"| {v[6]:.1f} | {v[7]:.0f} | {v[8]:.0f} | {v[9]:.0f} | {v[10]:.0f} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
