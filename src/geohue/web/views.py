"""What the page shows of a segmentation: a table as JSON, and arrays as plain bytes."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.merge.levels import threshold_of
from geohue.merge.tree import MergeTree
from geohue.regions.adjacency import adjacent_pixels, adjacent_points
from geohue.results.png import write_png
from geohue.scene import Scene
from geohue.segmentation.result import Segmentation
from geohue.web.points import pack_points

Labels = NDArray[np.int32]

NO_REGION = 65535
"""What stands in the bytes for a pixel or point without a region."""

_MOST_PAIRS = 200_000  # points of a cloud whose neighbours are looked for


def write_views(folder: Path, scene: Scene, seg: Segmentation, shown_points: int) -> None:
    """Write the files that the page asks for.

    ``view.json`` has the regions, the tree of their merges and their borders. Of a grid there are
    ``color.png``, ``regions.bin`` (uint16 of each pixel) and, with depth, ``depth.bin`` (float32
    metres, NaN = missing); of anything with geometry ``points.bin`` (`pack_points`).

    Parameters
    ----------
    folder : Path
    scene : Scene
    seg : Segmentation
    shown_points : int
        Most points of ``points.bin``.

    Raises
    ------
    GeohueError
        If there are more regions than the page can tell apart.
    """
    regions, tree = finest(seg)
    if tree.n_regions >= NO_REGION:
        raise GeohueError(
            f"{tree.n_regions} segments are more than the page can show: use geohue segment"
        )
    view = describe_regions(scene, regions, tree.n_regions)
    view["borders"] = describe_borders(scene, seg, regions)
    view |= {
        "n_regions": tree.n_regions,
        "merges": tree.merges.tolist(),
        "heights": tree.heights.tolist(),
        "start": start_of(seg),
        "shape": list(scene.shape),
        "depth": None,
        "points": 0,
    }
    if scene.is_grid:
        write_png(folder / "color.png", scene.colors)
        _write(folder / "regions.bin", np.where(regions < 0, NO_REGION, regions).astype("<u2"))
        known = scene.points[..., 2][scene.valid]
        if known.size:
            _write(folder / "depth.bin", scene.points[..., 2].astype("<f4"))
            view["depth"] = np.quantile(known, [0.01, 0.99]).tolist()
    if scene.valid.any():
        packed, view["points"] = pack_points(scene, regions, shown_points)
        (folder / "points.bin").write_bytes(packed)
    (folder / "view.json").write_text(json.dumps(view), encoding="utf-8")


def _write(file: Path, values: NDArray[Any]) -> None:
    file.write_bytes(np.ascontiguousarray(values).tobytes())


def finest(seg: Segmentation) -> tuple[Labels, MergeTree]:
    """Return the finest region of each point, and the tree; without levels the segments alone."""
    if seg.levels is not None:
        return seg.levels.regions, seg.levels.tree
    return seg.labels, MergeTree(seg.k, np.zeros((0, 2), np.int64), np.zeros(0))


def start_of(seg: Segmentation) -> int:
    """Return after how many merges the segments of a segmentation appear."""
    if seg.levels is None:
        return 0
    tree = seg.levels.tree
    if seg.detail is None:  # a number of segments was asked for
        return min(max(tree.n_regions - seg.k, 0), len(tree.merges))
    return int(np.searchsorted(tree.heights, threshold_of(seg.detail), "left"))


def describe_regions(scene: Scene, regions: Labels, n: int) -> dict[str, Any]:
    """Return size, mean colour and extent of each region, ready for JSON.

    Parameters
    ----------
    scene : Scene
    regions : int32, shape of the scene
        -1 = none.
    n : int
        How many.

    Returns
    -------
    dict
        ``size`` (n), ``color`` (n, 3), ``low`` and ``high``: the corners of the box around its
        points, (n, 3), null where it has none.

    Examples
    --------
    >>> scene = Scene.from_cloud([[0, 0, 1], [2, 0, 1]], np.uint8([[0, 0, 0], [20, 0, 0]]))
    >>> describe_regions(scene, np.int32([0, 0]), 1)["color"]
    [[10.0, 0.0, 0.0]]
    """
    names = regions.reshape(-1)
    there = names >= 0
    named, colors = names[there], scene.colors.reshape(-1, 3)[there]
    size = np.bincount(named, minlength=n)
    sums = np.stack([np.bincount(named, colors[:, c], n) for c in range(3)], axis=1)
    placed = there & np.isfinite(scene.points[..., 2]).reshape(-1)
    where, points = names[placed], scene.points.reshape(-1, 3)[placed]
    low, high = np.full((n, 3), np.inf, np.float32), np.full((n, 3), -np.inf, np.float32)
    np.minimum.at(low, where, points)
    np.maximum.at(high, where, points)
    return {
        "size": size.tolist(),
        "color": (sums / np.maximum(size, 1)[:, None]).round(2).tolist(),
        "low": [row if np.isfinite(row).all() else None for row in low.tolist()],
        "high": [row if np.isfinite(row).all() else None for row in high.tolist()],
    }


def describe_borders(scene: Scene, seg: Segmentation, regions: Labels) -> dict[str, Any]:
    """Return which regions are neighbours and how many cuts part them, ready for JSON.

    Returns
    -------
    dict
        ``pairs`` (P, 2), ``length``: pairs of neighbouring points along each border, and
        ``votes``: the share of cuts that draw it, 0 to 1, null where no cuts voted.
    """
    one, other = _neighbours(scene)
    names = regions.reshape(-1)
    ends = np.sort(np.stack([names[one], names[other]], axis=1), axis=1)
    ends = ends[(ends[:, 0] >= 0) & (ends[:, 0] != ends[:, 1])]
    pairs, length = np.unique(ends, axis=0, return_counts=True)
    votes: list[float | None] = [None] * len(pairs)
    if seg.shares is not None:
        known = {
            (one, other): round(share, 4)
            for (one, other), share in zip(
                seg.shares.pairs.tolist(), seg.shares.share.tolist(), strict=True
            )
        }
        votes = [known.get((one, other)) for one, other in pairs.tolist()]
    return {"pairs": pairs.tolist(), "length": length.tolist(), "votes": votes}


def _neighbours(scene: Scene) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    if scene.is_grid:
        return adjacent_pixels(scene.shape)
    if scene.size <= _MOST_PAIRS:
        return adjacent_points(scene)
    chosen = np.random.default_rng(0).choice(scene.size, _MOST_PAIRS, replace=False)
    one, other = adjacent_points(scene.take(chosen))
    return chosen[one], chosen[other]
