"""Every system: on a scene with known parts, on the odd ones, at any number of threads."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from numpy.typing import NDArray

from geohue import GeohueError, Scene
from geohue.baselines import BASELINES
from geohue.compute.parallel import workers
from geohue.features import CUES, extract_features
from geohue.measures.partition import rand_index

CELLS = [(name, cue) for name, baseline in BASELINES.items() for cue in baseline.cues]


def run(
    name: str, scene: Scene, cue: str, k: int = 3, threads: int = 1, seed: int = 0
) -> NDArray[np.int32]:
    with workers(threads) as team:
        features = extract_features(scene, cue)
        return BASELINES[name].run(scene, features, 1.0, k, seed, team)


def test_the_table_is_that_of_figure_9_and_13() -> None:
    assert list(BASELINES) == [
        "kmeans",
        "meanshift",
        "felzenszwalb",
        "edison",
        "bleiweiss-werman",
        "calderero-marques",
    ]
    assert BASELINES["edison"].cues == ("color", "geometry")
    assert all(set(b.cues) <= set(CUES) for b in BASELINES.values())
    assert [n for n, b in BASELINES.items() if b.uses_k] == ["kmeans", "calderero-marques"]


def test_the_table_imports_no_system() -> None:
    code = (
        "import sys, geohue.baselines;"
        "print(any(m in sys.modules for m in ('numba', 'sklearn', 'skimage')))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"


@pytest.mark.parametrize(("name", "cue"), CELLS)
def test_finds_the_parts_that_its_cue_tells_apart(
    name: str, cue: str, three_boxes: tuple[Scene, NDArray[np.int32]]
) -> None:
    scene, truth = three_boxes
    seen = {"color": np.minimum(truth, 1), "geometry": truth // 2, "fusion": truth}[cue]
    labels = run(name, scene, cue, k=int(seen.max()) + 1)
    assert labels.shape == scene.shape
    assert labels.dtype == np.int32
    if cue == "geometry" and name in ("meanshift", "edison"):  # these cut up planes, no more
        assert not set(labels[:, :60].flat) & set(labels[:, 60:].flat)
    else:
        assert rand_index(labels, seen) > 0.85


@pytest.mark.parametrize(("name", "cue"), CELLS)
def test_same_labels_at_any_number_of_threads(
    name: str, cue: str, three_boxes: tuple[Scene, NDArray[np.int32]]
) -> None:
    scene, _ = three_boxes
    one, two = (run(name, scene, cue, threads=n) for n in (1, 3))
    np.testing.assert_array_equal(one, two)
    np.testing.assert_array_equal(one, run(name, scene, cue, threads=1))


@pytest.mark.parametrize(("name", "cue"), CELLS)
def test_a_constant_scene_is_one_segment_in_color(name: str, cue: str) -> None:
    scene = Scene.from_rgbd(np.full((30, 40, 3), 90, np.uint8), np.ones((30, 40)))
    labels = run(name, scene, cue)
    assert labels.min() >= 0
    if cue == "color" and not BASELINES[name].uses_k:
        assert labels.max() == 0


@pytest.mark.parametrize(("name", "cue"), CELLS)
@pytest.mark.parametrize("shape", [(1, 1), (1, 5), (2, 2)])
def test_tiny_images(name: str, cue: str, shape: tuple[int, int]) -> None:
    rgb = np.arange(shape[0] * shape[1] * 3, dtype=np.uint8).reshape(*shape, 3)
    labels = run(name, Scene.from_rgbd(rgb, np.ones(shape)), cue, k=1)
    assert labels.shape == shape
    assert labels.min() >= 0


@pytest.mark.parametrize(("name", "cue"), CELLS)
def test_pixels_without_depth(
    name: str, cue: str, three_boxes: tuple[Scene, NDArray[np.int32]]
) -> None:
    scene, _ = three_boxes
    assert scene.depth is not None
    depth = scene.depth.copy()
    depth[20:30, 10:50] = np.nan
    holed = Scene.from_rgbd(scene.colors, depth, scene.intrinsics)
    labels = run(name, holed, cue)
    handles = name in ("bleiweiss-werman", "calderero-marques") or cue == "color"
    np.testing.assert_array_equal(labels < 0, ~holed.valid & (not handles))


@pytest.mark.parametrize(("name", "cue"), CELLS)
def test_all_depth_missing(name: str, cue: str) -> None:
    rgb = np.random.default_rng(0).integers(0, 255, (12, 14, 3)).astype(np.uint8)
    scene = Scene.from_rgbd(rgb, np.full((12, 14), np.nan))
    if cue == "color":
        assert run(name, scene, cue).min() >= 0
    else:
        with pytest.raises(GeohueError, match="all depth is missing"):
            run(name, scene, cue)


@pytest.mark.parametrize(
    ("name", "cue"), [cell for cell in CELLS if not BASELINES[cell[0]].needs_grid]
)
def test_clouds(name: str, cue: str) -> None:
    rng = np.random.default_rng(1)
    part = np.repeat([0, 1], 300)
    points = rng.normal(0, 0.1, (600, 3)) + np.array([[0, 0, 0], [3, 0, 0]])[part]
    colors = np.array([[0.9, 0.1, 0.1], [0.1, 0.1, 0.9]])[part]
    points[:5] = np.nan
    labels = run(name, Scene.from_cloud(points, colors), cue, k=2)
    has = np.isfinite(points[:, 0]) if cue != "color" else np.ones(600, bool)
    assert labels.shape == (600,)
    assert (labels[~has] == -1).all()
    known = labels >= 0
    assert rand_index(labels[known], part[known].astype(np.int32)) > 0.9
