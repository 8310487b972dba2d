"""What a frame of a batch costs, stage by stage, and what handing out a job costs.

    python benchmarks/batch.py [--frames 8] [--runs 3] [--jobs 2000]

Kinect frames (640 x 480) of nyuv2, from GEOHUE_DATA (or ../shared/data). Seconds are the
processor's, of one thread; medians over frames and runs that take turns, after a first run that
loads and compiles. Jobs a second are those of `abs`, on two processes here and on two workers of a
dask cluster here.
"""

from __future__ import annotations

import argparse
import os
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from statistics import median
from time import perf_counter, process_time
from typing import Any

from geohue.jobs.outcome import one_thread
from geohue.jobs.pool import run_jobs
from geohue.results.outputs import write_results
from geohue.segmentation.driver import segment
from geohue.studies.batch import find_items

DATA = Path(os.environ.get("GEOHUE_DATA", Path(__file__).parents[2] / "shared" / "data"))
PRESETS = ("best", "fast", "paper")


def frame_costs(frames: int, runs: int) -> dict[str, list[float]]:
    """Return the seconds of reading, of each preset, and of writing all files or only labels."""
    items, _ = find_items(DATA / "nyuv2", limit=frames)
    seconds: dict[str, list[float]] = {}

    @contextmanager
    def timed(name: str) -> Iterator[None]:
        start = process_time()
        yield
        seconds.setdefault(name, []).append(process_time() - start)

    with tempfile.TemporaryDirectory() as out:
        for run in range(runs + 1):
            for item in items[:1] if run == 0 else items:
                with timed("read"):
                    scene = item.read()
                for preset in PRESETS:
                    with timed(f"segment, {preset}"):
                        seg = segment(scene, preset=preset, threads=1)
                    for name, lean in (("write all", False), ("write labels (--lean)", True)):
                        with timed(f"{name}, {preset}"):
                            files = write_results(Path(out), scene, seg, lean=lean)
                        size = sum(file.stat().st_size for file in files) / 1e6
                        seconds.setdefault(f"{name}, {preset}, MB", []).append(size)
            if run == 0:
                seconds.clear()
    return seconds


def jobs_a_second(count: int, rounds: int = 3) -> dict[str, list[float]]:
    """Return how many jobs a second end, here and on a cluster, in turns."""
    import distributed

    start_cluster: Any = distributed.LocalCluster
    found: dict[str, list[float]] = {"processes": [], "dask": []}
    with start_cluster(n_workers=2, threads_per_worker=1, dashboard_address=":0") as cluster:
        ways: dict[str, Callable[[range], object]] = {
            "processes": lambda jobs: list(run_jobs(abs, jobs, 2)),
            "dask": lambda jobs: list(run_jobs(abs, jobs, scheduler=cluster.scheduler_address)),
        }
        for _ in range(rounds):
            for name, way in ways.items():
                start = perf_counter()
                way(range(20))
                begun = perf_counter()
                way(range(count + 20))
                # Less what starting costs.
                found[name].append(count / (perf_counter() - begun - (begun - start)))
    return found


@one_thread()
def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--frames", type=int, default=8)
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--jobs", type=int, default=2000)
    options = parser.parse_args()
    print("| a frame of 640 x 480 | median | range |\n| --- | ---: | ---: |")
    for name, values in frame_costs(options.frames, options.runs).items():
        unit = "" if name.endswith("MB") else " s"
        print(f"| {name} | {median(values):.3f}{unit} | {min(values):.3f}-{max(values):.3f} |")
    print("\n| jobs that do nothing | a second |\n| --- | ---: |")
    for name, rates in jobs_a_second(options.jobs).items():
        print(f"| {name} | {median(rates):.0f} |")


if __name__ == "__main__":
    main()
