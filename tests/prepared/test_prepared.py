"""The one value that every stage works on."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

import geohue.features.raw
from geohue import Preset, Scene, segment
from geohue.features import Raw, lab_of
from geohue.ncut.cutter import Cutter
from geohue.prepared import PreparedScene, prepare_scene

SMALL = Preset().changed(draft_points=600, landmarks=60)
Case = tuple[Scene, NDArray[np.int32]]


def with_gaps(scene: Scene) -> Scene:
    assert scene.depth is not None
    depth = scene.depth.copy()
    depth[5:12, 8:20] = np.nan
    return Scene.from_rgbd(scene.colors, depth, scene.intrinsics)


def test_the_draft_is_the_part_of_the_scene_at_its_positions(three_boxes: Case) -> None:
    prepared = prepare_scene(with_gaps(three_boxes[0]), SMALL)
    scene, at = prepared.scene, prepared.positions
    assert np.array_equal(prepared.draft.colors, scene.colors.reshape(-1, 3)[at])
    assert prepared.draft_features.shape == prepared.draft.shape == at.shape
    inside = at.reshape(-1)[prepared.draft_features.index]
    rows = np.searchsorted(prepared.features.index, inside)
    assert np.array_equal(prepared.draft_features.color, prepared.features.color[rows])


def test_the_seed_draws_the_draft_of_a_cloud(three_boxes: Case) -> None:
    scene, _ = three_boxes
    cloud = Scene.from_cloud(scene.points.reshape(-1, 3), scene.colors.reshape(-1, 3))
    one, same, other = (prepare_scene(cloud, SMALL, seed=seed).positions for seed in (3, 3, 4))
    assert np.array_equal(one, same)
    assert not np.array_equal(one, other)


def test_a_cut_needs_nothing_else(three_boxes: Case) -> None:
    scene, truth = three_boxes
    labels = Cutter(prepare_scene(scene, SMALL), 3).labels(1.0, 3)
    assert len({(int(a), int(b)) for a, b in zip(labels.flat, truth.flat, strict=True)}) == 3


def test_the_fit_of_a_preset_is_used(three_boxes: Case) -> None:
    prepared = prepare_scene(three_boxes[0], SMALL)
    quick = replace(prepared, settings=SMALL.changed(fit="draft"))
    whole, draft = (Cutter(p, 3).model(1.0, 3).cut.eigenvalues for p in (prepared, quick))
    assert not np.array_equal(whole, draft)


@pytest.mark.parametrize("gaps", [True, False])
def test_lab_of_the_whole_image_is_made_once(
    three_boxes: Case, gaps: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = with_gaps(three_boxes[0]) if gaps else three_boxes[0]
    made: list[tuple[int, ...]] = []

    def counted(colors: NDArray[np.uint8]) -> NDArray[np.float32]:
        made.append(colors.shape)
        return lab_of(colors)

    monkeypatch.setattr(geohue.features.raw, "lab_of", counted)
    result = segment(scene, 3, weight=1.0, preset=SMALL)
    assert (result.labels >= 0).all()
    assert made == [scene.colors.shape]


def test_lab_is_let_go_where_nothing_is_filled(three_boxes: Case) -> None:
    scene, _ = three_boxes
    gappy, whole = Raw(with_gaps(scene)), Raw(scene)
    assert gappy.lab is gappy.lab
    assert whole.lab is not whole.lab
    assert np.array_equal(whole.lab, lab_of(scene.colors))


def test_features_that_are_there_are_taken(three_boxes: Case) -> None:
    prepared = prepare_scene(three_boxes[0], SMALL, "geometry", seed=2)
    again = PreparedScene.of(prepared.raw, prepared.features, SMALL, seed=2)
    assert again.features is prepared.features
    assert np.array_equal(again.positions, prepared.positions)
