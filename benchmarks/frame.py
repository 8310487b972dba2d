"""Time of each stage and peak memory for one frame.

    python benchmarks/frame.py [--frames 5] [--runs 3] [--presets best fast paper] [-k auto]

The motorcycle sample, and Kinect frames from GEOHUE_DATA (or ../shared/data) where it is there:
nyuv2 is dense, mosd lacks about 39 % of the depth. Medians; a first run that loads and compiles is
left out.
"""

from __future__ import annotations

import argparse
import os
import platform
import resource
from pathlib import Path
from statistics import median

import geohue
from geohue.datasets import load_sample
from geohue.read.scenes.scenes import read_scene

STAGES = (
    *("features", "cuts", "merge", "borders"),  # best and fast
    *("k", "weight", "cut", "refine"),  # paper
    *("quality", "fill", "total"),
)


def scenes(count: int) -> dict[str, list[geohue.Scene]]:
    """Return the scenes by source."""
    found = {"motorcycle, 741 x 500": [load_sample("motorcycle")]}
    data = Path(os.environ.get("GEOHUE_DATA", Path(__file__).parents[2] / "shared" / "data"))
    for name in ("nyuv2", "mosd"):
        frames = sorted((data / name / "frames").glob("*")) if data.is_dir() else []
        if frames:
            found[f"{name}, 640 x 480"] = [
                read_scene(next(f.glob("rgb.*")), f / "depth.png", f / "intrinsics.json")
                for f in frames[:: max(1, len(frames) // count)][:count]
            ]
    return found


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--frames", type=int, default=5)
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--presets", nargs="+", default=["best", "fast", "paper"])
    parser.add_argument("-k", default="auto")
    options = parser.parse_args()
    k = options.k if options.k == "auto" else int(options.k)
    sources = scenes(options.frames)
    for preset in options.presets:
        geohue.segment(load_sample("motorcycle"), k, preset=preset)
    times: dict[tuple[str, str], list[dict[str, float]]] = {}
    for _ in range(options.runs):  # interleaved, so that a busy moment hits all alike
        for name, group in sources.items():
            for preset in options.presets:
                runs = [geohue.segment(scene, k, preset=preset).timings for scene in group]
                times.setdefault((name, preset), []).extend(runs)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(
        f"geohue {geohue.__version__}, Python {platform.python_version()}, {os.cpu_count()} cores"
    )
    print(f"peak memory of the process with all scenes loaded: {peak:.0f} MB\n")
    print("| ms | preset | " + " | ".join(STAGES) + " |")
    print("| --- | --- |" + " ---: |" * len(STAGES))
    for (name, preset), runs in times.items():
        cells = [f"{1000 * median(run.get(stage, 0.0) for run in runs):.0f}" for stage in STAGES]
        print(f"| {name} | {preset} | " + " | ".join(cells) + " |")


if __name__ == "__main__":
    main()
