"""Borders at full resolution against a slow twin, and what they must keep to."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from geohue.compute.parallel import workers
from geohue.merge.borders import draw_borders
from twins import merge as twin

Floats = NDArray[np.float32]
Labels = NDArray[np.int32]
Kept = NDArray[np.int64]


def drawn(
    regions: Labels, segments: Labels, kept: tuple[Kept, Kept], values: Floats, threads: int = 2
) -> Labels:
    with workers(threads) as team:
        return draw_borders(regions, segments, *kept, values, team)


def kept(shape: tuple[int, int], step: int) -> tuple[Kept, Kept]:
    rows, columns = (np.arange(min(step // 2, n - 1), n, step) for n in shape)
    return rows, columns


def scene(seed: int) -> tuple[Labels, Labels, tuple[Kept, Kept], Floats]:
    """Noise without structure, with gaps in the depth."""
    rng = np.random.default_rng(seed)
    shape = int(rng.integers(4, 20)), int(rng.integers(4, 20))
    places = kept(shape, int(rng.integers(1, 5)))
    values = rng.normal(0, [9, 5, 5, 0.05], (*shape, 4)).astype(np.float32)
    values[rng.random(shape) < 0.3, 3] = np.nan
    fine = rng.integers(0, 9, (len(places[0]), len(places[1]))).astype(np.int32)
    return fine, rng.integers(0, 4, 9).astype(np.int32), places, values


@given(st.integers(0, 2**20))
@settings(deadline=None, max_examples=25)
def test_against_the_twin(seed: int) -> None:
    regions, segments, places, values = scene(seed)
    if len(places[0]) == 1 == len(places[1]):
        return
    found = drawn(regions, segments, places, values)
    assert np.array_equal(found, twin.drawn(regions, segments, *places, values))


@given(st.integers(0, 2**20))
@settings(deadline=None, max_examples=25)
def test_labels_only_from_within_reach(seed: int) -> None:
    """One step around the nearest point of the draft, at any number of threads."""
    regions, segments, places, values = scene(seed)
    found = drawn(regions, segments, places, values, threads=1)
    assert np.array_equal(found, drawn(regions, segments, places, values, threads=8))
    near_y, near_x = (
        np.abs(np.arange(n)[:, None] - axis[::-1]).argmin(axis=1)
        for n, axis in zip(found.shape, places, strict=True)
    )
    near_y, near_x = len(places[0]) - 1 - near_y, len(places[1]) - 1 - near_x
    for y, x in np.ndindex(found.shape):
        top, left = max(near_y[y] - 1, 0), max(near_x[x] - 1, 0)
        assert found[y, x] in regions[top : near_y[y] + 2, left : near_x[x] + 2]


@given(st.integers(0, 2**20))
@settings(deadline=None, max_examples=25)
def test_regions_do_not_move_the_borders_of_segments(seed: int) -> None:
    regions, segments, places, values = scene(seed)
    four = np.arange(4, dtype=np.int32)
    whole = drawn(segments[regions], four, places, values)
    assert np.array_equal(segments[drawn(regions, segments, places, values)], whole)


@pytest.mark.parametrize("at", range(20, 29))
@pytest.mark.parametrize("cue", [0, 3])
@pytest.mark.parametrize("segments", [[0, 1], [0, 0]])
def test_a_step_is_found_at_its_pixel(at: int, cue: int, segments: list[int]) -> None:
    """Wherever between the points of the draft a step lies, between segments or within one."""
    values = np.zeros((33, 50, 4), np.float32)
    values[:, at:, cue] = (30, 0, 0, 0.3)[cue]
    places = kept((33, 50), 4)
    truth = (np.arange(50) >= at).astype(np.int32)[None].repeat(33, 0)
    regions = truth[places[0][:, None], places[1]]
    two = np.array(segments, np.int32)
    assert np.array_equal(drawn(regions, two, places, values), truth)
    upright = values.transpose(1, 0, 2).copy()
    found = drawn(regions.T.copy(), two, places[::-1], upright)
    assert np.array_equal(found, truth.T)


def test_regions_that_look_alike_are_divided_by_distance() -> None:
    places = kept((12, 12), 4)
    regions = np.arange(9, dtype=np.int32).reshape(3, 3)
    values = np.zeros((12, 12, 4), np.float32)
    found = drawn(regions, np.zeros(9, np.int32), places, values)
    assert np.array_equal(found, regions.repeat(4, 0).repeat(4, 1))


@pytest.mark.parametrize("shape", [(1, 9), (9, 1), (1, 1)])
def test_narrow_images(shape: tuple[int, int]) -> None:
    places = kept(shape, 3)
    line = np.arange(len(places[0]) * len(places[1]), dtype=np.int32)
    regions = line.reshape(len(places[0]), len(places[1]))
    values = np.zeros((*shape, 4), np.float32)
    found = drawn(regions, np.arange(9, dtype=np.int32), places, values)
    assert found.shape == shape
    assert np.array_equal(found[places[0][:, None], places[1]], regions)
