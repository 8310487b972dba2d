"""Section VII: the same scenes through three sensors. Fig. 18 as a picture, Table I as numbers.

    python -m benchmarks.sensors [-o docs/sensors.png] [--seeds 3]

Scenes and sensors are those of `geohue.simulate`; K is the true number of segments.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.measures import evaluate
from geohue.results.atomic import atomic_write
from geohue.results.picture import overlay
from geohue.segmentation.driver import segment
from geohue.simulate import CAMERA, SENSORS, WORLDS, render, scene

Floats = NDArray[np.float64]

REACH = 12
"""Pixels to each side of a true edge in which the measured edge is looked for."""

JUMP = 0.05
"""Metres: neighbouring pixels of two segments that differ by more are a depth edge."""

CELL = (128, 96)
"""Width and height of each picture of Fig. 18."""

TITLES = {None: "exact depth", "tof": "ToF", "kinect": "structured light", "stereo": "stereo"}


def edge_error(depth: Floats, exact: Floats, truth: NDArray[np.int32]) -> tuple[float, float]:
    """Return how far measured depth edges are from the true ones, and the share not found.

    Along each row, for every true edge: the measured edge is where the depth passes the middle
    between the two true depths; a gap takes the depth of its nearest end. The distance counts to
    half a pixel; edges without a passing within `REACH` are not found.
    """
    rows, columns = np.nonzero(
        (truth[:, 1:] != truth[:, :-1]) & (np.abs(np.diff(exact, axis=1)) > JUMP)
    )
    filled = _without_gaps(depth)
    errors = []
    for row, column in zip(rows, columns, strict=True):
        middle = (exact[row, column] + exact[row, column + 1]) / 2
        start = max(0, column - REACH)
        above = filled[row, start : column + REACH + 2] > middle
        rising = exact[row, column + 1] > exact[row, column]
        passes = np.flatnonzero(above[1:] != above[:-1])
        passes = passes[above[passes + 1] == rising]
        errors.append(np.abs(passes + start - column).min() if passes.size else np.nan)
    found = np.array(errors, np.float64)
    lost = np.isnan(found)
    return float(found[~lost].mean()) if not lost.all() else np.nan, float(lost.mean())


def _without_gaps(depth: Floats) -> Floats:
    """Give each missing pixel the depth of the nearest one in its row."""
    filled = depth.copy()
    index = np.arange(depth.shape[1])
    for line in filled:
        known = np.flatnonzero(np.isfinite(line))
        if known.size:
            after = np.clip(np.searchsorted(known, index), 0, known.size - 1)
            before = np.maximum(after - 1, 0)
            nearer = np.abs(known[before] - index) <= np.abs(known[after] - index)
            line[:] = line[np.where(nearer, known[before], known[after])]
    return filled


def measure(name: str, sensor: str | None, seed: int) -> tuple[dict[str, float], list[Any]]:
    """Return the figures of one scene through one sensor, and its depth map and segments."""
    frame, truth = scene(name, sensor, seed=seed)
    assert frame.depth is not None
    depth = frame.depth.astype(np.float64)
    true_depth = render(WORLDS[name](), CAMERA, samples=1).depth
    found = segment(frame, int(truth.max()) + 1, seed=seed, threads=1)
    scores = evaluate(found.labels, truth, ignore=None)
    error, lost = edge_error(depth, true_depth, truth)
    figures = {
        "missing": float(np.isnan(depth).mean()),
        "rms": float(np.sqrt(np.nanmean((depth - true_depth) ** 2))),
        "edge": error,
        "lost": lost,
        **{key: scores[key] for key in ("voi_bits", "rand", "boundary_f")},
        "boundary_displacement": scores["boundary_displacement"],
        "weight": found.weight,
    }
    return figures, [_grey(depth), overlay(frame.colors, found.labels)]


def _grey(depth: Floats) -> NDArray[np.uint8]:
    bright = np.nan_to_num(255 * (2.6 - depth) / 2.0, nan=0.0).clip(0, 255).astype(np.uint8)
    return np.repeat(bright[..., None], 3, axis=2)


def picture(shown: dict[tuple[str, str | None], list[Any]]) -> NDArray[np.uint8]:
    """Lay out Fig. 18: a row a scene; image, truth, then depth and segments of each sensor."""
    import cv2

    rows = []
    for name in WORLDS:
        frame, truth = scene(name)
        cells = [frame.colors, overlay(frame.colors, truth)]
        for sensor in TITLES:
            cells += shown[name, sensor]
        small = [cv2.resize(c, CELL, interpolation=cv2.INTER_AREA) for c in cells]
        rows.append(
            np.hstack(
                [
                    np.pad(c, ((0, 3), (0, 3), (0, 0)), "constant", constant_values=255)
                    for c in small
                ]
            )
        )
    head = np.full((22, rows[0].shape[1], 3), 255, np.uint8)
    titles = ["image", "true segments"]
    for title in TITLES.values():
        titles += [title, "segments"]
    for i, title in enumerate(titles):
        place = ((CELL[0] + 3) * i + 3, 15)
        cv2.putText(head, title, place, cv2.FONT_HERSHEY_SIMPLEX, 0.38, (0, 0, 0), 1)
    return np.vstack([head, *rows])


def _write_small(path: Path, image: NDArray[np.uint8]) -> None:
    """Write a PNG with 256 colours: a quarter of the bytes."""
    from PIL import Image

    method, dither = Image.Quantize.MAXCOVERAGE, Image.Dither.NONE
    with atomic_write(path) as temporary:
        few = Image.fromarray(image).quantize(256, method, kmeans=2, dither=dither)
        few.save(temporary, "png", optimize=True)


HEADS = {
    "edge": "edge error (px)",
    "lost": "edges not found",
    "missing": "missing depth",
    "rms": "depth error, RMS (m)",
    "voi_bits": "VoI (bits)",
    "rand": "Rand",
    "boundary_f": "boundary F",
    "boundary_displacement": "displacement (px)",
}


def table(figures: dict[tuple[str, str | None, int], dict[str, float]]) -> str:
    """Write Table I as numbers: means over scenes and seeds, and VoI scene by scene."""
    lines = ["| sensor | " + " | ".join(HEADS.values()) + " |"]
    lines.append("| --- |" + " --: |" * len(HEADS))
    for sensor, title in TITLES.items():
        mine = [f for (_, s, _), f in figures.items() if s == sensor]
        cells = []
        for key in HEADS:
            mean = float(np.mean([f[key] for f in mine]))
            percent = key in ("missing", "lost")
            cells.append(f"{mean:.1%}" if percent else f"{mean:.3f}")
        lines.append(f"| {title} | " + " | ".join(cells) + " |")
    lines += ["", "| VoI (bits) | " + " | ".join(WORLDS) + " |", "| --- |" + " --: |" * len(WORLDS)]
    for sensor, title in TITLES.items():
        cells = []
        for name in WORLDS:
            values = [f["voi_bits"] for (n, s, _), f in figures.items() if (n, s) == (name, sensor)]
            cells.append(f"{np.mean(values):.2f} ± {np.std(values):.2f}")
        lines.append(f"| {title} | " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def main() -> None:
    """Measure all scenes through all sensors."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--out", type=Path)
    parser.add_argument("--seeds", type=int, default=3)
    given = parser.parse_args()
    figures: dict[tuple[str, str | None, int], dict[str, float]] = {}
    shown: dict[tuple[str, str | None], list[Any]] = {}
    for name in WORLDS:
        for sensor in (None, *SENSORS):
            for seed in range(given.seeds):
                figures[name, sensor, seed], pictures = measure(name, sensor, seed)
                shown.setdefault((name, sensor), pictures)
    print(table(figures))
    if given.out is not None:
        _write_small(given.out, picture(shown))


if __name__ == "__main__":
    main()
