"""Connected pieces and the removal of small ones (Sec. III) against slow twins, and their laws."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from numpy.typing import NDArray

from geohue.compute.labels import check_labels, relabel
from geohue.errors import GeohueError
from geohue.regions.adjacency import adjacent_pixels
from geohue.regions.groups import connected_groups, merge_small_groups
from geohue.regions.images import connected_components, merge_small_regions

Labels = NDArray[np.int32]
Pixel = tuple[int, int]
Piece = set[Pixel]


# --- the slow twins ------------------------------------------------------------------------------


def slow_pieces(labels: Labels, connectivity: int = 4) -> list[Piece]:
    steps = [(-1, 0), (0, -1), (0, 1), (1, 0)]
    if connectivity == 8:
        steps += [(-1, -1), (-1, 1), (1, -1), (1, 1)]
    pieces: list[Piece] = []
    seen: Piece = set()
    for start in np.ndindex(*labels.shape):
        if labels[start] < 0 or start in seen:
            continue
        piece, todo = {(start[0], start[1])}, [start]
        while todo:
            y, x = todo.pop()
            for dy, dx in steps:
                near = (y + dy, x + dx)
                inside = 0 <= near[0] < labels.shape[0] and 0 <= near[1] < labels.shape[1]
                if inside and labels[near] == labels[start] and near not in piece:
                    piece.add(near)
                    todo.append(near)
        seen |= piece
        pieces.append(piece)
    return pieces


def vote(labels: Labels, piece: Piece, kept: Piece) -> tuple[int, bool]:
    """Return the mode over the pairs at the least distance, and whether it tied."""
    pairs = [((y - v) ** 2 + (x - u) ** 2, int(labels[v, u])) for y, x in piece for v, u in kept]
    least = min(pairs)[0]
    votes = Counter(label for distance, label in pairs if distance == least)
    most = max(votes.values())
    winners = sorted(label for label, count in votes.items() if count == most)
    return winners[0], len(winners) > 1


def touch(one: Piece, other: Piece) -> bool:
    return any(abs(y - v) + abs(x - u) == 1 for y, x in one for v, u in other)


def slow_merge(labels: Labels, min_size: int) -> tuple[Labels, bool]:
    """Merge round by round as the docstring has it; also whether a vote tied."""
    labels = labels.copy()
    pieces = slow_pieces(labels)
    kept: Piece = set().union(*(p for p in pieces if len(p) >= min_size))
    waiting = [p for p in pieces if len(p) < min_size]
    any_tied = False
    if not kept:
        return labels, False
    while waiting:
        # The last round is that of the islands, which touch nothing that is kept.
        now = [p for p in waiting if touch(p, kept)] or waiting
        choices = [vote(labels, piece, kept) for piece in now]
        for piece, (label, tied) in zip(now, choices, strict=True):
            any_tied |= tied
            for pixel in piece:
                labels[pixel] = label
        kept = kept.union(*now)
        waiting = [p for p in waiting if p not in now]
    return labels, any_tied


@st.composite
def label_images(draw: st.DrawFn) -> Labels:
    shape = draw(hnp.array_shapes(min_dims=2, max_dims=2, min_side=1, max_side=9))
    values = draw(st.sampled_from([[0, 0, 0, 1, 5], [-1, 0, 1, 5], [-1, -1, -1, 0, 0, 2]]))
    return draw(hnp.arrays(np.int32, shape, elements=st.sampled_from(values)))


def merged(rows: list[list[int]], min_size: int) -> list[list[int]]:
    result = merge_small_regions(np.array(rows, dtype=np.int32), min_size).tolist()
    return [[int(v) for v in line] for line in result]


# --- connected_components ------------------------------------------------------------------------


@settings(max_examples=150, deadline=None)
@given(label_images(), st.sampled_from([4, 8]))
def test_components_same_as_the_slow_twin(labels: Labels, connectivity: int) -> None:
    expected = np.full_like(labels, -1)
    for number, piece in enumerate(slow_pieces(labels, connectivity)):
        for pixel in piece:
            expected[pixel] = number
    found = connected_components(labels, connectivity)
    assert found.dtype == np.int32
    np.testing.assert_array_equal(found, expected)


def test_corners_connect_with_eight_only() -> None:
    corner = np.array([[1, 0], [0, 1]], dtype=np.int32)
    assert connected_components(corner, 4).tolist() == [[0, 1], [2, 3]]
    assert connected_components(corner, 8).tolist() == [[0, 1], [1, 0]]


@pytest.mark.parametrize("shape", [(0, 3), (3, 0)])
def test_components_of_nothing(shape: tuple[int, int]) -> None:
    assert connected_components(np.empty(shape, dtype=np.int32)).shape == shape


# --- merge_small_regions -------------------------------------------------------------------------


@settings(max_examples=300, deadline=None)
@given(label_images(), st.integers(0, 12))
def test_merge_same_as_the_slow_twin(labels: Labels, min_size: int) -> None:
    before = labels.copy()
    found = merge_small_regions(labels, min_size)
    np.testing.assert_array_equal(labels, before)
    assert found.dtype == np.int32
    assert not np.shares_memory(found, labels)
    np.testing.assert_array_equal(found, slow_merge(labels, min_size)[0])


@pytest.mark.parametrize("seed", range(4))
def test_merge_same_as_the_slow_twin_on_sparse_islands(seed: int) -> None:
    rng = np.random.default_rng(seed)
    labels = np.where(rng.random((20, 22)) < 0.12, rng.integers(0, 4, (20, 22)), -1)
    labels = labels.astype(np.int32)
    labels[:5, :4], labels[14:, 18:] = 2, 7
    np.testing.assert_array_equal(merge_small_regions(labels, 10), slow_merge(labels, 10)[0])


def test_the_longest_shared_border_wins() -> None:
    assert merged([[0, 3, 3], [0, 9, 3], [0, 3, 3]], 2)[1] == [0, 3, 3]  # one pair and three
    assert merged([[3, 0, 0], [3, 9, 0], [3, 3, 0]], 2)[1] == [3, 0, 0]  # two and two: the lowest
    # A pixel in a notch counts once for each side: 3 has one pixel and three pairs, 0 two and two.
    notch = [[9, 9, *[0] * 6], [9, *[3] * 7], [9, 9, *[0] * 6]]
    assert merged(notch, 6) == [[3, 3, *[0] * 6], [3] * 8, [3, 3, *[0] * 6]]


def test_pieces_within_small_pieces_wait() -> None:
    # The 8 touches only 9s, and each 9 touches 1s; when the 8's turn comes they are all 1.
    ring = [[1] * 5, [1, 1, 9, 1, 1], [1, 9, 8, 9, 1], [1, 1, 9, 1, 1], [1] * 5]
    assert merged(ring, 2) == [[1] * 5] * 5


def test_a_round_uses_the_labels_at_its_start() -> None:
    # 5 takes 0 and 6 takes 3. Had 6 seen the new label of 5, 0 and 3 would have tied for it.
    assert merged([[0, 0, 5, 6, 3, 3]], 2) == [[0, 0, 0, 3, 3, 3]]


def test_a_piece_of_a_kept_label_elsewhere_is_small_all_the_same() -> None:
    assert merged([[0, 0, 0, 1, 1, 1, 0]], 2) == [[0, 0, 0, 1, 1, 1, 1]]


def test_islands_take_the_nearest_label() -> None:
    assert merged([[0, 0, -1, -1, 9, -1, 3, 3]], 2) == [[0, 0, -1, -1, 3, -1, 3, 3]]
    # At the same distance from both: two pixels of 3, one of 0.
    rows = [
        [0, 0, -1, -1, -1],
        [-1, -1, -1, 9, -1],
        [-1] * 5,
        [-1, -1, 3, -1, 3],
        [-1, -1, 3, 3, 3],
    ]
    assert merged(rows, 2)[1][3] == 3


def test_unlabelled_pixels_stay_and_part_pieces() -> None:
    assert merged([[0, -1, 0, 0], [-1, -1, 0, 0]], 2) == [[0, -1, 0, 0], [-1, -1, 0, 0]]


@pytest.mark.parametrize("min_size", [0, 1])
def test_the_lowest_thresholds_keep_everything(min_size: int) -> None:
    assert merged([[0, 1, 2], [-1, 1, 4]], min_size) == [[0, 1, 2], [-1, 1, 4]]


@pytest.mark.parametrize("rows", [[[0, 1], [1, 0]], [[-1, -1]], [[-1, 4]]])
def test_no_large_piece_no_change(rows: list[list[int]]) -> None:
    assert merged(rows, 3) == rows


def test_merge_of_nothing() -> None:
    assert merge_small_regions(np.empty((0, 3), dtype=np.int32), 5).shape == (0, 3)


@settings(max_examples=150, deadline=None)
@given(label_images(), st.integers(0, 12))
def test_a_second_merge_changes_nothing(labels: Labels, min_size: int) -> None:
    once = merge_small_regions(labels, min_size)
    np.testing.assert_array_equal(merge_small_regions(once, min_size), once)


@settings(max_examples=150, deadline=None)
@given(label_images(), st.integers(0, 12))
def test_only_islands_stay_small(labels: Labels, min_size: int) -> None:
    found = merge_small_regions(labels, min_size)
    np.testing.assert_array_equal(found < 0, labels < 0)
    large = [p for p in slow_pieces(labels) if len(p) >= min_size]
    if not large:
        np.testing.assert_array_equal(found, labels)
        return
    for piece in large:
        assert all(found[pixel] == labels[pixel] for pixel in piece)
    # What the labelled pixels connect, whatever their labels:
    for region in slow_pieces(np.where(labels < 0, -1, 0).astype(np.int32)):
        if any(piece <= region for piece in large):
            inside = np.full_like(found, -1)
            for pixel in region:
                inside[pixel] = found[pixel]
            assert all(len(piece) >= min_size for piece in slow_pieces(inside))


@settings(max_examples=150, deadline=None)
@given(label_images(), st.integers(0, 12), st.permutations(range(6)))
def test_permuting_labels_permutes_the_merge(
    labels: Labels, min_size: int, permutation: list[int]
) -> None:
    expected, tied = slow_merge(labels, min_size)
    if tied:  # the lowest label wins ties, and which is lowest changes
        permutation = sorted(permutation)
        new = np.array([*(3 * p + 1 for p in permutation), -1], dtype=np.int32)
    else:
        new = np.array([*permutation, -1], dtype=np.int32)  # index -1 -> -1
    np.testing.assert_array_equal(merge_small_regions(new[labels], min_size), new[expected])


@settings(max_examples=100, deadline=None)
@given(label_images(), st.integers(0, 12))
def test_pixels_as_points_give_the_same(labels: Labels, min_size: int) -> None:
    """The merge for clouds, given the pixels and their pairs; without gaps there are no islands."""
    whole = labels - labels.min(initial=0)
    one, other = adjacent_pixels(whole.shape)
    points = np.zeros((whole.size, 3), np.float32)
    flat = whole.reshape(-1)
    groups = connected_groups(flat, one, other)
    assert np.array_equal(groups, connected_components(whole).reshape(-1))
    found = merge_small_groups(flat, one, other, points, min_size)
    assert np.array_equal(found, merge_small_regions(whole, min_size).reshape(-1))


def test_groups_without_neighbours_take_the_nearest_label() -> None:
    x = np.array([0, 1, 2, 9, 10, 11, 20], np.float32)
    points = np.stack([x, 0 * x, 0 * x], axis=1)
    labels = np.array([0, 0, 0, 1, 1, 1, 2], np.int32)
    one, other = np.array([0, 1, 3, 4]), np.array([1, 2, 4, 5])
    assert merge_small_groups(labels, one, other, points, 2).tolist() == [0, 0, 0, 1, 1, 1, 1]
    labels[3:6] = -1
    points[3:6] = np.nan
    pairs = one[:2], other[:2]
    assert merge_small_groups(labels, *pairs, points, 2).tolist() == [0, 0, 0, -1, -1, -1, 0]


# --- relabel -------------------------------------------------------------------------------------


@settings(max_examples=100, deadline=None)
@given(label_images())
def test_relabel_laws(labels: Labels) -> None:
    new, mapping = relabel(labels)
    assert new.dtype == np.int32
    assert mapping.dtype == np.int32
    np.testing.assert_array_equal(new < 0, labels < 0)
    np.testing.assert_array_equal(mapping[new[new >= 0]], labels[labels >= 0])
    sizes = np.bincount(new[new >= 0], minlength=mapping.size)
    first = [int(np.flatnonzero(new.ravel() == k)[0]) for k in range(mapping.size)]
    ranks = [(-int(size), start) for size, start in zip(sizes, first, strict=True)]
    assert ranks == sorted(ranks)
    again, identity = relabel(new)
    np.testing.assert_array_equal(again, new)
    assert identity.tolist() == list(range(mapping.size))


def test_relabel_by_size_then_first_pixel() -> None:
    new, mapping = relabel(np.array([9, 4, 4, -1, 2, 7, 7], dtype=np.int32))
    assert new.tolist() == [2, 0, 0, -1, 3, 1, 1]
    assert mapping.tolist() == [4, 7, 9, 2]


@pytest.mark.parametrize("labels", [[], [-1, -1]])
def test_relabel_without_labels(labels: list[int]) -> None:
    new, mapping = relabel(np.array(labels, dtype=np.int32))
    assert new.tolist() == labels
    assert mapping.shape == (0,)


# --- refusals ------------------------------------------------------------------------------------


@pytest.mark.parametrize("labels", [np.zeros((2, 2)), np.zeros((2, 2), dtype=np.bool_)])
def test_refuses_labels_that_are_not_whole_numbers(labels: NDArray[Any]) -> None:
    for call in (
        lambda: connected_components(labels),
        lambda: merge_small_regions(labels, 2),
        lambda: relabel(labels),
    ):
        with pytest.raises(GeohueError, match="whole numbers"):
            call()


def test_refuses_wrong_shapes_and_values() -> None:
    with pytest.raises(GeohueError, match=r"shape \(4,\)"):
        connected_components(np.zeros(4, dtype=np.int32))
    with pytest.raises(GeohueError, match="2 dimensions"):
        merge_small_regions(np.zeros((2, 2, 2), dtype=np.int32), 2)
    with pytest.raises(GeohueError, match="from -3 to 1"):
        relabel(np.array([-3, 1]))
    with pytest.raises(GeohueError, match="from 0 to 4294967296"):
        check_labels(np.array([0, 2**32]))
    with pytest.raises(GeohueError, match="connectivity: 6"):
        connected_components(np.zeros((2, 2), dtype=np.int32), 6)


@pytest.mark.parametrize("min_size", [-1, 2.0, True, "9"])
def test_refuses_min_size(min_size: Any) -> None:
    with pytest.raises(GeohueError, match="min_size"):
        merge_small_regions(np.zeros((2, 2), dtype=np.int32), min_size)
