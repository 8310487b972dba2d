"""Whole runs: queues, files, interruption, and going on."""

from __future__ import annotations

import threading
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from geohue import GeohueError, Scene, VideoSegmenter
from geohue.datasets import Frame
from geohue.simulate.moving import MovingFrame
from geohue.video.encode import VideoWriter
from geohue.video.queues import Feed, Sink
from geohue.video.realsense import RealSenseCamera
from geohue.video.run import run_video
from geohue.video.sources import FileCamera, PacedCamera, Shot, video_frames
from geohue.video.tables import TrackTable
from geohue.video.tracks import Sighting

av = pytest.importorskip("av")


class Numbers:
    """A camera that counts."""

    def __init__(self, n: int) -> None:
        self.n, self.at, self.closed = n, 0, False

    def read(self) -> Shot | None:
        self.at += 1
        return Shot(self.at - 1, str(self.at - 1), None) if self.at <= self.n else None

    def close(self) -> None:
        self.closed = True


def taken(feed: Feed) -> list[int]:
    found = []
    while (item := feed.next()) is not None:
        found.append(item[0].number)
    return found


def test_a_recording_is_read_whole() -> None:
    camera = Numbers(20)
    feed = Feed(camera)
    time.sleep(0.05)
    assert camera.at <= 6  # four wait, one is in hand
    assert taken(feed) == list(range(20))
    assert feed.dropped == 0
    feed.close()
    assert camera.closed


def test_a_live_camera_drops_what_is_late_and_counts_it() -> None:
    camera = Numbers(20)
    feed = Feed(camera, drop=True)
    while camera.at < 21:
        time.sleep(0.01)
    time.sleep(0.05)
    assert taken(feed) == [16, 17, 18, 19]
    assert feed.dropped == 16
    feed.close()


def test_errors_of_threads_reach_the_one_who_waits() -> None:
    class Broken(Numbers):
        def read(self) -> Shot | None:
            raise GeohueError("the cable is out")

    feed = Feed(Broken(1))
    with pytest.raises(GeohueError, match="cable"):
        feed.next()
    feed.close()

    def full(_: int) -> None:
        raise GeohueError("the disk is full")

    sink = Sink(full)
    sink.put(1)
    with pytest.raises(GeohueError, match="disk"):
        sink.close()


def test_a_paced_camera_keeps_its_rate() -> None:
    camera = PacedCamera(Numbers(4), 50.0)
    start = time.perf_counter()
    while camera.read() is not None:
        pass
    assert time.perf_counter() - start >= 0.079
    camera.close()
    with pytest.raises(GeohueError, match="above 0"):
        PacedCamera(Numbers(1), 0.0)


def test_ctrl_c_ends_a_run_with_what_was_done(film: list[MovingFrame]) -> None:
    def stopped() -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
        return film[0].scene.colors

    def show(shot: Shot, _: object) -> bool:
        if shot.number == 2:
            raise KeyboardInterrupt
        return True

    depth = film[0].scene.depth
    assert depth is not None
    frames = [Frame(str(i), stopped, lambda: depth) for i in range(9)]
    before = threading.active_count()
    with VideoSegmenter("fast") as video:
        report = run_video(FileCamera(frames), video, show=show)
        assert report.interrupted
        assert report.n_frames == 3
        again = run_video(FileCamera(frames, 3), video, limit=2)
    assert not again.interrupted
    assert again.n_frames == 2
    assert again.summary()["latency_s"]["p50"] > 0
    assert threading.active_count() == before


@pytest.mark.parametrize("kind", ["webm", "mp4"])
def test_videos_play_and_go_on(tmp_path: Path, kind: str) -> None:
    first, second = tmp_path / f"a.{kind}", tmp_path / f"b.{kind}"
    writer = VideoWriter(first, 25.0)
    for i in range(6):
        writer.write(np.full((49, 65, 3), 30 * i, np.uint8))
    writer.close()
    writer.close()
    more = VideoWriter(second, 25.0, first, copied=4)
    for size in ((49, 65), (30, 40)):
        more.write(np.full((*size, 3), 250, np.uint8))
    more.close()
    with av.open(str(second)) as video:
        stream = video.streams.video[0]
        pictures = [frame.to_ndarray(format="rgb24") for frame in video.decode(stream)]
        assert stream.average_rate == 25
    assert [p.shape for p in pictures] == [(48, 64, 3)] * 6
    wanted = [0, 30, 60, 90, 250, 250]
    assert [p.mean() for p in pictures] == pytest.approx(wanted, abs=6)


def test_videos_that_cannot_be(tmp_path: Path) -> None:
    with pytest.raises(GeohueError, match="webm"):
        VideoWriter(tmp_path / "a.gif")


def test_tables_are_read_as_written(tmp_path: Path) -> None:
    table = TrackTable()
    lab, place = np.array([50.0, 1, 2]), np.array([0.25, 0.75])
    corner = np.array([1.0, 2, 3])
    table.add("a", [Sighting(4, 0, 10, lab, corner, corner - 1, corner + 1, place)])
    table.add("c", [Sighting(4, 2, 30, lab + 4, None, None, None, place)])
    table.write_csv(tmp_path / "tracks.csv")
    again = TrackTable.read_csv(tmp_path / "tracks.csv")
    assert again.rows == table.rows
    (track,) = again.tracks()
    assert (track["first_frame"], track["last_frame"], track["mean_size"]) == (0, 2, 20)
    assert track["mean_lab"] == [53, 4, 5]
    assert track["centers"] == [[1, 2, 3], None]
    assert track["boxes"] == [[[0, 1, 2], [2, 3, 4]], None]
    last = again.last()[4]
    assert (last.first, last.last.frame, last.n_frames, last.last.center) == (0, 2, 2, None)
    (tmp_path / "tracks.csv").write_text("a,b\n")
    with pytest.raises(GeohueError, match=r"tracks\.csv"):
        TrackTable.read_csv(tmp_path / "tracks.csv")


def test_a_color_video_with_depth_maps_is_a_recording(tmp_path: Path) -> None:
    writer = VideoWriter(tmp_path / "rgb.mp4", 30.0)
    for i in range(5):
        writer.write(np.full((48, 64, 3), 40 * i, np.uint8))
    writer.close()
    (tmp_path / "depth").mkdir()
    for i in range(4):
        np.save(tmp_path / "depth" / f"{i}.npy", np.full((48, 64), 1.0 + i, np.float32))
    frames = video_frames(tmp_path / "rgb.mp4", tmp_path / "depth")
    assert len(frames) == 4
    for i in (0, 1, 3, 2):  # back once
        scene = frames[i].scene()
        assert scene.depth is not None
        assert scene.depth[0, 0] == 1 + i
        assert scene.colors.mean() == pytest.approx(40 * i, abs=6)
    with pytest.raises(GeohueError, match="depth maps"):
        video_frames(tmp_path / "rgb.mp4", tmp_path)
    (tmp_path / "bad.mp4").write_bytes(b"nothing")
    with pytest.raises(GeohueError, match="cannot be decoded"):
        video_frames(tmp_path / "bad.mp4", tmp_path / "depth")


def test_damaged_frames_have_a_reason(film: list[MovingFrame]) -> None:
    def damaged() -> np.ndarray[tuple[int, ...], np.dtype[np.float32]]:
        raise GeohueError("depth.png: is cut short")

    camera = FileCamera([Frame("a", lambda: film[0].scene.colors, damaged)])
    with VideoSegmenter("fast") as video:
        report = run_video(camera, video)
    assert report.skipped == [("a", "depth.png: is cut short")]
    assert report.summary()["n_skipped"] == 1
    assert report.summary()["latency_s"]["p50"] is None


def test_a_realsense_gives_scenes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Intel's package in the shape that `RealSenseCamera` uses it in."""
    lens = SimpleNamespace(fx=60.0, fy=60.0, ppx=31.5, ppy=23.5, width=64, height=48)
    profile = SimpleNamespace(
        get_device=lambda: SimpleNamespace(
            first_depth_sensor=lambda: SimpleNamespace(get_depth_scale=lambda: 0.001)
        ),
        get_stream=lambda _: SimpleNamespace(
            as_video_stream_profile=lambda: SimpleNamespace(get_intrinsics=lambda: lens)
        ),
    )
    calls: list[str] = []
    waits = iter([True, False])

    def wait() -> SimpleNamespace:
        if not next(waits):
            raise RuntimeError("Frame didn't arrive within 5000")
        color = np.full((48, 64, 3), 7, np.uint8)
        depth = np.full((48, 64), 1500, np.uint16)
        return SimpleNamespace(
            get_color_frame=lambda: SimpleNamespace(get_data=lambda: color),
            get_depth_frame=lambda: SimpleNamespace(get_data=lambda: depth),
        )

    fake = SimpleNamespace(
        stream=SimpleNamespace(color=1, depth=2),
        format=SimpleNamespace(rgb8=1, z16=2),
        config=lambda: SimpleNamespace(
            enable_device=calls.append, enable_stream=lambda *wish: calls.append(str(wish))
        ),
        pipeline=lambda: SimpleNamespace(
            start=lambda _: profile, wait_for_frames=wait, stop=lambda: calls.append("stop")
        ),
        align=lambda _: SimpleNamespace(process=lambda frames: frames),
    )
    monkeypatch.setitem(__import__("sys").modules, "pyrealsense2", fake)
    camera = RealSenseCamera("123", 64, 48, 15)
    scene = camera.read().scene
    assert isinstance(scene, Scene)
    assert scene.depth is not None
    assert scene.depth[0, 0] == pytest.approx(1.5)
    assert scene.intrinsics is not None
    assert scene.intrinsics.fx == 60
    assert "arrive" in camera.read().error
    camera.close()
    assert calls == ["123", "(1, 64, 48, 1, 15)", "(2, 64, 48, 2, 15)", "stop"]


def test_a_missing_package_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "pyrealsense2", None)
    with pytest.raises(GeohueError, match=r"geohue\[realsense\]"):
        RealSenseCamera()
