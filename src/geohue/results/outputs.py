"""A segmentation as files: what ``-o DIR`` receives."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from geohue.errors import GeohueError
from geohue.read.extras import optional
from geohue.results.borders import border_picture
from geohue.results.curve import draw_weight_curve
from geohue.results.folder import SEGMENTATION, whole_folder
from geohue.results.levels import write_levels
from geohue.results.numbering import MOST_IN_PNG, numbering
from geohue.results.picture import paint, picture
from geohue.results.places import places_of
from geohue.results.ply import write_ply
from geohue.results.png import write_png
from geohue.scene import Scene
from geohue.segmentation.result import Segmentation

FORMATS = ("ply", "pcd", "las", "laz", "coco", "segments")
"""What can be asked for: ``segmented.ply`` (a usual file, unless lean), ``segmented.pcd``,
``segmented.las`` or ``.laz`` with the extra dimension ``segment_id``, ``coco.json``, and
``segments.png``, the labels in colours."""


def write_results(
    folder: str | Path,
    scene: Scene,
    seg: Segmentation,
    formats: Sequence[str] = (),
    *,
    lean: bool = False,
    overwrite: bool = False,
) -> list[Path]:
    """Write labels, pictures, the labelled cloud and the summary, all of them or nothing.

    Parameters
    ----------
    folder : str or Path
        Made if it does not exist; an earlier result in it is replaced whole (`whole_folder`).
    scene : Scene
        What was segmented.
    seg : Segmentation
        The result.
    formats : sequence of str
        More files: any of `FORMATS`.
    lean : bool
        Leave out the pictures, ``levels.npz`` and, if it is not among `formats`,
        ``segmented.ply``.
    overwrite : bool
        Whether to write into a folder that has other files than an earlier result.

    Returns
    -------
    list of Path
        ``labels.png`` for a grid (16 bit, 0 = no label, segments from 1) and ``labels.npy`` for
        a cloud or more than 65,535 segments (int32, -1 = no label), ``overlay.png``,
        ``segmented.ply`` if there is geometry, ``levels.npz`` (`write_levels`) where regions were
        merged, ``borders.png`` (`paint_borders`) where they were or cuts voted, for a grid,
        ``weight_curve.png`` where several weights were tried, those of `formats` and, last,
        ``result.json``.

    Raises
    ------
    GeohueError
        If the folder cannot be written to or has other files, or a format is unknown, does not fit
        the scene or needs a library that is missing.
    """
    target = Path(folder)
    extra = _writers(target, scene, seg, formats)
    with whole_folder(folder, overwrite=overwrite) as new:
        names = _write_labels(new, scene, seg)
        if not lean:
            names += _write_views(new, scene, seg)
        for name, write in extra:
            if name not in names:
                write(new / name)
                names.append(name)
        names.append(SEGMENTATION.mark)
        content = seg.summary() | {"numbering": numbering(names)}
        text = json.dumps(content, indent=2) + "\n"
        (new / names[-1]).write_text(text, encoding="utf-8")
    return [target / name for name in names]


def _write_labels(target: Path, scene: Scene, seg: Segmentation) -> list[str]:
    names = []
    if scene.is_grid and seg.k <= MOST_IN_PNG:
        names.append("labels.png")
        write_png(target / names[-1], (seg.labels + 1).astype(np.uint16))
    organised = scene.is_grid and scene.depth is None and scene.valid.any()
    if not names or organised:
        names.append("labels.npy")
        np.save(target / names[-1], seg.labels)
    return names


def _write_views(target: Path, scene: Scene, seg: Segmentation) -> list[str]:
    """Write what is there to be looked at, and the levels."""
    names = ["overlay.png"]
    write_png(target / names[-1], picture(scene, seg.labels))
    if np.isfinite(scene.points[..., 2]).any():
        names.append("segmented.ply")
        _write_ply(target / names[-1], scene, seg)
    borders = border_picture(scene, seg)
    if borders is not None:
        names.append("borders.png")
        write_png(target / names[-1], borders)
    if seg.levels is not None:
        names.append("levels.npz")
        write_levels(target / names[-1], seg.levels)
    if len(seg.weight_curve) > 1:
        names.append("weight_curve.png")
        draw_weight_curve(target / names[-1], seg)
    return names


_Writer = Callable[[Path], None]


def _writers(
    target: Path, scene: Scene, seg: Segmentation, formats: Sequence[str]
) -> list[tuple[str, _Writer]]:
    """Return name and writer of each file of `formats`, after all that could be wrong."""
    unknown = [name for name in formats if name not in FORMATS]
    if unknown:
        raise GeohueError(f"format {unknown[0]!r}: choose among {', '.join(FORMATS)}")
    writers: dict[str, tuple[str, _Writer]] = {}
    if scene.is_grid:
        writers["coco"] = ("coco.json", lambda file: _write_coco(file, seg))
        writers["segments"] = ("segments.png", lambda file: write_png(file, paint(seg.labels)))
    if np.isfinite(scene.points[..., 2]).any():
        writers["ply"] = ("segmented.ply", lambda file: _write_ply(file, scene, seg))
        writers["pcd"] = ("segmented.pcd", lambda file: _write_pcd(file, scene, seg))
        writers["las"] = ("segmented.las", lambda file: _write_las(file, scene, seg))
        writers["laz"] = ("segmented.laz", lambda file: _write_las(file, scene, seg))
    wanted = list(dict.fromkeys(formats))
    missing = [name for name in wanted if name not in writers]
    if missing:
        what = "a grid of pixels" if scene.valid.any() else "geometry"
        raise GeohueError(f"format {missing[0]!r} needs {what}, which this scene has not")
    for name in wanted:
        if name in ("las", "laz"):
            optional("laspy", "clouds", target / f"segmented.{name}")
        if name == "laz":
            optional("lazrs", "clouds", target / "segmented.laz")
    return [writers[name] for name in wanted]


def _write_coco(file: Path, seg: Segmentation) -> None:
    from geohue.results.coco import write_coco

    write_coco(file, seg.labels)


def _write_pcd(file: Path, scene: Scene, seg: Segmentation) -> None:
    """Write all points of a grid in their places, and those of a cloud that have a position."""
    from geohue.results.pcd import write_pcd

    use: Any = ... if scene.is_grid else np.isfinite(scene.points[..., 2])
    write_pcd(file, scene.points[use], scene.colors[use], seg.labels[use])


def _write_ply(file: Path, scene: Scene, seg: Segmentation) -> None:
    """Write a cloud as it is in its file, and the points of a grid that have a position."""
    use: Any = np.isfinite(scene.points[..., 2]) if scene.is_grid else ...
    points = places_of(scene)
    is_double = points.dtype == np.float64
    write_ply(file, points[use], scene.colors[use], seg.labels[use], double=is_double)


def _write_las(file: Path, scene: Scene, seg: Segmentation) -> None:
    """Add the segments to the LAS file that the scene came from, or make a new one."""
    from geohue.results.las import write_las
    from geohue.results.las_copy import is_las, write_las_like

    if scene.source is not None and is_las(scene.source):
        write_las_like(file, scene.source, seg.labels)
        return
    known = np.isfinite(scene.points[..., 2])
    write_las(file, places_of(scene)[known], scene.colors[known], seg.labels[known])
