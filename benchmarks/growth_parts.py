"""What a point costs in each step of the two passes, on one core.

    python benchmarks/growth_parts.py CLOUD

Processor time, the least of five turns over 250,000 points from the middle of the cloud.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from geohue.compute.parallel import Workers
from geohue.features import Raw
from geohue.jobs.outcome import one_thread
from geohue.large.moments import Moments
from geohue.large.passes import BLOCK
from geohue.large.vectors import Standard, raw_values
from geohue.ncut.cutter import Cutter
from geohue.prepared import PreparedScene
from geohue.read.clouds.chunks import open_chunks
from geohue.scene import Scene
from geohue.settings import PRESETS

Result = TypeVar("Result")


def timed(name: str, function: Callable[[], Result]) -> Result:
    """Print what a point costs in a function, and return what it returns."""
    function()
    seconds = []
    for _ in range(5):
        begin = time.process_time()
        result = function()
        seconds.append(time.process_time() - begin)
    print(f"| {name} | {1e6 * min(seconds) / BLOCK:.3f} |")
    return result


@one_thread()
def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("cloud", type=Path)
    chunks = open_chunks(parser.parse_args().cloud)
    start = chunks.n_points // 2 // BLOCK * BLOCK
    print("| step | us / point |\n| --- | ---: |")
    xyz, rgb = timed("read", lambda: chunks.read(start, start + BLOCK))
    chunks.close()
    known, values = timed("Lab", lambda: raw_values(xyz, rgb, "fusion"))
    moments = timed("moments", lambda: Moments.of(values))
    standard = Standard.of(moments, "fusion")
    features = timed("normalise", lambda: standard.features(values, known))
    vectors = timed("mix", lambda: features.mixed(1.0))
    raw = Raw(Scene.from_cloud(xyz, rgb))
    prepared = PreparedScene.of(raw, features, PRESETS["paper"])
    model = Cutter(prepared, 6).model(1.0, 6)
    timed("label", lambda: model.labels(vectors, Workers(None)))


if __name__ == "__main__":
    main()
