"""Superpoints as files for those who train on them."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.read.extras import optional
from geohue.results.folder import SUPERPOINTS, whole_folder
from geohue.results.outputs import write_scene_las, write_scene_ply
from geohue.results.picture import picture
from geohue.results.png import write_png
from geohue.results.tensor import write_tensor
from geohue.segmentation.result import Segmentation
from geohue.superpoint import nested

FORMATS = ("ply", "las", "laz")
"""What can be asked for beside the arrays."""


def write_superpoints(
    folder: str | Path,
    seg: Segmentation,
    counts: Sequence[int] = (),
    formats: Sequence[str] = (),
    *,
    overwrite: bool = False,
) -> list[Path]:
    """Write superpoints, their levels and their graph.

    Parameters
    ----------
    folder : path-like
        Made if it does not exist.
    seg : Segmentation
        Superpoints with their scene.
    counts : sequence of int
        Coarser levels to write, too.
    formats : sequence of str
        More files, any of `FORMATS`.
    overwrite : bool
        Whether to write into a folder that has other files than earlier superpoints.

    Returns
    -------
    list of Path
        ``superpoints.npy`` (int64, shape of the scene, -1 = none); ``superpoints.pth``, the same as
        a tensor; ``levels.npz`` with ``labels`` (L, ...) int64 and ``counts`` (L,), the finest
        first; ``graph.npz`` (`graph_arrays`); ``superpoints.png``; ``superpoints.ply`` or
        ``.las`` with the ids; and ``superpoints.json``.

    Raises
    ------
    GeohueError
        If a file cannot be written, a count is not among the levels, or a format is unknown or
        needs a library that is missing.
    """
    _check(seg, formats, Path(folder))
    scene = seg.scene
    assert scene is not None
    levels = nested(seg, [seg.k, *counts])
    arrays = {"labels": levels, "counts": levels.reshape(len(levels), -1).max(axis=1) + 1}
    content = json.dumps(seg.summary(), indent=2) + "\n"
    with whole_folder(folder, SUPERPOINTS, overwrite=overwrite) as new:
        np.save(new / "superpoints.npy", levels[0])
        write_tensor(new / "superpoints.pth", levels[0])
        write_png(new / "superpoints.png", picture(scene, seg.labels))
        np.savez_compressed(new / "levels.npz", **arrays)
        np.savez_compressed(new / "graph.npz", **graph_arrays(seg))  # type: ignore[arg-type]
        names = ["superpoints.npy", "superpoints.pth", "superpoints.png", "levels.npz", "graph.npz"]
        for name in dict.fromkeys(formats):
            names.append(f"superpoints.{name}")
            write = write_scene_ply if name == "ply" else write_scene_las
            write(new / names[-1], scene, seg)
        names.append(SUPERPOINTS.mark)
        (new / names[-1]).write_text(content, encoding="utf-8")
    return [Path(folder) / name for name in names]


def graph_arrays(seg: Segmentation) -> dict[str, NDArray[Any]]:
    """Return the graph of superpoints with features of nodes and edges, as plain arrays.

    Returns
    -------
    dict of arrays
        For K superpoints: ``size`` (K,) points, ``center`` (K, 3), ``color`` (K, 3) mean sRGB,
        ``normal`` (K, 3), ``spread`` (K, 3) standard deviations along the axes of its plane, the
        largest first, ``box`` (K, 3) edges of the oriented box, ``residual`` (K,) of the plane.
        For B borders: ``edges`` (B, 2), ``length``, ``contact``, ``color_step``, ``normal_angle``,
        ``convexity`` (B,), as in `geohue.objects.Neighbours`. NaN where something is not known.
    """
    m = seg.segments.measured
    graph = m.neighbours
    return {
        "size": m.sums.area,
        "center": m.sums.centroid + m.offset,
        "color": m.sums.color,
        "normal": m.planes.normal,
        "spread": m.planes.spread,
        "box": m.boxes.size,
        "residual": m.planes.residual,
        "edges": graph.pairs,
        "length": graph.length,
        "contact": graph.contact,
        "color_step": graph.color_step,
        "normal_angle": graph.normal_angle,
        "convexity": graph.convexity,
    }


def _check(seg: Segmentation, formats: Sequence[str], target: Path) -> None:
    for name in formats:
        if name not in FORMATS:
            raise GeohueError(f"format {name!r}: choose among {', '.join(FORMATS)}")
        if seg.scene is None or not seg.scene.valid.any():
            raise GeohueError(f"format {name!r} needs geometry, which this scene has not")
        if name in ("las", "laz"):
            optional("laspy", "clouds", target / f"superpoints.{name}")
        if name == "laz":
            optional("lazrs", "clouds", target / "superpoints.laz")
