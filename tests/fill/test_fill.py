"""The spreading of labels (Appendix) against its literal, slow twin, and its laws."""

from __future__ import annotations

from statistics import median
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.fill import fill_labels, state

Labels = NDArray[np.int32]
Lab = NDArray[np.float32]
Mask = NDArray[np.bool_]
Pixel = tuple[int, int]


# --- the slow twin -------------------------------------------------------------------------------


def neighbours(pixel: Pixel, shape: tuple[int, ...]) -> list[Pixel]:
    y, x = pixel
    near = [(y - 1, x), (y, x - 1), (y, x + 1), (y + 1, x)]
    return [(v, u) for v, u in near if 0 <= v < shape[0] and 0 <= u < shape[1]]


def pair_cost(labels: Labels, lab: Lab, pixel: Pixel, near: Pixel, window: int) -> float:
    """C(p_i, S^n): Gamma_L + Gamma_a + Gamma_b, absolute, in double precision."""
    y, x = near
    r = window // 2
    box = np.s_[max(0, y - r) : y + r + 1, max(0, x - r) : x + r + 1]
    segment = lab[box][labels[box] == labels[near]].astype(np.float64)
    here = lab[pixel].astype(np.float64)
    total = 0.0
    for channel in range(3):
        total += abs(float(here[channel]) - median(segment[:, channel].tolist()))
    return total


def slow_fill(
    labels: Labels, lab: Lab, window: int, mask: Mask | None = None
) -> tuple[Labels, list[Pixel], bool]:
    """Steps 1 to 5, every cost anew in every step; also the order and "two labels tied"."""
    labels = labels.copy()
    open_pixels = {
        (int(y), int(x)) for y, x in np.argwhere((labels < 0) & (True if mask is None else mask))
    }
    order: list[Pixel] = []
    tied = False
    while True:
        candidates = [
            (pair_cost(labels, lab, pixel, near, window), pixel, int(labels[near]))
            for pixel in open_pixels
            for near in neighbours(pixel, labels.shape)
            if labels[near] >= 0
        ]
        if not candidates:
            return labels, order, tied
        cost, pixel, label = min(candidates)
        tied |= any(c == cost and p == pixel and n != label for c, p, n in candidates)
        labels[pixel] = label
        open_pixels.remove(pixel)
        order.append(pixel)


# --- made scenes ---------------------------------------------------------------------------------


@st.composite
def scenes(draw: st.DrawFn) -> tuple[Labels, Lab, int, Mask | None]:
    shape = draw(hnp.array_shapes(min_dims=2, max_dims=2, min_side=1, max_side=7))
    labels = draw(hnp.arrays(np.int32, shape, elements=st.sampled_from([-1, -1, -1, 0, 1, 4])))
    whole = st.integers(0, 6).map(float)  # many ties
    real = st.floats(-100, 100, width=32)
    lab = draw(hnp.arrays(np.float32, (*shape, 3), elements=draw(st.sampled_from([whole, real]))))
    mask = draw(
        st.none() | hnp.arrays(np.bool_, shape, elements=st.sampled_from([True] * 3 + [False]))
    )
    return labels, lab, draw(st.sampled_from([1, 3, 7])), mask


def noise(seed: int, shape: tuple[int, int], share: float) -> tuple[Labels, Lab]:
    rng = np.random.default_rng(seed)
    labels = np.where(rng.random(shape) < share, rng.integers(0, 3, shape), -1)
    return labels.astype(np.int32), rng.normal(50, 20, (*shape, 3)).astype(np.float32)


def row(*lightness: float) -> Lab:
    lab = np.zeros((1, len(lightness), 3), dtype=np.float32)
    lab[0, :, 0] = lightness
    return lab


def fill_row(
    labels: list[int], lightness: list[float], window: int = 7, **options: Any
) -> list[int]:
    filled = fill_labels(np.array([labels], dtype=np.int32), row(*lightness), window, **options)
    return [int(v) for v in filled[0]]


# --- against the twin ----------------------------------------------------------------------------


@settings(max_examples=250, deadline=None)
@given(scenes())
def test_same_as_the_slow_twin(scene: tuple[Labels, Lab, int, Mask | None]) -> None:
    labels, lab, window, mask = scene
    expected, _, _ = slow_fill(labels, lab, window, mask)
    np.testing.assert_array_equal(fill_labels(labels, lab, window, mask), expected)


@pytest.mark.parametrize(("window", "share"), [(1, 0.1), (3, 0.02), (5, 0.3), (7, 0.05), (99, 0.1)])
def test_same_as_the_slow_twin_on_noise(window: int, share: float) -> None:
    labels, lab = noise(window, (13, 16), share)
    expected, _, _ = slow_fill(labels, lab, window)
    np.testing.assert_array_equal(fill_labels(labels, lab, window), expected)


@pytest.mark.parametrize("window", [3, 7])
def test_same_as_the_slow_twin_when_the_pool_of_windows_grows(
    window: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two seeds among many holes: the border outgrows the slots it starts with."""
    sizes: list[int] = []

    def grown(windows: Any) -> Any:
        larger = grow(windows)
        sizes.append(larger.length.size)
        return larger

    grow = state.grown
    monkeypatch.setattr(state, "grown", grown)
    rng = np.random.default_rng(3)
    labels = np.full((40, 41), -1, dtype=np.int32)
    labels[20, 20] = 2
    labels[0, 0] = 1
    mask = rng.random(labels.shape) < 0.7
    lab = rng.integers(0, 3, (*labels.shape, 3)).astype(np.float32)
    filled = fill_labels(labels, lab, window, mask)
    assert np.count_nonzero(filled >= 0) > 600
    assert sizes
    if window == 3:
        np.testing.assert_array_equal(filled, slow_fill(labels, lab, window, mask)[0])


def test_windows_behind_the_border_are_used_again(monkeypatch: pytest.MonkeyPatch) -> None:
    def grown(_: Any) -> Any:
        raise AssertionError("a border of 8 pixels has room in the first pool")

    monkeypatch.setattr(state, "grown", grown)
    labels = np.full((200, 8), -1, np.int32)
    labels[0] = 3
    assert (fill_labels(labels, np.zeros((200, 8, 3), np.float32)) == 3).all()


# --- by hand -------------------------------------------------------------------------------------


def test_row_between_two_segments() -> None:
    # Costs 2 (pixel 1 from 0) and 2 (pixel 3 from 1) tie: pixel 1 first, then 3, then 2, which is
    # |60 - median(10, 12)| = 49 from segment 0 and |60 - median(88, 90)| = 29 from segment 1.
    assert fill_row([0, -1, -1, -1, 1], [10, 12, 60, 88, 90]) == [0, 0, 1, 1, 1]


def test_medians_count_the_pixels_filled_on_the_way() -> None:
    # Pixel 1 costs 4 and is filled first. Pixel 2 (14) is then 14 - median(0, 4) = 12 from
    # segment 0 and 13 from segment 1; without pixel 1 in the median it would be 14 from segment 0.
    assert fill_row([0, -1, -1, 1], [0, 4, 14, 27]) == [0, 0, 0, 1]


def test_window_of_one_looks_at_the_neighbour_only() -> None:
    # |30 - 40| = 10 from pixel 3 and |30 - 22| = 8 from pixel 1. With both pixels of segment 0 in
    # the window it is |30 - median(0, 22)| = 19 from pixel 1.
    assert fill_row([0, 0, -1, 1], [0, 22, 30, 40], window=1) == [0, 0, 0, 1]
    assert fill_row([0, 0, -1, 1], [0, 22, 30, 40], window=3) == [0, 0, 1, 1]


def test_window_is_clipped_and_centred_on_the_neighbour() -> None:
    # Of segment 0, window 3 around pixel 2 holds (50, 0), at |30 - 25| = 5 from pixel 3, and
    # window 5 holds (50, 50, 0), at |30 - 50| = 20. Segment 1 is at |30 - 49| = 19.
    labels, lightness = [0, 0, 0, -1, 1], [50.0, 50.0, 0.0, 30.0, 49.0]
    assert fill_row(labels, lightness, window=3) == [0, 0, 0, 0, 1]
    assert fill_row(labels, lightness, window=5) == [0, 0, 0, 1, 1]


def test_equal_costs_go_to_the_first_pixel_then_to_the_lowest_label() -> None:
    assert fill_row([5, -1, 2], [10, 10, 10]) == [5, 2, 2]
    # Pixels 1 and 2 both cost 0; pixel 1 comes first and can only be 5. Then pixel 2 costs 0 from
    # both sides, and 2 is the lower label.
    assert fill_row([5, -1, -1, 2], [10, 10, 10, 10]) == [5, 5, 2, 2]


def test_costs_are_absolute() -> None:
    # 50 darker than segment 0, 10 brighter than segment 1: with their signs -50 would win.
    assert fill_row([0, -1, 1], [60, 10, 0]) == [0, 1, 1]


def test_nothing_to_fill_and_nothing_labelled() -> None:
    lab = np.zeros((2, 3, 3), dtype=np.float32)
    full = np.arange(6, dtype=np.int32).reshape(2, 3)
    filled = fill_labels(full, lab)
    np.testing.assert_array_equal(filled, full)
    assert filled is not full
    assert not np.shares_memory(filled, full)
    none = np.full((2, 3), -1, dtype=np.int32)
    np.testing.assert_array_equal(fill_labels(none, lab), none)


@pytest.mark.parametrize("label", [-1, 3])
def test_single_pixel(label: int) -> None:
    assert fill_row([label], [10]) == [label]


def test_empty_image() -> None:
    empty = np.empty((0, 4), dtype=np.int32)
    assert fill_labels(empty, np.empty((0, 4, 3), dtype=np.float32)).shape == (0, 4)


def test_isolated_part_stays_unlabelled() -> None:
    # Pixel 4 is outside the mask, and parts the last two from every label.
    mask = np.array([[True, True, True, True, False, True, True]])
    assert fill_row([0, -1, -1, 1, -1, -1, -1], [1] * 7, mask=mask) == [0, 0, 0, 1, -1, -1, -1]


def test_mask_blocks_but_keeps_the_labels_outside() -> None:
    mask = np.array([[False, True, False, True]])
    assert fill_row([7, -1, -1, -1], [1, 2, 3, 4], mask=mask) == [7, 7, -1, -1]


# --- laws ----------------------------------------------------------------------------------------


@settings(max_examples=60, deadline=None)
@given(scenes())
def test_fills_exactly_what_labels_reach(scene: tuple[Labels, Lab, int, Mask | None]) -> None:
    labels, lab, window, mask = scene
    before = labels.copy()
    filled = fill_labels(labels, lab, window, mask)
    np.testing.assert_array_equal(labels, before)
    np.testing.assert_array_equal(filled[labels >= 0], labels[labels >= 0])
    assert filled.dtype == np.int32
    for pixel in np.ndindex(*labels.shape):
        if filled[pixel] < 0 and (mask is None or mask[pixel]):
            assert all(filled[near] < 0 for near in neighbours(pixel, labels.shape))
        if mask is not None and not mask[pixel]:
            assert filled[pixel] == labels[pixel]


@settings(max_examples=60, deadline=None)
@given(scenes(), st.permutations([0, 1, 2, 3, 4]))
def test_permuting_labels_permutes_the_result(
    scene: tuple[Labels, Lab, int, Mask | None], permutation: list[int]
) -> None:
    labels, lab, window, mask = scene
    expected, _, tied = slow_fill(labels, lab, window, mask)
    if tied:  # the lowest label wins ties, and which is lowest changes
        return
    new = np.array([*permutation, -1], dtype=np.int32)  # index -1 -> -1
    np.testing.assert_array_equal(fill_labels(new[labels], lab, window, mask), new[expected])


@pytest.mark.parametrize("seed", range(5))
def test_shifting_lab_changes_nothing(seed: int) -> None:
    labels, lab = noise(seed, (30, 40), 0.3)
    lab = np.round(lab)  # whole numbers: the shift itself does not round
    shift = np.array([-17, 40, 8], dtype=np.float32)
    np.testing.assert_array_equal(fill_labels(labels, lab), fill_labels(labels, lab + shift))


def test_same_with_any_memory_layout_and_integer_type() -> None:
    labels, lab = noise(0, (20, 30), 0.3)
    expected = fill_labels(labels, lab)
    turned = fill_labels(np.asfortranarray(labels).astype(np.int64), np.asfortranarray(lab))
    np.testing.assert_array_equal(turned, expected)
    wide = np.repeat(lab, 2, axis=1)[:, ::2]
    wide.flags.writeable = False
    np.testing.assert_array_equal(fill_labels(labels, wide), expected)


# --- refusals ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"labels": np.zeros((2, 3))}, "float64"),
        ({"labels": np.zeros(3, dtype=np.int32)}, "2 dimensions"),
        ({"labels": np.full((2, 3), -2)}, "from -2"),
        ({"lab": np.zeros((3, 2, 3), dtype=np.float32)}, r"expected \(2, 3, 3\)"),
        ({"lab": np.zeros((2, 3, 3), dtype=np.uint8)}, "8-bit"),
        ({"lab": np.full((2, 3, 3), np.nan, dtype=np.float32)}, "finite"),
        ({"window": 4}, "odd"),
        ({"window": 0}, "odd"),
        ({"window": -3}, "odd"),
        ({"window": 3.0}, "odd whole number"),
        ({"window": True}, "odd whole number"),
        ({"mask": np.ones((3, 2), dtype=np.bool_)}, "mask"),
        ({"mask": np.ones((2, 3), dtype=np.uint8)}, "mask: uint8"),
    ],
)
def test_refuses(change: dict[str, Any], message: str) -> None:
    arguments: dict[str, Any] = {
        "labels": np.zeros((2, 3), dtype=np.int32),
        "lab": np.zeros((2, 3, 3), dtype=np.float32),
    }
    with pytest.raises(GeohueError, match=message):
        fill_labels(**(arguments | change))
