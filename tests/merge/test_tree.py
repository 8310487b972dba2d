"""Laws of nested levels: the tree of merges and the levels of a scene."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geohue import GeohueError
from geohue.merge.levels import DETAILS, Levels, threshold_of
from geohue.merge.tree import MergeTree

law = settings(deadline=None, max_examples=60)


def random_tree(seed: int, n: int, left: int = 1) -> MergeTree:
    """Merges of n regions until `left` remain, with scores in any order and some ties."""
    rng = np.random.default_rng(seed)
    alive, merges = list(range(n)), []
    while len(alive) > left:
        kept, gone = rng.choice(alive, 2, replace=False).tolist()
        alive.remove(gone)
        merges.append((kept, gone))
    scores = rng.normal(size=len(merges)).round(1)
    return MergeTree(n, np.array(merges, np.int64).reshape(-1, 2), scores)


trees = st.builds(random_tree, st.integers(0, 2**20), st.integers(1, 12), st.integers(1, 3))


def nested(fine: np.ndarray[tuple[int, ...], np.dtype[np.int32]], coarse: object) -> bool:
    return len(np.unique(np.stack([fine, np.asarray(coarse)]), axis=1).T) == len(np.unique(fine))


class TestTree:
    @given(trees)
    @law
    def test_levels_are_nested_and_one_segment_apart(self, tree: MergeTree) -> None:
        before = tree.after(0)
        assert before.tolist() == list(range(tree.n_regions))
        for m in range(1, len(tree.merges) + 1):
            now = tree.after(m)
            assert nested(before, now)
            assert len(np.unique(now)) == tree.n_regions - m
            kept, gone = tree.merges[m - 1]
            assert now[kept] == now[gone]
            assert before[kept] != before[gone]
            first = np.unique(now, return_index=True)[1]
            assert (np.diff(first) > 0).all()  # in the order of their first regions
            assert now.max() == tree.n_regions - m - 1
            before = now

    @given(trees, st.floats(-3, 3))
    @law
    def test_at_takes_the_merges_before_the_first_above_the_threshold(
        self, tree: MergeTree, threshold: float
    ) -> None:
        count = 0
        while count < len(tree.scores) and tree.scores[count] < threshold:
            count += 1
        assert np.array_equal(tree.at(threshold), tree.after(count))

    def test_a_score_of_the_threshold_stays_apart(self) -> None:
        tree = MergeTree(3, np.array([[0, 1], [0, 2]]), np.array([-1.0, 0.0]))
        assert tree.at().tolist() == [0, 0, 1]
        assert tree.at(-1.0).tolist() == [0, 1, 2]
        assert tree.at(0.1).tolist() == [0, 0, 0]

    @given(trees, st.integers(1, 15))
    @law
    def test_with_segments(self, tree: MergeTree, k: int) -> None:
        fewest = tree.n_regions - len(tree.merges)
        found = len(np.unique(tree.with_segments(k)))
        assert found == min(max(k, fewest), tree.n_regions)

    @pytest.mark.parametrize("k", [0, -3])
    def test_no_segments(self, k: int) -> None:
        with pytest.raises(GeohueError, match=f"k is {k}: expected at least 1"):
            random_tree(0, 4).with_segments(k)

    @given(trees, st.integers(0, 2**20), st.floats(-3, 3))
    @law
    def test_among_some_regions(self, tree: MergeTree, seed: int, threshold: float) -> None:
        """Every level is that of the whole tree without the others."""
        kept = np.random.default_rng(seed).random(tree.n_regions) < 0.6
        part = tree.among(kept)
        assert part.n_regions == kept.sum()
        whole = tree.at(threshold)[kept]
        assert nested(whole, part.at(threshold))
        assert nested(part.at(threshold), whole)
        coarsest = tree.after(len(tree.merges))[kept]
        assert part.n_regions - len(part.merges) == len(np.unique(coarsest))
        assert np.array_equal(part.scores, np.sort(part.scores))

    def test_heights_rise(self) -> None:
        tree = MergeTree(4, np.array([[0, 1], [2, 3], [0, 2]]), np.array([1.0, -2.0, 3.0]))
        assert tree.heights.tolist() == [1, 1, 3]
        assert MergeTree(1, np.zeros((0, 2), np.int64), np.zeros(0)).heights.tolist() == []


class TestDetail:
    @pytest.mark.parametrize(
        ("detail", "threshold"),
        [("auto", 0), ("fine", -1.5), ("coarse", 1.5), (2, -2), (np.float32(-0.5), 0.5), (0, 0)],
    )
    def test_threshold(self, detail: float, threshold: float) -> None:
        assert threshold_of(detail) == threshold
        assert str(threshold_of(0)) == "0.0"  # not minus zero

    @pytest.mark.parametrize("detail", ["finest", True, None, np.nan, np.inf, [1]])
    def test_refused(self, detail: float) -> None:
        with pytest.raises(GeohueError, match=r"detail is .*: expected"):
            threshold_of(detail)


class TestLevels:
    @given(trees, st.integers(0, 2**20), st.floats(-3, 3), st.floats(0, 3))
    @law
    def test_finer_levels_are_nested(
        self, tree: MergeTree, seed: int, detail: float, more: float
    ) -> None:
        regions = np.random.default_rng(seed).integers(-1, tree.n_regions, (5, 6)).astype(np.int32)
        levels = Levels(regions, tree)
        coarse, fine = levels.at(detail), levels.at(detail + more)
        assert np.array_equal(coarse < 0, regions < 0)
        assert np.array_equal(fine < 0, regions < 0)
        assert nested(fine.ravel(), coarse.ravel())
        assert len(levels) == len(tree.merges) + 1
        sizes = np.bincount(coarse[coarse >= 0])
        assert (np.diff(sizes) <= 0).all()

    def test_names_and_segments(self) -> None:
        tree = MergeTree(3, np.array([[0, 2], [0, 1]]), np.array([-1.0, 1.0]))
        levels = Levels(np.array([0, 1, 1, 1, 2, -1], np.int32), tree)
        assert levels.at().tolist() == [1, 0, 0, 0, 1, -1]
        assert levels.at("fine").tolist() == [1, 0, 0, 0, 2, -1]
        assert levels.with_segments(1).tolist() == [0, 0, 0, 0, 0, -1]
        assert sorted(DETAILS) == ["auto", "coarse", "fine"]

    @given(trees)
    @law
    def test_border_strength_is_an_ultrametric(self, tree: MergeTree) -> None:
        strength = Levels(np.zeros(1, np.int32), tree).border_strength()
        n = tree.n_regions
        assert np.array_equal(strength, strength.T)
        assert (np.diag(strength) == -np.inf).all()
        for j in range(n):
            through = np.maximum(strength[:, [j]], strength[[j], :])
            assert (strength <= through).all()
        for threshold in (-1.0, -0.05, 0.0, 0.3, 9.0):
            together = strength < threshold
            labels = tree.at(threshold)
            assert np.array_equal(together, labels[:, None] == labels)

    def test_regions_that_never_merge(self) -> None:
        tree = MergeTree(3, np.array([[1, 2]]), np.array([0.5]))
        strength = Levels(np.zeros(1, np.int32), tree).border_strength()
        assert strength[0, 1] == strength[0, 2] == np.inf
        assert strength[1, 2] == 0.5
