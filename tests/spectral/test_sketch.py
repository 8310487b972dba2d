from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from geohue.spectral.sketch import Sketch
from geohue.spectral.source import READ, Streamed
from geohue.spectral.width import neighbour_width

Array = NDArray[np.float64]


def drawn(x: Array, weights: Array, size: int, step: int, seed: int = 0) -> Sketch:
    sketch = Sketch(size, seed)
    for i in range(0, len(x), step):
        sketch.add(x[i : i + step], weights[i : i + step])
    return sketch


class TestSketch:
    @given(st.integers(0, 999), st.integers(1, 60), st.integers(1, 60))
    @settings(max_examples=40, deadline=None)
    def test_neither_order_nor_blocks_matter_and_weights_are_exact(
        self, seed: int, size: int, step: int
    ) -> None:
        rng = np.random.default_rng(seed)
        x = rng.integers(-3, 3, (90, 2)).astype(float)  # with repeated rows
        weights = rng.integers(0, 4, 90).astype(float)
        order = rng.permutation(90)
        one = drawn(x, weights, size, 90)
        other = drawn(x[order], weights[order], size, step)
        kept, mass = one.sample()
        assert np.array_equal(kept, other.sample()[0])
        assert np.array_equal(mass, other.sample()[1])
        distinct = np.unique(x[weights > 0], axis=0)
        assert len(kept) == min(size, len(distinct))
        assert one.whole == other.whole == (len(distinct) <= size)
        for vector, w in zip(kept, mass, strict=True):
            assert w == weights[(x == vector).all(axis=1)].sum()
        assert np.array_equal(kept, kept[np.lexsort(kept.T[::-1])])

    def test_every_vector_has_the_same_chance(self) -> None:
        x = np.arange(40.0)[:, None]
        counts = np.zeros(40)
        for seed in range(400):
            kept, _ = drawn(x, np.ones(40), 10, 40, seed).sample()
            counts[kept[:, 0].astype(int)] += 1
        # 100 +- 8.7 each: none of 40 is beyond five standard deviations.
        assert np.abs(counts - 100).max() < 45

    def test_both_zeros_are_one_number(self) -> None:
        kept, weights = drawn(np.array([[0.0], [-0.0]]), np.ones(2), 5, 1).sample()
        assert (kept.tolist(), weights.tolist()) == ([[0.0]], [2.0])


class TestWidth:
    def test_hand_worked_on_a_line(self) -> None:
        # 50 points apart by 1: 2 % is one, the least is the third neighbour. Within, the
        # third nearest is 2 away on both sides; at the ends it is 3.
        line = np.arange(50.0)[:, None]
        assert neighbour_width(line, np.ones(50), None) == pytest.approx(2)
        # 400 points: the eighth nearest of 400 (with itself), 7 others, is 4 away.
        line = np.arange(400.0)[:, None]
        assert neighbour_width(line, np.ones(400), None) == pytest.approx(4)
        # Twenty clusters: a quarter of 20 points are 5, 4 others: 2.
        assert neighbour_width(line, np.ones(400), 20) == pytest.approx(2)

    def test_counts_weights(self) -> None:
        x = np.arange(400.0)[:, None]
        doubled = neighbour_width(x, np.full(400, 2.0), None)
        assert doubled == neighbour_width(x, np.ones(400), None)
        near = np.ones(400)
        near[::2] = 7.0  # 2 % of 1600 is 32: reached by fewer, heavier points about the even ones
        assert neighbour_width(x, near, None) == pytest.approx(4)
        heavy = np.ones(400)
        heavy[200] = 1e6  # nearly all mass in one place: the distance to it
        assert neighbour_width(x, heavy, None) == pytest.approx(100, abs=2)

    def test_never_zero(self) -> None:
        assert neighbour_width(np.zeros((1, 3)), np.ones(1), 2) == 1.0
        x = np.append(np.arange(99) * 1e-12, 1.0)[:, None]
        assert neighbour_width(x, np.ones(100), 2) == pytest.approx(1e-6)


class TestStreamed:
    def test_reads_each_piece_once_in_order(self) -> None:
        class Counting:
            shape, dtype = (5 * READ // 2, 1), np.dtype(np.float32)
            reads: list[int] = []  # noqa: RUF012

            def __getitem__(self, rows: slice) -> NDArray[np.float32]:
                self.reads.append(rows.start)
                return np.arange(self.shape[0], dtype=np.float32)[rows][:, None]

        rows = Streamed(Counting(), READ)
        starts = range(0, len(rows), READ // 4)
        found = np.concatenate([rows[slice(i, i + READ // 4)] for i in starts])
        assert np.array_equal(found[:, 0], np.arange(len(rows)))
        assert Counting.reads == [0, READ, 2 * READ]
