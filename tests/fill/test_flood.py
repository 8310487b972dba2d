"""The watershed that stands for the Appendix in the preset fast."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import geohue
from geohue.errors import GeohueError
from geohue.features import lab_of
from geohue.fill import fill_labels
from geohue.fill.flood import flood_labels


def halves(height: int = 40, width: int = 60) -> tuple[np.ndarray, np.ndarray]:
    """A picture in two colours, and the label of each pixel."""
    labels = np.zeros((height, width), np.int32)
    labels[:, width // 2 :] = 1
    rgb = np.array([[200, 40, 30], [30, 60, 180]], np.uint8)[labels]
    return rgb, labels


@given(st.integers(0, 999), st.floats(0.05, 0.9))
@settings(max_examples=30, deadline=None)
def test_finds_the_border_of_two_colours(seed: int, share: float) -> None:
    rgb, labels = halves()
    rng = np.random.default_rng(seed)
    open_ = rng.random(labels.shape) < share
    open_[0, 0] = open_[0, -1] = False
    assert np.array_equal(flood_labels(np.where(open_, -1, labels), rgb), labels)


@given(st.integers(0, 999), st.floats(0.05, 0.99))
@settings(max_examples=30, deadline=None)
def test_keeps_what_is_known_and_leaves_no_gap(seed: int, share: float) -> None:
    rng = np.random.default_rng(seed)
    shape = tuple(rng.integers(1, 25, 2))
    labels = rng.integers(0, 4, shape).astype(np.int32)
    labels[rng.random(shape) < share] = -1
    rgb = rng.integers(0, 256, (*shape, 3)).astype(np.uint8)
    found = flood_labels(labels, rgb)
    assert np.array_equal(found[labels >= 0], labels[labels >= 0])
    expected = set(labels[labels >= 0].tolist()) or {-1}
    assert set(found.ravel().tolist()) == expected


def test_the_border_of_an_image_is_filled_like_its_middle() -> None:
    rgb, labels = halves()
    known = labels.copy()
    known[:, 25:35] = -1
    known[0] = known[-1] = -1
    assert np.array_equal(flood_labels(known, rgb), labels)


def test_permuting_labels_permutes_the_result() -> None:
    rng = np.random.default_rng(0)
    labels = rng.integers(0, 3, (30, 40)).astype(np.int32)
    labels[5:20, 5:30] = -1
    rgb = rng.integers(0, 256, (30, 40, 3)).astype(np.uint8)
    order = np.array([2, 0, 1, -1], np.int32)  # -1 stays
    assert (flood_labels(order[labels], rgb) == order[flood_labels(labels, rgb)]).mean() > 0.99


def test_agrees_with_the_appendix_on_a_real_frame(data_dir: Path) -> None:
    from geohue.read.scenes.scenes import read_scene

    frame = sorted((data_dir / "mosd" / "frames").iterdir())[0]
    scene = read_scene(frame / "rgb.png", frame / "depth.png", frame / "intrinsics.json")
    known = geohue.segment(scene, k=3, preset="fast", fill=False).labels
    slow, quick = fill_labels(known, lab_of(scene.colors)), flood_labels(known, scene.colors)
    assert (quick >= 0).all()
    assert (slow == quick)[known < 0].mean() > 0.9


@pytest.mark.parametrize(
    ("rgb", "message"),
    [(np.zeros((4, 4, 3)), "float64"), (np.zeros((4, 5, 3), np.uint8), "expected uint8")],
)
def test_refuses(rgb: Any, message: str) -> None:
    with pytest.raises(GeohueError, match=message):
        flood_labels(np.zeros((4, 4), np.int32), rgb)
