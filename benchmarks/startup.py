"""How long a start takes: imports, the help, first and later runs, a frame of 12 megapixels.

    python -m benchmarks.startup [--base REVISION] [--rounds 15] [--first-runs 3] [--no-frame]

Every figure is a fresh process; with ``--base`` the processes of that revision alternate with those
of the files as they are now. Imports and the help: medians of all rounds. First runs: ``geohue
segment --sample motorcycle`` with an empty cache of compiled loops, each followed by later runs,
with what the first one said of it; and again after ``geohue warm``. The frame is the motorcycle,
enlarged to 4000 x 3000, from PNG files to all the files of a result.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from collections import defaultdict
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import perf_counter

from benchmarks.guard.trees import check_out

STARTS = {
    "python": ["-c", "pass"],
    "import numpy": ["-c", "import numpy"],
    "import geohue": ["-c", "import geohue"],
    "import geohue, use it": ["-c", "import geohue; geohue.segment, geohue.Scene"],
    "geohue --help": ["-m", "geohue", "--help"],
}

SEGMENT = ["-m", "geohue", "segment", "--sample", "motorcycle"]
LATER = 3
FRAME = (4000, 3000)

Trees = dict[str, Path]
Times = dict[tuple[str, str], list[float]]


def timed(tree: Path, arguments: list[str], cache: Path | None = None) -> tuple[float, str]:
    """Run Python once; returns the seconds and what it said on standard error."""
    given = os.environ | {"PYTHONPATH": str(tree)}
    if cache is not None:
        given["NUMBA_CACHE_DIR"] = str(cache)
    begin = perf_counter()
    done = subprocess.run([sys.executable, *arguments], capture_output=True, text=True, env=given)
    seconds = perf_counter() - begin
    if done.returncode:
        sys.exit(f"{' '.join(arguments)}: {done.stderr}")
    return seconds, done.stderr.strip()


def print_table(title: str, times: Times, unit: float, digits: int) -> None:
    """Print the medians and the ranges, a row a case and revision."""
    print(f"\n| {title} | | median | least to most |")
    print("| --- | --- | --: | --: |")
    for (case, tree), found in times.items():
        low, middle, high = (unit * f(found) for f in (min, median, max))
        print(f"| {case} | {tree} | {middle:.{digits}f} | {low:.{digits}f} - {high:.{digits}f} |")


def print_starts(trees: Trees, rounds: int) -> None:
    """Print the table of imports."""
    times: Times = defaultdict(list)
    for turn in range(rounds + 1):
        for case, arguments in STARTS.items():
            for name, tree in trees.items():
                seconds, _ = timed(tree, arguments)
                if turn:  # the first reads the files from the disk
                    times[case, name].append(seconds)
    print_table("fresh process, ms", times, 1000, 0)


def print_first_runs(trees: Trees, count: int, folder: Path) -> None:
    """Print the table of first and later runs."""
    times: Times = defaultdict(list)
    said: dict[str, str] = {}
    segment = [*SEGMENT, "-o", str(folder / "out")]
    for turn in range(count):
        for name, tree in trees.items():
            cache = folder / f"{name} {turn}"
            cache.mkdir()
            seconds, said[name] = timed(tree, segment, cache)
            times["first run", name].append(seconds)
            times["later runs", name] += [timed(tree, segment, cache)[0] for _ in range(LATER)]
            warmed = folder / f"{name} {turn} warm"
            warmed.mkdir()
            times["geohue warm", name].append(timed(tree, ["-m", "geohue", "warm"], warmed)[0])
            times["first run after it", name].append(timed(tree, segment, warmed)[0])
    print_table("geohue segment --sample motorcycle, s", dict(sorted(times.items())), 1, 2)
    for name, words in said.items():
        print(f"\nWhat a first run says ({name}): {words}")


def print_frame(trees: Trees, folder: Path) -> None:
    """Print how long a large frame takes, and the peak of memory, with the loops compiled."""
    image, depth, camera = write_frame(folder)
    cache = folder / "frame"
    arguments = ["-m", "geohue", "segment", image, depth, "--intrinsics", camera]
    arguments += ["-o", str(folder / "large")]
    print(f"\n| {FRAME[0]} x {FRAME[1]} | s, from PNG to files | peak MB |")
    print("| --- | --: | --: |")
    for name, tree in trees.items():
        timed(tree, [*SEGMENT, "-o", str(folder / "out")], cache)
        timed(tree, arguments, cache)
        seconds, _ = timed(tree, arguments, cache)
        print(f"| {name} | {seconds:.1f} | {peak(tree, arguments, cache)} |")


def peak(tree: Path, arguments: list[str], cache: Path) -> int:
    """Return the largest memory of a process, in MB, by a process that waits for it alone."""
    watch = "import resource, subprocess, sys; subprocess.run(sys.argv[1:], capture_output=True); "
    watch += "print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)"
    given = os.environ | {"PYTHONPATH": str(tree), "NUMBA_CACHE_DIR": str(cache)}
    command = [sys.executable, "-c", watch, sys.executable, *arguments]
    told = subprocess.run(command, capture_output=True, text=True, env=given, check=True).stdout
    return int(told) * (1 if sys.platform == "darwin" else 1024) // 10**6


def write_frame(folder: Path) -> tuple[str, str, str]:
    """Write the motorcycle enlarged, its depth in millimetres and its camera."""
    import cv2
    import numpy as np

    from geohue.datasets import load_sample

    scene = load_sample("motorcycle")
    assert scene.depth is not None
    assert scene.intrinsics is not None
    width = scene.shape[0] * FRAME[0] // FRAME[1]
    times = FRAME[1] / scene.shape[0]
    files = [folder / name for name in ("rgb.png", "depth.png", "camera.json")]
    image = cv2.resize(scene.colors[:, :width, ::-1], FRAME, interpolation=cv2.INTER_CUBIC)
    depth = cv2.resize(scene.depth[:, :width], FRAME, interpolation=cv2.INTER_NEAREST)
    cv2.imwrite(str(files[0]), image)
    cv2.imwrite(str(files[1]), np.nan_to_num(1000 * np.minimum(depth, 65)).astype(np.uint16))
    camera = scene.intrinsics
    numbers = {name: times * getattr(camera, name) for name in ("fx", "fy", "cx", "cy")}
    files[2].write_text(json.dumps(numbers | {"width": FRAME[0], "height": FRAME[1]}))
    return str(files[0]), str(files[1]), str(files[2])


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--base", help="a revision to compare with")
    parser.add_argument("--rounds", type=int, default=15)
    parser.add_argument("--first-runs", type=int, default=3)
    parser.add_argument("--no-frame", action="store_true")
    given = parser.parse_args()
    with TemporaryDirectory() as name:
        folder = Path(name).resolve()
        revisions = [given.base] if given.base else []
        trees = {base: check_out(base, folder / "base") for base in revisions}
        trees["now"] = check_out(None, folder / "now")
        print_starts(trees, given.rounds)
        print_first_runs(trees, given.first_runs, folder)
        if not given.no_frame:
            print_frame(trees, folder)


if __name__ == "__main__":
    main()
