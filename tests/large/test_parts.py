"""Moments, sample, normalisation, memory: the parts of a run over a large cloud."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geohue import GeohueError, Scene
from geohue.features import CUES, extract_features
from geohue.large.arrays import from_arrays, to_arrays
from geohue.large.memory import PARENT, WORKER, parse_memory, processes_within
from geohue.large.moments import Moments, merge
from geohue.large.sample import sample_positions
from geohue.large.vectors import Standard, raw_values
from large.clouds import three_blobs


@given(st.integers(0, 2**32), st.lists(st.integers(0, 200), max_size=6), st.floats(-1e7, 1e7))
def test_moments_of_parts_are_those_of_the_whole(seed: int, cuts: list[int], place: float) -> None:
    values = np.random.default_rng(seed).normal(place, 2.0, (200, 3))
    edges = [0, *sorted(cuts), 200]
    merged = merge(Moments.of(values[a:b]) for a, b in pairwise(edges))
    assert merged.count == 200
    np.testing.assert_allclose(merged.mean, values.mean(axis=0), rtol=1e-14, atol=1e-12)
    # Rounding of the coordinates themselves: 1e-9 of metres so far from zero.
    np.testing.assert_allclose(merged.deviation, values.std(axis=0), rtol=1e-8)
    np.testing.assert_array_equal(merged.low, values.min(axis=0))
    np.testing.assert_array_equal(merged.high, values.max(axis=0))


def test_moments_read_back_to_the_last_digit() -> None:
    moments = Moments.of(np.random.default_rng(0).normal(1e6, 1, (50, 6)))
    text = " ".join(repr(float(number)) for number in moments.numbers())
    back = Moments.from_numbers(map(float, text.split()))
    assert back.numbers() == moments.numbers()


def test_moments_of_nothing() -> None:
    nothing = Moments.of(np.empty((0, 2)))
    one = Moments.of(np.array([[1.0, 2.0]]))
    assert merge([nothing, one, nothing]).numbers() == one.numbers()


@given(st.integers(1, 10**12), st.integers(1, 300), st.integers(0, 100))
def test_sample_is_sorted_and_without_repeats(n_points: int, size: int, seed: int) -> None:
    rows = sample_positions(n_points, size, seed)
    assert len(rows) == min(n_points, size)
    assert (np.diff(rows) > 0).all()
    assert rows[0] >= 0
    assert rows[-1] < n_points
    np.testing.assert_array_equal(rows, sample_positions(n_points, size, seed))


def test_every_point_is_as_likely_in_the_sample() -> None:
    times = np.zeros(40)
    for seed in range(2000):
        times[sample_positions(40, 10, seed)] += 1
    # Binomial with mean 500 and deviation 19: five of these.
    assert np.abs(times - 500).max() < 97


@pytest.mark.parametrize("cues", CUES)
def test_normalised_like_a_whole_scene(cues: str) -> None:
    xyz, rgb, _ = three_blobs(3000)
    xyz[7] = np.nan
    whole = extract_features(Scene.from_cloud(xyz, rgb), cues)
    known, values = raw_values(xyz.astype(np.float64), rgb, cues)
    moments = merge(Moments.of(part) for part in np.array_split(values, 7))
    part = Standard.of(moments, cues).features(values, known)
    np.testing.assert_allclose(part.color, whole.color, atol=1e-6)
    np.testing.assert_allclose(part.geometry, whole.geometry, atol=1e-6)
    np.testing.assert_array_equal(part.index, whole.index)


def test_map_coordinates_normalise_like_those_near_zero() -> None:
    xyz, rgb, _ = three_blobs(3000)
    place = np.array([870_000.0, 8_500_000.0, 3_300.0])
    near, far = (
        Standard.of(Moments.of(values), "fusion").features(values, known).geometry
        for known, values in (
            raw_values(xyz + shift, rgb, "fusion") for shift in (np.zeros(3), place)
        )
    )
    np.testing.assert_allclose(far, near, atol=1e-6)


@pytest.mark.parametrize("place", [0.0, 8.5e6])
def test_a_cue_that_does_not_vary_is_zero_and_told(place: float) -> None:
    xyz = np.full((50, 3), place)
    _, rgb, _ = three_blobs(50)
    known, values = raw_values(xyz, rgb, "fusion")
    features = Standard.of(Moments.of(values), "fusion").features(values, known)
    assert not features.geometry.any()
    assert features.color.any()
    assert features.notes == ("all points lie in one place: geometry says nothing here",)


def test_a_dataclass_reads_back_from_its_arrays() -> None:
    standard = Standard(np.arange(6.0), np.ones(2), "geometry")
    back = from_arrays(Standard, to_arrays(standard))
    np.testing.assert_array_equal(back.mean, standard.mean)
    assert back.cues == "geometry"


@pytest.mark.parametrize(
    ("text", "n_bytes"),
    [("2GB", 2 * 10**9), ("500mb", 5 * 10**8), ("1.5GiB", 1610612736), ("7", 7), (9, 9)],
)
def test_amounts_of_memory(text: str | int, n_bytes: int) -> None:
    assert parse_memory(text) == n_bytes


@pytest.mark.parametrize("text", ["", "GB", "-2GB", "2 XB", "1e9", "2GBB"])
def test_what_is_no_amount_of_memory(text: str) -> None:
    with pytest.raises(GeohueError, match="2GB, 500MB"):
        parse_memory(text)


@given(st.integers(PARENT, 10**11), st.integers(1, 64))
def test_processes_fit_in_the_memory(memory: int, wanted: int) -> None:
    count = processes_within(memory, wanted)
    assert 1 <= count <= wanted
    assert PARENT + (count * WORKER if count > 1 else 0) <= memory


def test_too_little_memory_says_the_least() -> None:
    with pytest.raises(GeohueError, match=f"at least {PARENT // 10**6}MB"):
        processes_within(PARENT - 1, 1)
