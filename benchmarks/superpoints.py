"""Superpoints beside other ways to them: what can be made of them at best, and what they cost.

    python -m benchmarks.superpoints [--data DIR] [--limit 6] [--cut-pursuit PYTHON]
        [--picture FILE] [--speed] [--only METHOD] [--group NAME]

Scenes: table tops of mosd as frames and as clouds, the room (its parts, its objects), maize, all of
the test part of `splits.json`, and simulated scenes as seen by three sensors. Each method is run at
several settings; its measures are interpolated along the logarithm of the number of superpoints
that lie on labelled points, at 30, 100, 300, 1000 and 3000 of them.

- geohue: `superpoints`, one run for each number;
- SLIC and Felzenszwalb of scikit-image on the picture (`slic` with compactness 10, `felzenszwalb`
  with sigma 0.8);
- VCCS: `benchmarks.peers.vccs`;
- cut pursuit: the package cut-pursuit-py in an environment of its own, whose interpreter is given;
  colours and the shape of the 20 nearest points (linearity, planarity, scattering, verticality) on
  the graph of 10 nearest points, as in superpoint graphs (Landrieu and Simonovsky, 2018). Version
  1.0.12 of the package does not heed its `reg_strength`, so the features are scaled instead.
"""

from __future__ import annotations

import argparse
import subprocess
import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from time import perf_counter

import numpy as np
from benchmarks.merge_frames import load, names
from benchmarks.peers.vccs import supervoxels
from numpy.typing import NDArray
from PIL import Image

from geohue.measures import superpoint_scores
from geohue.regions.adjacency import adjacent_points
from geohue.results.picture import picture
from geohue.scene import Scene
from geohue.simulate import SENSORS, WORLDS
from geohue.simulate import scene as simulated
from geohue.superpoint import loops, superpoints
from geohue.superpoint.nodes import nodes_of

COUNTS = (30, 100, 300, 1000, 3000)
MEASURES = {
    "achievable_accuracy": "ASA",
    "boundary_recall": "recall",
    "boundary_precision": "precision",
    "undersegmentation_error": "under-seg. error",
    "compactness": "compactness",
}

Labels = NDArray[np.int32]


@dataclass(eq=False)
class Case:
    """A scene with true labels, 0 = none."""

    scene: Scene
    truth: Labels

    @cached_property
    def pairs(self) -> tuple[NDArray[np.int64], NDArray[np.int64]] | None:
        """Neighbours in a cloud."""
        return None if self.scene.is_grid else adjacent_points(self.scene)

    @cached_property
    def valid(self) -> NDArray[np.int64]:
        """Flat positions of the points."""
        return np.flatnonzero(self.scene.valid)

    @cached_property
    def area(self) -> float:
        """Area of the surface."""
        nodes = nodes_of(self.scene, "geometry")
        return nodes.size * loops.mean_area(nodes.points, nodes.normals, nodes.one, nodes.other)

    @cached_property
    def spacing(self) -> float:
        """Typical distance of neighbours."""
        return nodes_of(self.scene, "geometry").spacing

    def score(self, labels: Labels) -> dict[str, float]:
        """Measure an over-segmentation."""
        return superpoint_scores(labels, self.truth, pairs=self.pairs)


def own(case: Case) -> Iterator[Labels]:
    """Superpoints of this library."""
    for count in (*COUNTS, 6000):
        if count < case.scene.size / 4:
            yield superpoints(case.scene, count=count).labels


def slic(case: Case) -> Iterator[Labels]:
    """SLIC of scikit-image."""
    from skimage.segmentation import slic as run

    for count in (30, 60, 200, 600, 2000, 6000):
        yield np.asarray(run(case.scene.colors, n_segments=count, start_label=0), np.int32)


def felzenszwalb(case: Case) -> Iterator[Labels]:
    """Felzenszwalb and Huttenlocher's, of scikit-image."""
    from skimage.segmentation import felzenszwalb as run

    for least in (12, 40, 120, 400, 1300, 4000):
        given = {
            "scale": least,
            "sigma": 0.8,
            "min_size": max(4, least * case.scene.size // 307200),
        }
        yield np.asarray(run(case.scene.colors, **given), np.int32)


def vccs(case: Case) -> Iterator[Labels]:
    """Growing supervoxels."""
    points = case.scene.points.reshape(-1, 3)[case.valid].astype(np.float64)
    colors = case.scene.colors.reshape(-1, 3)[case.valid]
    for count in (20, 60, 200, 600, 2000, 6000):
        seed = float(np.sqrt(case.area / count))
        voxel = max(1.5 * case.spacing, seed / 12)
        if voxel > seed / 2.5:
            continue
        labels = np.full(case.scene.size, -1, np.int32)
        labels[case.valid] = supervoxels(points, colors, voxel, seed)
        yield labels.reshape(case.scene.shape)


def cut_pursuit(case: Case, python: Path) -> Iterator[Labels]:
    """l0 cut pursuit on the features of superpoint graphs, in its own environment."""
    from scipy.spatial import cKDTree

    points = case.scene.points.reshape(-1, 3)[case.valid].astype(np.float64)
    near = np.asarray(cKDTree(points).query(points, 21, workers=2)[1])
    features = _shape_of(points, near)
    if (case.scene.colors != case.scene.colors.reshape(-1, 3)[0]).any():
        colors = case.scene.colors.reshape(-1, 3)[case.valid] / 255
        features = np.hstack([features, colors])
    one, other = np.repeat(np.arange(len(points)), 10), near[:, 1:11].reshape(-1)
    length = np.linalg.norm(points[one] - points[other], axis=1)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "in.npz"
        for scale in (0.7, 1.5, 3.0, 6.0, 12.0, 24.0, 48.0):
            np.savez(
                file,
                features=(scale * features).astype(np.float32),
                weights=(1 / (1 + length / length.mean())).astype(np.float32),
                one=one.astype(np.uint32),
                other=other.astype(np.uint32),
            )
            answer = Path(folder) / "out.npy"
            subprocess.run([python, "-c", _PURSUIT, file, answer], check=True, capture_output=True)
            labels = np.full(case.scene.size, -1, np.int32)
            labels[case.valid] = np.load(answer)
            yield labels.reshape(case.scene.shape)


_PURSUIT = """
import sys, numpy as np, cut_pursuit_py
d = np.load(sys.argv[1])
f = d["features"]
found = cut_pursuit_py.perform_cut_pursuit(
    reg_strength=1.0, D=f.shape[1], pc_vec=f, edge_weights=d["weights"],
    Eu=d["one"], Ev=d["other"], verbose=False)
np.save(sys.argv[2], np.asarray(found, np.int32))
"""


def _shape_of(points: NDArray[np.float64], near: NDArray[np.int64]) -> NDArray[np.float64]:
    """Linearity, planarity, scattering and verticality around each point, (n, 4)."""
    around = points[near] - points[near].mean(axis=1, keepdims=True)
    values, vectors = np.linalg.eigh(np.einsum("nki,nkj->nij", around, around))
    low, mid, high = np.sqrt(np.maximum(values, 0)).T
    high = np.maximum(high, 1e-12)
    up = (values[:, None] * np.abs(vectors)).sum(axis=2)
    vertical = up[:, 2] / np.maximum(np.linalg.norm(up, axis=1), 1e-12)
    return np.stack([(high - mid) / high, (mid - low) / high, low / high, vertical], axis=1)


Method = Callable[[Case], Iterator[Labels]]


def curve(method: Method, case: Case) -> dict[str, NDArray[np.float64]]:
    """Return the measures of a method, interpolated at `COUNTS`; NaN beyond its settings."""
    rows = []
    begin = perf_counter()
    for labels in method(case):
        seconds = perf_counter() - begin
        rows.append(case.score(labels) | {"seconds": seconds})
        begin = perf_counter()
    rows.sort(key=lambda row: row["n_superpoints"])
    at = np.log([row["n_superpoints"] for row in rows])
    wanted = np.log(COUNTS)
    reach = np.log(1.3)  # a curve is not drawn out beyond its ends by more than so much
    inside = (wanted > at.min() - reach) & (wanted < at.max() + reach)
    return {
        name: np.where(inside, np.interp(wanted, at, [row[name] for row in rows]), np.nan)
        for name in (*MEASURES, "seconds")
    }


def groups(data: Path | None, limit: int) -> Iterator[tuple[str, list[Case], bool]]:
    """Yield the name of a group, its scenes, and whether they are pictures."""
    worlds = [
        Case(*_from_one(*simulated(world, sensor, seed=9)))
        for world in WORLDS
        for sensor in SENSORS
    ]
    yield "simulated frames", worlds, True
    if data is None:
        return
    for folder, title, grid in (
        ("mosd", "table tops, frames", True),
        ("mosd-cloud", "table tops, clouds", False),
        ("maize", "maize plants", False),
    ):
        yield title, [Case(*load(name, data)) for name in names(folder, "test")[:limit]], grid
    for labels, title in (("fine", "room, parts"), ("coarse", "room, objects")):
        yield title, [Case(*load(f"rooms/room2_gt_{labels}", data))], False


def _from_one(scene: Scene, truth: Labels) -> tuple[Scene, Labels]:
    return scene, np.where(scene.valid, truth + 1, 0).astype(np.int32)


def report(title: str, cases: Sequence[Case], methods: dict[str, Method]) -> Iterator[str]:
    """Yield the tables of a group."""
    found = {name: [curve(method, case) for case in cases] for name, method in methods.items()}

    def mean(name: str, measure: str) -> NDArray[np.float64]:
        values = np.array([each[measure] for each in found[name]])
        known = np.isfinite(values).sum(axis=0)
        total = np.nansum(values, axis=0)
        return np.where(2 * known > len(values), total / np.maximum(known, 1), np.nan)

    yield f"**{title}** ({len(cases)})\n"
    yield "| ASA, % | " + " | ".join(map(str, COUNTS)) + " |"
    yield "| --- |" + " --: |" * len(COUNTS)
    for name in methods:
        yield _row(name, 100 * mean(name, "achievable_accuracy"), 2)
    yield ""
    yield "| at 300 | " + " | ".join([*MEASURES.values(), "seconds"]) + " |"
    yield "| --- |" + " --: |" * (len(MEASURES) + 1)
    for name in methods:
        at = np.array([mean(name, measure)[2] for measure in (*MEASURES, "seconds")])
        yield _row(name, at, 3)
    yield ""


def _row(name: str, values: NDArray[np.float64], digits: int) -> str:
    cells = ["-" if np.isnan(v) else f"{v:.{digits}f}" for v in values]
    return f"| {name} | " + " | ".join(cells) + " |"


def speed(points: int = 1_000_000) -> Iterator[str]:
    """Time a room of a million points."""
    rng = np.random.default_rng(0)
    wall, xyz = rng.integers(0, 3, points), rng.random((points, 3)) * [6, 5, 3]
    for axis, length in enumerate((6, 5, 3)):
        on = wall == axis
        xyz[on, axis] = np.round(xyz[on, axis] / length) * length
    xyz += rng.normal(0, 0.003, xyz.shape)
    rgb = (np.floor(xyz * 2) % 2 * 120 + rng.normal(60, 10, xyz.shape)).clip(0, 255)
    scene = Scene.from_cloud(xyz, rgb.astype(np.uint8))
    superpoints(scene.take(np.arange(1000)), count=10)  # compiles
    for size in (30.0, 300.0, 3000.0):
        best = min((superpoints(scene, size=size).timings for _ in range(3)), key=_total)
        parts = ", ".join(f"{name} {seconds:.2f}" for name, seconds in best.items())
        yield f"{points} points, {size:g} a superpoint: {parts} s"


def _total(timings: dict[str, float]) -> float:
    return timings["total"]


def paint(file: Path) -> None:
    """Paint a simulated scene at three sizes, beside SLIC and VCCS at the middle one."""
    case = Case(*_from_one(*simulated("shelf", "kinect", seed=9)))
    width = case.scene.shape[1]
    fine = superpoints(case.scene, count=1000)
    assert fine.levels is not None
    views = [fine.levels.with_segments(k) for k in (1000, 300, 30)]
    others = [
        min(method(case), key=lambda found: abs(int(found.max()) - 300)) for method in (slic, vccs)
    ]
    panes = [case.scene.colors, *(picture(case.scene, v)[:, width:] for v in (*views, *others))]
    top, bottom = np.concatenate(panes[:3], axis=1), np.concatenate(panes[3:], axis=1)
    Image.fromarray(np.concatenate([top, bottom])).save(file, quality=88)


def main() -> None:
    """Write the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=Path)
    parser.add_argument("--limit", type=int, default=6)
    parser.add_argument("--cut-pursuit", type=Path)
    parser.add_argument("--picture", type=Path)
    parser.add_argument("--speed", action="store_true")
    parser.add_argument("--only", help="One method.")
    parser.add_argument("--group", default="", help="Groups whose name has this.")
    given = parser.parse_args()
    if given.picture:
        paint(given.picture)
        return
    if given.speed:
        for line in speed():
            print(line, flush=True)
        return
    for title, cases, grid in groups(given.data, given.limit):
        if given.group not in title:
            continue
        methods: dict[str, Method] = {"geohue": own, "VCCS": vccs}
        if grid:
            methods |= {"SLIC": slic, "Felzenszwalb": felzenszwalb}
        if given.cut_pursuit:
            methods["cut pursuit"] = partial(cut_pursuit, python=given.cut_pursuit)
        if given.only:
            methods = {given.only: methods[given.only]}
        for line in report(title, cases, methods):
            print(line, flush=True)


if __name__ == "__main__":
    main()
