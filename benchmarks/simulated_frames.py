"""Write the simulated scenes as a folder of labelled frames, for ``geohue benchmark``.

python -m benchmarks.simulated_frames OUT
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import numpy as np

from geohue.results.atomic import atomic_write
from geohue.results.png import write_png
from geohue.simulate import SENSORS, WORLDS, scene


def write_frame(out: Path, name: str, sensor: str | None) -> None:
    """Write one scene through one sensor; missing depth is 0."""
    frame, truth = scene(name, sensor)
    assert frame.depth is not None
    assert frame.intrinsics is not None
    part = out / f"{name}-{sensor or 'exact'}"
    write_png(part / "rgb.png", frame.colors)
    millimetres = np.nan_to_num(frame.depth * 1000, nan=0.0)
    write_png(part / "depth.png", np.clip(np.rint(millimetres), 0, 65534).astype(np.uint16))
    write_png(part / "labels.png", (truth + 1).astype(np.uint16))
    camera = frame.intrinsics
    content = {name: getattr(camera, name) for name in ("fx", "fy", "cx", "cy", "width", "height")}
    with atomic_write(part / "intrinsics.json") as temporary:
        temporary.write_text(json.dumps(content | {"depth_scale": 1000.0}), encoding="utf-8")


def main() -> None:
    """Write all scenes through all sensors."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path)
    given = parser.parse_args()
    for name in WORLDS:
        for sensor in (None, *SENSORS):
            write_frame(given.out, name, sensor)


if __name__ == "__main__":
    main()
