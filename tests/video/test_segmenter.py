"""Sequences: labels that stay with their things, through all that happens to a camera."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from geohue import GeohueError, Scene, VideoSegmenter, segment
from geohue.measures import identity_switches, variation_of_information
from geohue.simulate.moving import ENTERING, HIDDEN, MOVING, MovingFrame
from geohue.video.past import contingency

Labels = NDArray[np.int32]


def run(film: Iterable[MovingFrame], poses: bool = True, **options: object) -> list[Labels]:
    with VideoSegmenter("fast", **options) as video:  # type: ignore[arg-type]
        return [video.update(f.scene, f.pose if poses else None).labels for f in film]


@pytest.fixture(scope="module")
def labels(film: list[MovingFrame]) -> list[Labels]:
    return run(film)


def main_label(labels: Labels, truth: Labels, thing: int) -> int:
    return int(np.bincount(labels[truth == thing]).argmax())


def test_things_keep_their_identity_while_they_move_hide_and_enter(
    film: list[MovingFrame], labels: list[Labels]
) -> None:
    truth = [frame.truth for frame in film]
    switches = identity_switches(truth, labels, least=40)
    assert set(switches) == {0, 1, 2, 3, MOVING, ENTERING, HIDDEN}
    assert sum(switches.values()) == 0
    hidden = main_label(labels[0], truth[0], HIDDEN)
    assert main_label(labels[-1], truth[-1], HIDDEN) == hidden
    away = [i for i, t in enumerate(truth) if not (t == HIDDEN).any()]
    assert len(away) in (10, 11)
    assert not any((labels[i] == hidden).any() for i in away)
    entered = main_label(labels[-1], truth[-1], ENTERING)
    assert not (labels[0] == entered).any()


def test_each_frame_is_as_good_as_alone(film: list[MovingFrame], labels: list[Labels]) -> None:
    def voi(found: Labels, frame: MovingFrame) -> float:
        return variation_of_information(found + 1, frame.truth + 1).total

    some = range(2, len(film), 3)
    alone = [voi(segment(film[i].scene, preset="fast").labels, film[i]) for i in some]
    carried = [voi(labels[i], film[i]) for i in some]
    # Of pictures as small as these a few pixels decide; benchmarks/video.py has the real figures.
    assert np.mean(carried) < 1.1 * np.mean(alone)


def test_labels_depend_on_neither_threads_nor_chance_of_time(
    film: list[MovingFrame], labels: list[Labels]
) -> None:
    for threads in (1, 3):
        for one, other in zip(run(film[:14], threads=threads), labels, strict=False):
            np.testing.assert_array_equal(one, other)


def test_a_hidden_thing_is_forgotten_after_its_time(film: list[MovingFrame]) -> None:
    found = run(film, memory=4)
    first = main_label(found[0], film[0].truth, HIDDEN)
    assert main_label(found[-1], film[-1].truth, HIDDEN) != first


def test_a_new_thing_asks_for_a_new_model_in_the_background(film: list[MovingFrame]) -> None:
    with VideoSegmenter("fast", delay=3) as video:
        for frame in film[4:26]:
            video.update(frame.scene, frame.pose)
        assert video.models[0] == (0, "first")
        assert "new" in {why for _, why in video.models}


def test_another_shot_ends_all_identities(film: list[MovingFrame]) -> None:
    rng = np.random.default_rng(0)
    noise = rng.integers(0, 255, (6, 8, 3)).astype(np.uint8).repeat(16, 0).repeat(16, 1)
    other = Scene.from_rgbd(noise, np.full((96, 128), 7.0), film[0].scene.intrinsics)
    with VideoSegmenter("fast") as video:
        before = video.update(film[0].scene).labels
        after = video.update(other).labels
        assert video.models == [(0, "first"), (1, "cut")]
    assert not set(np.unique(before)) & set(np.unique(after))


def test_exposure_may_jump(film: list[MovingFrame]) -> None:
    scenes = [frame.scene for frame in film[:6]]
    brighter = (np.minimum(scene.colors * 1.35 + 8, 255).astype(np.uint8) for scene in scenes[3:])
    scenes[3:] = [replace(s, colors=c) for s, c in zip(scenes[3:], brighter, strict=True)]
    with VideoSegmenter("fast") as video:
        found = [video.update(scene).labels for scene in scenes]
        assert "cut" not in {why for _, why in video.models}
    truth = [frame.truth for frame in film[:6]]
    assert sum(identity_switches(truth, found, least=80).values()) == 0


def test_depth_may_be_lost_and_found_again(film: list[MovingFrame]) -> None:
    scenes = [frame.scene for frame in film[:6]]
    blind = [Scene.from_image(scene.colors) for scene in scenes[2:4]]
    with VideoSegmenter("fast") as video:
        found = [video.update(scene) for scene in [*scenes[:2], *blind, *scenes[4:]]]
    assert [seg.cues for seg in found] == ["fusion"] * 2 + ["color"] * 2 + ["fusion"] * 2
    assert found[2].quality is None
    ball = main_label(found[1].labels, film[1].truth, MOVING)
    assert main_label(found[3].labels, film[3].truth, MOVING) == ball
    assert main_label(found[5].labels, film[5].truth, MOVING) == ball


def test_depth_that_comes_later_makes_a_new_model(film: list[MovingFrame]) -> None:
    with VideoSegmenter("fast", delay=0) as video:
        for i in range(14):
            scene = film[i].scene
            seg = video.update(Scene.from_image(scene.colors) if i < 2 else scene)
        assert (10, "depth") in video.models
    assert seg.cues == "fusion"


def test_frames_may_change_their_size(film: list[MovingFrame]) -> None:
    small = [f.scene.take(np.arange(96 * 128).reshape(96, 128)[::2, ::2]) for f in film[2:4]]
    small = [replace(s, intrinsics=film[0].scene.intrinsics.scaled_to(64, 48)) for s in small]  # type: ignore[union-attr]
    with VideoSegmenter("fast") as video:
        found = [video.update(scene).labels for scene in [film[0].scene, film[1].scene, *small]]
    assert found[2].shape == (48, 64)
    truth = [film[0].truth, film[1].truth, film[2].truth[::2, ::2], film[3].truth[::2, ::2]]
    assert sum(identity_switches(truth, found, least=60).values()) == 0


def test_the_paper_s_k_and_lambda_are_carried_on(film: list[MovingFrame]) -> None:
    with VideoSegmenter("paper") as video:
        found = [video.update(frame.scene) for frame in film[:3]]
    first = segment(film[0].scene, preset="paper", fill=False)
    assert [seg.weight for seg in found] == [first.weight] * 3
    assert all(seg.k <= first.k for seg in found)
    assert found[0].detail is None


def test_a_run_is_gone_on_with(film: list[MovingFrame], labels: list[Labels]) -> None:
    with VideoSegmenter("fast") as video:
        for frame in film[:8]:
            last = video.update(frame.scene, frame.pose).labels
        tracks = video.tracker.tracks
    with VideoSegmenter("fast") as again:
        again.resume(film[7].scene, last, tracks, 7, film[7].pose)
        assert again.frame == 8
        found = [again.update(f.scene, f.pose).labels for f in film[8:]]
    truth = [frame.truth for frame in film]
    assert sum(identity_switches(truth, [*labels[:8], *found], least=40).values()) == 0
    with VideoSegmenter("paper") as paper, pytest.raises(GeohueError, match="only presets"):
        paper.resume(film[7].scene, last, tracks, 7)


def test_numbers_of_missing_frames_count(film: list[MovingFrame]) -> None:
    with VideoSegmenter("fast") as video:
        video.update(film[0].scene, frame=3)
        assert video.frame == 4
        video.update(film[1].scene, frame=9)
        assert {one.frame for one in video.seen} == {9}
        with pytest.raises(GeohueError, match="next one is 10"):
            video.update(film[2].scene, frame=9)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"memory": -1}, "memory"),
        ({"delay": 1.5}, "delay"),
        ({"preset": "slow"}, "preset"),
        ({"detail": "much"}, "detail"),
        ({"preset": "paper", "detail": 1.0}, "no levels"),
    ],
)
def test_settings_that_cannot_be(change: dict[str, object], message: str) -> None:
    with pytest.raises(GeohueError, match=message):
        VideoSegmenter(**change)  # type: ignore[arg-type]


def test_frames_that_cannot_be(film: list[MovingFrame]) -> None:
    with VideoSegmenter("fast") as video:
        with pytest.raises(GeohueError, match="grid"):
            video.update(Scene.from_cloud(np.eye(5, 3), np.zeros((5, 3))))
        for pose in (np.eye(3), np.full((4, 4), np.nan), np.zeros((4, 4))):
            with pytest.raises(GeohueError, match="pose"):
                video.update(film[0].scene, pose)


def test_contingency_leaves_out_tracks_without_a_column() -> None:
    parts, tracks = np.array([[0, 0, 1]], np.int32), np.array([[5, 9, 5]], np.int32)
    assert contingency(parts, tracks, 2, {5: 0}).tolist() == [[1.0], [1.0]]
    assert contingency(parts, tracks, 2, {}).shape == (2, 0)


def test_a_later_frame_may_be_far_beyond_the_first() -> None:
    rng = np.random.default_rng(0)
    rgb = rng.integers(0, 255, (12, 16, 3)).astype(np.uint8)
    with VideoSegmenter("fast", threads=1) as video:
        for scale in (1e-30, 1e30, 1.0):
            depth = rng.normal(1, 0.1, (12, 16)) * scale
            seg = video.update(Scene.from_rgbd(rgb, depth))
            assert (seg.labels >= 0).all()


def test_a_pose_that_blows_space_up_is_refused() -> None:
    pose = np.diag([1e150, 1e150, 1e150, 1])
    scene = Scene.from_rgbd(np.zeros((4, 4, 3), np.uint8), np.ones((4, 4)))
    with VideoSegmenter("fast") as video, pytest.raises(GeohueError, match="size of things"):
        video.update(scene, pose)
