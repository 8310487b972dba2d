"""A cue of one's own: one object, one registration, and it takes part everywhere."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from numpy.typing import NDArray

from geohue import GeohueError, Scene, segment
from geohue.features import (
    Cue,
    Features,
    Raw,
    check_cues,
    extract_features,
    known_cues,
    register_cue,
    remove_cue,
)
from geohue.ncut.cutter import Cutter
from geohue.prepared import prepare_scene
from geohue.settings import Preset
from geohue.studies.compare.cells import plan_cells
from likeness import adjusted_rand_score

LIGHT = Preset().changed(draft_points=2000, landmarks=60)


def wall() -> Scene:
    """A flat grey wall: nothing but noise to go by."""
    rng = np.random.default_rng(0)
    rgb = rng.normal(128, 6, (40, 60, 3)).astype(np.uint8)
    return Scene.from_rgbd(rgb, 2 + 0.01 * rng.random((40, 60)))


def mark(raw: Raw) -> NDArray[np.float32]:
    """What only this sensor sees: the middle is warm."""
    warm = np.zeros((*raw.scene.shape, 1), np.float32)
    warm[10:30, 20:40] = 37.0
    return warm


@pytest.fixture
def warmth() -> Iterator[Cue]:
    cue = register_cue(Cue("warmth", "color", mark, constant="all is equally warm"))
    yield cue
    remove_cue("warmth")


def test_the_cue_decides_where_nothing_else_does(warmth: Cue) -> None:
    scene = wall()
    strong = Cue("strong", warmth.side, warmth.values, share=4.0)
    register_cue(strong)
    try:
        found = segment(scene, 2, weight=1.0, cues="fusion+strong", preset=LIGHT)
    finally:
        remove_cue("strong")
    assert found.cues == "fusion+strong"
    middle = np.zeros((40, 60), np.int32)
    middle[10:30, 20:40] = 1
    assert np.array_equal(found.labels, middle)
    plain = segment(scene, 2, weight=1.0, preset=LIGHT).labels
    assert adjusted_rand_score(plain.ravel(), middle.ravel()) < 0.1


def test_the_draft_and_the_cut_have_its_columns(warmth: Cue) -> None:
    prepared = prepare_scene(wall(), LIGHT, "fusion+warmth")
    assert [block.name for block in prepared.features.blocks] == ["color", "warmth", "geometry"]
    assert prepared.draft_features.mixed(1.0).shape[1] == 7
    assert Cutter(prepared, 2).choose_k(1.0) >= 1
    assert warmth.name in known_cues()


@pytest.mark.parametrize("weight", [0.0, 0.5, 1.0, 3.0, np.inf])
@pytest.mark.parametrize("share", [0.5, 1.0, 2.0])
@pytest.mark.parametrize("side", ["color", "geometry"])
def test_the_spread_of_the_mix_is_the_same_for_every_weight(
    weight: float, share: float, side: str
) -> None:
    rng = np.random.default_rng(1)
    values = rng.normal(size=(30, 40, 2)).astype(np.float32)
    register_cue(Cue("noise", side, lambda _: values, share=share))  # type: ignore[arg-type]
    rgb = rng.integers(0, 255, (30, 40, 3)).astype(np.uint8)
    try:
        features = extract_features(
            Scene.from_rgbd(rgb, rng.uniform(1, 2, (30, 40))), "fusion+noise"
        )
    finally:
        remove_cue("noise")
    shares = {block.name: block.share for block in features.blocks}
    assert shares == {"color": 1.0, "geometry": 1.0, "noise": share}
    squares = {
        "color": 1.0 + (share**2 if side == "color" else 0),
        "geometry": 1.0 + (share**2 if side == "geometry" else 0),
    }
    if np.isfinite(weight):
        norm = np.sqrt(squares["color"] + weight**2 * squares["geometry"])
        expected = features.vectors(weight) / norm
        np.testing.assert_allclose(features.mixed(weight), expected, rtol=2e-6, atol=1e-6)
    else:
        used = features.mixed(weight)
        color = sum(b.values.shape[1] for b in features.blocks if b.side == "color")
        assert np.abs(used[:, :color]).max() < 1e-6
    one, other = features.mixed(weight)[:, :3], features.blocks[0].values
    angle = np.arctan(weight * np.sqrt(squares["geometry"] / squares["color"]))
    np.testing.assert_allclose(
        one, other * np.cos(angle) / np.sqrt(squares["color"]), rtol=1e-5, atol=1e-6
    )


def test_a_point_without_a_value_takes_part_without_the_cue() -> None:
    values = np.arange(12, dtype=np.float32).reshape(3, 4, 1)
    values[0, 0] = np.nan
    register_cue(Cue("patchy", "color", lambda _: values))
    try:
        rgb = np.random.default_rng(0).integers(0, 255, (3, 4, 3)).astype(np.uint8)
        features = extract_features(Scene.from_rgbd(rgb, np.ones((3, 4))), "color+patchy")
    finally:
        remove_cue("patchy")
    block = features.blocks[1].values[:, 0]
    assert len(features) == 12
    assert block[0] == 0
    known = values.reshape(-1)[1:]
    np.testing.assert_allclose(block[1:], (known - known.mean()) / known.std(), rtol=1e-5)


def test_a_cue_that_does_not_vary_is_told_of(warmth: Cue) -> None:
    scene = wall()
    left = scene.take(np.arange(scene.size).reshape(scene.shape)[:, :15])
    assert warmth.constant in extract_features(left, "fusion+warmth").notes
    constant = Cue("flat", "color", lambda raw: np.ones((*raw.scene.shape, 1), np.float32))
    block = constant.block(Raw(left), np.arange(left.size))
    assert block is not None
    assert block[1]
    assert not block[0].values.any()


def test_a_scene_that_lacks_it_goes_without() -> None:
    register_cue(Cue("absent", "geometry", lambda _: None))
    try:
        one, two = extract_features(wall(), "fusion+absent"), extract_features(wall())
    finally:
        remove_cue("absent")
    assert np.array_equal(one.mixed(2.0), two.mixed(2.0))


def test_values_of_another_shape_are_refused() -> None:
    register_cue(Cue("odd", "color", lambda _: np.zeros((3, 3, 1), np.float32)))
    try:
        with pytest.raises(GeohueError, match=r"cue 'odd': values of shape \(3, 3, 1\)"):
            extract_features(wall(), "color+odd")
    finally:
        remove_cue("odd")


@pytest.mark.parametrize("name", ["fusion", "geometry", "a+b", ""])
def test_names_that_mean_something_else_are_refused(name: str) -> None:
    with pytest.raises(GeohueError, match="taken, empty or has a plus sign"):
        register_cue(Cue(name, "color", mark))


def test_a_name_is_registered_once(warmth: Cue) -> None:
    with pytest.raises(GeohueError, match="'warmth'"):
        register_cue(warmth)
    with pytest.raises(GeohueError, match="share is 0"):
        register_cue(Cue("none", "color", mark, share=0))


def test_known_names_are_listed(warmth: Cue) -> None:
    assert known_cues()[-1] == warmth.name
    check_cues("geometry+warmth")
    for bad in ("heat", "fusion+heat", "fusion+", "", None):
        with pytest.raises(GeohueError, match="fusion, color, geometry, warmth"):
            check_cues(bad)  # type: ignore[arg-type]


def test_weight_counts_only_between_two_sides(warmth: Cue) -> None:
    def features(cues: str) -> Features:
        return extract_features(wall(), cues)

    assert not features("color+warmth").is_fused
    assert features("geometry+warmth").is_fused
    assert segment(wall(), 2, cues="color+warmth", preset=LIGHT).weight == 0
    assert [cell.cues for cell in plan_cells(["nncsc"], ["fusion", f"fusion+{warmth.name}"])] == [
        "fusion",
        "fusion+warmth",
    ]


def test_compared_systems_that_go_by_vectors_take_it(warmth: Cue) -> None:
    cues = f"fusion+{warmth.name}"
    assert segment(wall(), 2, 1.0, LIGHT, cues, "kmeans").k == 2
    with pytest.raises(GeohueError, match="is not defined for cues"):
        segment(wall(), 2, 1.0, LIGHT, cues, "calderero-marques")
