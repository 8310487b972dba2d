"""The constants of a scene, and the over-segmentation that merging begins with."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geohue.merge.cues import NAMES
from geohue.merge.oversegment import oversegment
from geohue.merge.score import COLOR, FUSION, GEOMETRY, color_share, constants, weights_of
from merge.tables import random_evidence


class TestConstants:
    def test_order(self) -> None:
        for table in (FUSION, GEOMETRY, COLOR):
            assert set(table) <= {*NAMES, "bias"}
            weights = weights_of(table)
            assert weights.shape == (len(NAMES) + 1,)
            assert weights[-1] == table["bias"]
            for name, weight in zip(NAMES, weights, strict=False):
                assert weight == table.get(name, 0)

    def test_without_colour_it_is_geometry_exactly(self) -> None:
        gray = np.tile([53.0, 10, -20], (30, 1))
        share = color_share(gray, np.arange(30, dtype=np.int32) // 7)
        assert share == 0
        assert np.array_equal(constants(share, "fusion"), weights_of(GEOMETRY))
        assert np.array_equal(constants(share, "geometry"), weights_of(GEOMETRY))

    def test_mix_of_both(self) -> None:
        assert np.array_equal(constants(1.0, "fusion"), weights_of(FUSION))
        expected = 0.25 * weights_of(FUSION) + 0.75 * weights_of(GEOMETRY)
        np.testing.assert_allclose(constants(0.25, "fusion"), expected)

    @pytest.mark.parametrize("share", [0.0, 0.4, 1.0])
    def test_colour_alone(self, share: float) -> None:
        assert np.array_equal(constants(share, "color"), weights_of(COLOR))

    def test_all_cues_speak_against_merging_but_the_length_of_the_border(self) -> None:
        for table in (FUSION, GEOMETRY):
            assert {name for name, weight in table.items() if weight < 0} == {"length", "bias"}
        against = {name for name, weight in COLOR.items() if weight > 0}
        assert against == {"color_step", "texture", "whole_votes", "contrast", "smaller", "larger"}

    def test_no_cue_of_form_in_colour_and_none_of_colour_in_geometry(self) -> None:
        form = {"offset", "depth_step", "convexity", "one_plane", "gap", "region_convexity"}
        assert not form & set(COLOR)
        assert not {"color_step", "texture", "contrast"} & set(GEOMETRY)


class TestColorShare:
    @pytest.mark.parametrize(("spread", "share"), [(15, 0.5), (45, 0.9), (5, 0.1), (0, 0.0)])
    def test_by_hand(self, spread: float, share: float) -> None:
        """Two regions of equal size, at plus and minus the spread."""
        lab = np.array([[0.6, 0.8, 0]] * 2 + [[-0.6, -0.8, 0]] * 2) * spread + [50, 1, 2]
        assert color_share(lab, np.array([0, 0, 1, 1], np.int32)) == pytest.approx(share)

    def test_noise_within_regions_is_no_colour(self) -> None:
        noise = np.tile([[40.0, 0, 0], [-40, 0, 0]], (8, 1))
        assert color_share(noise, np.repeat(np.arange(4, dtype=np.int32), 4)) == 0

    @given(st.integers(0, 2**20))
    @settings(deadline=None, max_examples=20)
    def test_is_the_variance_that_regions_explain(self, seed: int) -> None:
        evidence, labels = random_evidence(seed, regions=4)
        within = sum(
            ((part - part.mean(axis=0)) ** 2).sum()
            for part in (evidence.lab[labels == i] for i in range(4))
        )
        variance = evidence.lab.var(axis=0).sum() - within / len(labels)
        found = color_share(evidence.lab, labels)
        assert found == pytest.approx(variance / (variance + 225))


@pytest.mark.parametrize(
    ("color", "gap", "share", "weight"),
    [
        (13, 0, 0, 13),
        (0, 2, 0, 3),
        (0, 90, 0, 30),  # 20 typical gaps at most
        (0, 0, 0.5, 20),
        (3, 8, 0.1, 13),
    ],
)
def test_weight_of_a_pair(color: float, gap: float, share: float, weight: float) -> None:
    """Two points become one region as long as their weight is at most k."""
    evidence, _ = random_evidence(0, regions=1, size=1)
    pair = replace(
        evidence,
        one=np.array([0]),
        other=np.array([1]),
        gap=np.array([gap], float),
        share=np.array([share]),
    )
    lab = np.array([[0.0, 0, 0], [0.6 * color, 0, 0.8 * color]])
    assert oversegment(pair, lab, weight * 1.001, 1).tolist() == [0, 0]
    assert oversegment(pair, lab, weight * 0.999, 1).tolist() == [0, 1]


def test_small_regions_join_their_neighbours() -> None:
    evidence, _ = random_evidence(0, regions=1, size=1)
    n = 40
    chain = replace(
        evidence,
        one=np.arange(n - 1),
        other=np.arange(1, n),
        gap=np.zeros(n - 1),
        share=np.zeros(n - 1),
    )
    lab = np.zeros((n, 3))
    lab[12:] = 90
    assert oversegment(chain, lab).tolist() == [0] * 12 + [1] * 28
    assert oversegment(chain, np.roll(lab, -1, axis=0)).tolist() == [0] * n  # 11 and 28 and 1
