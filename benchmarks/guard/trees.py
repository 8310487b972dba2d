"""The two revisions side by side, and the files that both are asked to work on."""

from __future__ import annotations

import io
import os
import shutil
import subprocess
import sys
import tarfile
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[2]


def check_out(revision: str | None, folder: Path) -> Path:
    """Put the library of a revision (None: as it is now) into a folder; returns its ``src``."""
    if revision is None:
        ignore = shutil.ignore_patterns("__pycache__")
        shutil.copytree(ROOT / "src", folder / "src", ignore=ignore)
        return folder / "src"
    done = subprocess.run(
        ["git", "archive", revision, "src"], cwd=ROOT, capture_output=True, check=False
    )
    if done.returncode:
        sys.exit(f"{revision}: {done.stderr.decode().strip()}")
    with tarfile.open(fileobj=io.BytesIO(done.stdout)) as archive:
        archive.extractall(folder, filter="data")
    return folder / "src"


def write_inputs(folder: Path) -> None:
    """Write the motorcycle as arrays, a depth map, a PLY and, with laspy, a LAS file."""
    import cv2

    from geohue.datasets import load_sample
    from geohue.results import write_ply

    scene = load_sample("motorcycle")
    assert scene.depth is not None
    assert scene.intrinsics is not None
    camera = scene.intrinsics
    numbers = [camera.fx, camera.fy, camera.cx, camera.cy]
    np.savez(folder / "frame.npz", rgb=scene.colors, depth=scene.depth, camera=np.array(numbers))
    millimetres = np.nan_to_num(1000 * scene.depth).round().astype(np.uint16)
    cv2.imwrite(os.fspath(folder / "depth.png"), millimetres)
    points, colors = scene.points[scene.valid], scene.colors[scene.valid]
    labels = np.zeros(len(points), np.int32)
    write_ply(folder / "cloud.ply", points, colors, labels)
    try:
        from geohue.results.las import write_las

        write_las(folder / "cloud.las", points, colors, labels)
    except Exception as error:  # without laspy, readers of LAS are not measured
        print(f"no LAS file: {error}", file=sys.stderr)
