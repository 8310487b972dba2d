"""Who may vote: cuts, compared systems, and whatever gives label maps on the draft."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
import pytest
from numpy.typing import NDArray

from geohue import GeohueError, Preset, Scene, segment
from geohue.consensus import (
    CutVoter,
    find_consensus,
    known_voters,
    make_voters,
    register_voter,
    remove_voter,
)
from geohue.consensus.voters import BaselineVoter, Voter
from geohue.ncut.cutter import Cutter
from geohue.prepared import PreparedScene, prepare_scene
from likeness import adjusted_rand_score

Labels = NDArray[np.int32]
Case = tuple[Scene, Labels]
LIGHT = Preset().changed(draft_points=2000, landmarks=60, weight_rule="consensus")


class Nothing:
    """Sees one thing, several times."""

    weight = math.nan

    def __init__(self, votes: int) -> None:
        self.votes = votes

    def maps(self, prepared: PreparedScene) -> Sequence[Labels]:
        return [np.zeros(prepared.draft.shape, np.int32)] * self.votes


class Stripes:
    """Sees stripes, whatever is there."""

    weight = math.nan

    def __init__(self, votes: int = 1, count: int = 3) -> None:
        self.votes, self.count = votes, count

    def maps(self, prepared: PreparedScene) -> Sequence[Labels]:
        height, width = prepared.draft.shape
        stripe = (self.count * np.arange(width) // width).astype(np.int32)
        return [np.broadcast_to(stripe, (height, width))] * self.votes


@pytest.fixture
def halves() -> Iterator[str]:
    register_voter("halves", Stripes(count=2))
    yield "halves"
    remove_voter("halves")


def colors_of_stripes() -> Scene:
    """Three stripes that differ a little."""
    rng = np.random.default_rng(0)
    rgb = 120.0 + 4 * np.repeat([0, 1, 2], 20)[None, :, None] + rng.normal(0, 1, (40, 60, 3))
    return Scene.from_rgbd(rgb.astype(np.uint8), 2 + 0.001 * rng.random((40, 60)))


def test_a_voter_alone_is_followed_where_something_is_to_be_seen() -> None:
    grey = np.repeat(np.array([40, 120, 220], np.uint8), 20)
    rgb = np.broadcast_to(grey[None, :, None], (40, 60, 3))
    prepared = prepare_scene(Scene.from_rgbd(rgb, np.ones((40, 60))), LIGHT)
    found = find_consensus([Stripes()], prepared)
    assert found.labels.shape == (20, 30)
    assert found.labels.max() == 2
    assert all(np.ptp(found.labels[:, 10 * i : 10 * i + 10]) == 0 for i in range(3))
    assert math.isnan(found.weight)


def test_votes_are_counted_with_those_of_the_cuts() -> None:
    """A border of 3 maps in 3 + 9 has a quarter of the votes: it stays at 20 %, not at 30 %."""
    prepared = prepare_scene(colors_of_stripes(), LIGHT.changed(clear=0.0))

    def segments(least: float) -> int:
        settings = prepared.settings.changed(least=least)
        voters: list[Voter] = [Stripes(3), Nothing(9)]
        asked = PreparedScene.of(prepared.raw, prepared.features, settings)
        return int(find_consensus(voters, asked).labels.max()) + 1

    assert segments(0.20) == 3
    assert segments(0.30) == 1


@pytest.mark.parametrize(("others", "segments"), [(16, 3), (18, 1)])
def test_by_default_a_border_needs_15_percent_of_the_votes(others: int, segments: int) -> None:
    """3 maps in 3 + 16 are 15.8 %, in 3 + 18 they are 14.3 %."""
    prepared = prepare_scene(colors_of_stripes(), LIGHT.changed(clear=0.0))
    found = find_consensus([Stripes(3), Nothing(others)], prepared)
    assert int(found.labels.max()) + 1 == segments


def test_the_weight_is_that_of_the_voter_most_alike(three_boxes: Case) -> None:
    prepared = prepare_scene(three_boxes[0], LIGHT)
    cutter = Cutter(prepared, 10)
    found = find_consensus([Stripes(count=2), *make_voters(prepared, cutter)], prepared)
    assert found.weight in (0.0, 1.0, math.inf)


def test_a_registered_voter_takes_part_in_segment(three_boxes: Case, halves: str) -> None:
    scene, truth = three_boxes
    alone = segment(scene, preset=LIGHT.changed(voters=(halves,)))
    both = segment(scene, preset=LIGHT.changed(voters=(0.0, 1.0, math.inf, halves)))
    plain = segment(scene, preset=LIGHT)
    assert math.isnan(alone.weight)
    assert adjusted_rand_score(plain.labels.ravel(), truth.ravel()) > 0.99
    assert not np.array_equal(alone.labels, plain.labels)
    assert adjusted_rand_score(both.labels.ravel(), truth.ravel()) > 0.99
    assert "halves" in known_voters()


def test_a_compared_system_votes(three_boxes: Case) -> None:
    scene, truth = three_boxes
    found = segment(scene, preset=LIGHT.changed(voters=("kmeans",), k_max=4))
    assert found.weight == 1.0
    assert adjusted_rand_score(found.labels.ravel(), truth.ravel()) > 0.9
    prepared = prepare_scene(scene, LIGHT.changed(voters=("kmeans", "meanshift"), k_max=5))
    told, own = make_voters(prepared, Cutter(prepared, 5))
    assert isinstance(told, BaselineVoter)
    assert [int(labels.max()) + 1 for labels in told.maps(prepared)] == [2, 3, 4, 5]
    assert len(own.maps(prepared)) == 1


def test_a_weight_is_a_voter_with_a_cut_for_each_number(three_boxes: Case) -> None:
    prepared = prepare_scene(three_boxes[0], LIGHT.changed(k_max=4))
    (voter,) = make_voters(
        PreparedScene.of(prepared.raw, prepared.features, LIGHT.changed(k_max=4, voters=(1.0,))),
        Cutter(prepared, 4),
    )
    assert isinstance(voter, CutVoter)
    assert [int(labels.max()) + 1 for labels in voter.maps(prepared)] == [2, 3, 4]


def test_who_abstains_changes_nothing(three_boxes: Case) -> None:
    prepared = prepare_scene(three_boxes[0], LIGHT)
    voters = make_voters(prepared, Cutter(prepared, 10))
    one, two = (find_consensus(v, prepared) for v in (voters, [*voters, Stripes(0)]))
    assert np.array_equal(one.labels, two.labels)
    assert one.weight == two.weight
    nobody = find_consensus([Stripes(0)], prepared)
    assert nobody.labels.max() == 0
    assert nobody.weight == 1.0


def test_labels_of_another_shape_are_refused(three_boxes: Case) -> None:
    class Odd(Stripes):
        def maps(self, prepared: PreparedScene) -> Sequence[Labels]:  # noqa: ARG002
            return [np.zeros((2, 2), np.int32)]

    with pytest.raises(GeohueError, match=r"a voter \(Odd\) gave labels of shape \(2, 2\)"):
        find_consensus([Odd()], prepare_scene(three_boxes[0], LIGHT))


def test_unknown_names_are_refused(three_boxes: Case, halves: str) -> None:
    scene, _ = three_boxes
    with pytest.raises(GeohueError, match=f"voter 'oracle': .*kmeans.*{halves}"):
        segment(scene, preset=LIGHT.changed(voters=("oracle",)))
    with pytest.raises(GeohueError, match="not defined for colour and geometry together"):
        segment(scene, preset=LIGHT.changed(voters=("edison",)))
    for name in (halves, "kmeans", ""):
        with pytest.raises(GeohueError, match="the name is taken or empty"):
            register_voter(name, Stripes())


def test_a_system_for_images_does_not_vote_on_a_cloud(three_boxes: Case) -> None:
    scene, _ = three_boxes
    cloud = Scene.from_cloud(scene.points.reshape(-1, 3), scene.colors.reshape(-1, 3))
    with pytest.raises(GeohueError, match="needs a grid of pixels"):
        segment(cloud, weight="consensus", preset=LIGHT.changed(voters=("calderero-marques",)))
