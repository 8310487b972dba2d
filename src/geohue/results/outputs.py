"""A segmentation as files: what ``-o DIR`` receives."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.compute.parallel import cores
from geohue.errors import GeohueError
from geohue.read.extras import optional
from geohue.results.atomic import atomic_write
from geohue.results.borders import paint_borders
from geohue.results.curve import draw_weight_curve
from geohue.results.levels import write_levels
from geohue.results.picture import paint, picture
from geohue.results.ply import write_ply
from geohue.results.png import write_png
from geohue.scene import Scene
from geohue.segmentation.result import Segmentation

_LABEL_LIMIT = np.iinfo(np.uint16).max - 1


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
) -> list[Path]:
    """Write labels, pictures, the labelled cloud and the summary.

    Parameters
    ----------
    folder : str or Path
        Made if it does not exist; files of an earlier run are replaced, each in one step.
    scene : Scene
        What was segmented.
    seg : Segmentation
        The result.
    formats : sequence of str
        More files: any of `FORMATS`.
    lean : bool
        Leave out the pictures, ``levels.npz`` and, if it is not among `formats`,
        ``segmented.ply``.

    Returns
    -------
    list of Path
        ``labels.png`` for a grid (16 bit, 0 = no label, segments from 1) and ``labels.npy`` for
        a cloud (int32, -1 = no label), ``overlay.png``, ``segmented.ply`` if there is geometry,
        ``levels.npz`` (`write_levels`) and, for a grid, ``borders.png`` (`paint_borders`) where
        regions were merged, ``weight_curve.png`` where weights were tried, those of `formats` and,
        last, ``result.json``.

    Raises
    ------
    GeohueError
        If the folder cannot be written to, there are more segments than 16 bits can tell, or a
        format is unknown, does not fit the scene or needs a library that is missing.
    """
    target = Path(folder)
    extra = _writers(target, scene, seg, formats)
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
    if not lean:
        files += _write_views(target, scene, seg)
    for file, write in extra:
        if file not in files:
            write(file)
            files.append(file)
    files.append(target / "result.json")
    with atomic_write(files[-1]) as temporary:
        temporary.write_text(json.dumps(seg.summary(), indent=2) + "\n", encoding="utf-8")
    return files


def _write_views(target: Path, scene: Scene, seg: Segmentation) -> list[Path]:
    """Write what is there to be looked at, and the levels."""
    levels, known = seg.levels, np.isfinite(scene.points[..., 2])
    tasks: dict[str, _Writer] = {
        "overlay.png": lambda file: write_png(file, picture(scene, seg.labels))
    }
    if known.any():
        tasks["segmented.ply"] = lambda file: write_ply(
            file, scene.points[known], scene.colors[known], seg.labels[known]
        )
    if levels is not None:
        if scene.is_grid:
            tasks["borders.png"] = lambda file: write_png(file, paint_borders(scene.colors, levels))
        tasks["levels.npz"] = lambda file: write_levels(file, levels)
    files = [target / name for name in tasks]
    # Side by side: most of the time is coding and writing without Python's lock.
    with ThreadPoolExecutor(cores()) as pool:
        list(pool.map(lambda file: tasks[file.name](file), files))
    if seg.weight_curve:
        files.append(target / "weight_curve.png")
        draw_weight_curve(files[-1], seg)
    return files


_Writer = Callable[[Path], None]


def _writers(
    target: Path, scene: Scene, seg: Segmentation, formats: Sequence[str]
) -> list[tuple[Path, _Writer]]:
    """Return each file of `formats` with what writes it, after all that could be wrong."""
    unknown = [name for name in formats if name not in FORMATS]
    if unknown:
        raise GeohueError(f"format {unknown[0]!r}: choose among {', '.join(FORMATS)}")
    if not formats:
        return []
    known = np.isfinite(scene.points[..., 2])
    writers: dict[str, tuple[str, _Writer]] = {}
    if scene.is_grid:
        writers["coco"] = ("coco.json", lambda file: _write_coco(file, seg))
        writers["segments"] = ("segments.png", lambda file: write_png(file, paint(seg.labels)))
    if known.any():
        columns = scene.points[known], scene.colors[known], seg.labels[known]
        writers["ply"] = ("segmented.ply", lambda file: write_ply(file, *columns))
        writers["pcd"] = ("segmented.pcd", lambda file: _write_pcd(file, scene, seg))
        writers["las"] = ("segmented.las", lambda file: _write_las(file, *columns))
        writers["laz"] = ("segmented.laz", lambda file: _write_las(file, *columns))
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
    return [(target / writers[name][0], writers[name][1]) for name in wanted]


def _write_coco(file: Path, seg: Segmentation) -> None:
    from geohue.results.coco import write_coco

    write_coco(file, seg.labels)


def _write_pcd(file: Path, scene: Scene, seg: Segmentation) -> None:
    """Write all points of a grid in their places, and those of a cloud that have a position."""
    from geohue.results.pcd import write_pcd

    use: Any = ... if scene.is_grid else np.isfinite(scene.points[..., 2])
    write_pcd(file, scene.points[use], scene.colors[use], seg.labels[use])


def _write_las(
    file: Path, points: NDArray[np.float32], colors: NDArray[np.uint8], labels: NDArray[np.int32]
) -> None:
    from geohue.results.las import write_las

    write_las(file, points, colors, labels)
