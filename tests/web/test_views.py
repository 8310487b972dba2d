"""What the page is told of regions, borders and points."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import geohue
from geohue import GeohueError, Scene
from geohue.merge.levels import Levels
from geohue.merge.shares import border_shares
from geohue.merge.tree import MergeTree
from geohue.segmentation.result import Segmentation
from geohue.web.intake import check_roles, kept_name
from geohue.web.points import pack_points
from geohue.web.report import report
from geohue.web.taken import taken
from geohue.web.views import describe_borders, describe_regions, start_of
from geohue.web.wishes import Wishes, read_wishes


@pytest.fixture(scope="module")
def small() -> Scene:
    """Two halves of two rows, red and blue, one metre apart."""
    rgb = np.zeros((2, 4, 3), np.uint8)
    rgb[:, :2, 0], rgb[:, 2:, 2] = 200, 100
    depth = np.array([[1.0, 1, 2, 2], [1, np.nan, 2, 2]])
    return Scene.from_rgbd(rgb, depth, geohue.Intrinsics(1, 1, 0, 0))


def test_regions_by_hand(small: Scene) -> None:
    facts = describe_regions(small, np.array([[0, 0, 1, 1], [0, 0, 1, -1]], np.int32), 3)
    assert facts["size"] == [4, 3, 0]
    assert facts["color"] == [[200, 0, 0], [0, 0, 100], [0, 0, 0]]
    assert facts["low"] == [[0, 0, 1], [4, 0, 2], None]
    assert facts["high"] == [[1, 1, 1], [6, 2, 2], None]


def test_borders_by_hand(small: Scene) -> None:
    regions = np.array([[0, 0, 1, 1], [0, 0, 1, -1]], np.int32)
    shares = border_shares(
        np.array([0, 1], np.int32),
        [np.array([0, 1], np.int32), np.array([0, 0], np.int32)],
        *_one_pair(),
    )
    seg = _segmentation(regions)
    object.__setattr__(seg, "shares", shares)
    found = describe_borders(small, seg, regions)
    assert found == {"pairs": [[0, 1]], "length": [2], "votes": [0.5]}


def _one_pair() -> tuple[np.ndarray, np.ndarray]:
    return np.array([0]), np.array([1])


def _segmentation(labels: np.ndarray, levels: Levels | None = None, **more: object) -> Segmentation:
    plain: Any = (1.0, None, [], "nncsc", "best", "fusion", 0, {"total": 0.0}, (), levels)
    return Segmentation(labels, int(labels.max()) + 1, *plain, **more)  # type: ignore[arg-type]


def test_every_border_of_a_real_run_that_the_draft_has_carries_its_votes(
    frame_scene: Scene, three_boxes: tuple[Scene, np.ndarray]
) -> None:
    seg = geohue.segment(frame_scene)
    assert seg.levels is not None
    assert seg.shares is not None
    assert (seg.shares.pairs[:, 0] < seg.shares.pairs[:, 1]).all()
    assert seg.shares.pairs.max() < seg.levels.tree.n_regions
    found = describe_borders(frame_scene, seg, seg.levels.regions)
    known = [votes for votes in found["votes"] if votes is not None]
    assert len(known) > 0.8 * len(found["votes"])
    assert 0 <= min(known) < max(known) <= 1
    part = np.zeros(seg.levels.tree.n_regions, int)  # of the scene, for each region
    part[seg.levels.regions.ravel()] = three_boxes[1].ravel()
    parts = np.array([part[one] != part[other] for one, other in found["pairs"]])
    votes = np.array([np.nan if v is None else v for v in found["votes"]])
    assert np.nanmean(votes[parts]) > 2 * np.nanmean(votes[~parts])


@given(st.integers(2, 9), st.integers(0, 99))
@settings(max_examples=30, deadline=None)
def test_the_start_is_the_level_that_was_asked_for(n: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    merges = [[0, other] for other in rng.permutation(np.arange(1, n))]
    tree = MergeTree(n, np.array(merges), rng.normal(size=n - 1))
    levels = Levels(np.arange(n, dtype=np.int32), tree)
    for detail in ("auto", 0.7, "coarse"):
        seg = _segmentation(levels.at(detail), levels, detail=detail)
        assert len(set(tree.after(start_of(seg)).tolist())) == seg.k
    for k in range(1, n + 1):
        seg = _segmentation(levels.with_segments(k), levels)
        assert start_of(seg) == n - k


@pytest.mark.parametrize("most", [4, 100])
def test_points_are_packed_in_one_piece(small: Scene, most: int) -> None:
    regions = np.array([[0, 0, 1, 1], [0, 0, 1, -1]], np.int32)
    data, n = pack_points(small, regions, most)
    assert n == min(7, most)
    assert len(data) == 22 * n
    names = np.frombuffer(data, "<u2", n, 20 * n)
    colors = np.frombuffer(data, np.uint8, 4 * n, 12 * n).reshape(n, 4)
    red = names == 0
    assert (colors[red, 0] == 200).all()
    assert (colors[~red, 2] == 100).all()
    if most == 100:
        assert sorted(names.tolist()) == [0, 0, 0, 1, 1, 1, 65535]
        places = np.frombuffer(data, "<f4", 3 * n).reshape(n, 3)
        assert np.median(places, axis=0).tolist() == [0, 0, 0]
        assert (places[red, 2].min() > places[~red, 2]).all(), "the nearer half is in front"


def test_a_report_has_the_names_and_no_script(small: Scene) -> None:
    seg = _segmentation(np.array([[0, 0, 1, 1], [0, 0, 1, -1]], np.int32))
    text = report(taken(small, seg, None, {"1": "<script>"}))
    assert "&lt;script&gt;" in text
    assert "<script" not in text
    assert 'src="http' not in text
    assert "2 segments" in text


@given(st.text(max_size=20), st.sampled_from(["color", "depth", "cloud", "calib"]))
def test_a_kept_name_has_nothing_of_the_given_one_but_a_known_ending(
    given_: str, role: str
) -> None:
    for ending in (".png", ".ply", ".yml", given_):
        try:
            kept = kept_name(role, given_ + ending)
        except GeohueError:
            continue
        assert kept.split(".")[0] == role
        assert "/" not in kept
        assert "\\" not in kept
        assert kept.isascii()


@pytest.mark.parametrize(
    ("roles", "words"),
    [
        (("depth",), "one scene"),
        (("color", "cloud"), "one scene"),
        (("color", "right", "depth"), "leave out depth"),
        (("color", "disparity"), "give the right image too"),
        (("color", "intrinsics"), "give that too"),
        (("cloud", "depth"), "needs a color image"),
    ],
)
def test_files_that_do_not_go_together_are_refused(roles: tuple[str, ...], words: str) -> None:
    with pytest.raises(GeohueError, match=words):
        check_roles(dict.fromkeys(roles, "x"), "", False)


def test_wishes_have_the_library_s_defaults() -> None:
    assert read_wishes({}) == Wishes()
    assert read_wishes({"weight": 2, "k": 3, "seed": 5}).weight == 2


@given(
    st.dictionaries(
        st.sampled_from([*Wishes.__dataclass_fields__, "x"]),
        st.none() | st.booleans() | st.integers() | st.floats() | st.text() | st.just([{}]),
    )
)
def test_wishes_are_kept_as_they_are_or_refused(content: dict[str, object]) -> None:
    try:
        found = read_wishes(content)
    except GeohueError:
        return
    for name, value in content.items():
        assert getattr(found, name) == value
