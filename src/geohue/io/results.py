"""A segmentation as files: what ``-o DIR`` receives."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from geohue.errors import GeohueError
from geohue.io.atomic import atomic_write
from geohue.io.curve import draw_weight_curve
from geohue.io.images import write_png
from geohue.io.ply import write_ply
from geohue.picture import picture
from geohue.scene import Scene
from geohue.segmentation import Segmentation

_LABEL_LIMIT = np.iinfo(np.uint16).max - 1


def write_results(folder: str | Path, scene: Scene, seg: Segmentation) -> list[Path]:
    """Write labels, pictures, the labelled cloud and the summary.

    Parameters
    ----------
    folder : str or Path
        Made if it does not exist; files of an earlier run are replaced, each in one step.
    scene : Scene
        What was segmented.
    seg : Segmentation
        The result.

    Returns
    -------
    list of Path
        ``labels.png`` for a grid (16 bit, 0 = no label, segments from 1) and ``labels.npy`` for
        a cloud (int32, -1 = no label), ``overlay.png``, ``segmented.ply`` if there is geometry,
        ``weight_curve.png`` and, last, ``result.json``.

    Raises
    ------
    GeohueError
        If the folder cannot be written to, or there are more segments than 16 bits can tell.
    """
    target = Path(folder)
    files: list[Path] = []
    if scene.is_grid:
        if seg.k > _LABEL_LIMIT:
            raise GeohueError(f"{seg.k} segments: labels.png holds at most {_LABEL_LIMIT}")
        files.append(target / "labels.png")
        write_png(files[-1], (seg.labels + 1).astype(np.uint16))
    if scene.depth is None and not (scene.is_grid and not scene.valid.any()):
        files.append(target / "labels.npy")
        with atomic_write(files[-1]) as temporary:
            np.save(temporary, seg.labels)
    files.append(target / "overlay.png")
    write_png(files[-1], picture(scene, seg.labels))
    valid = scene.valid
    if valid.any():
        files.append(target / "segmented.ply")
        write_ply(files[-1], scene.points[valid], scene.colors[valid], seg.labels[valid])
    files.append(target / "weight_curve.png")
    draw_weight_curve(files[-1], seg)
    files.append(target / "result.json")
    with atomic_write(files[-1]) as temporary:
        temporary.write_text(json.dumps(seg.summary(), indent=2) + "\n", encoding="utf-8")
    return files
