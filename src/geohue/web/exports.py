"""What can be taken home: the segments as the page shows them, also after corrections."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.results.coco import coco
from geohue.results.las import write_las
from geohue.results.ply import write_ply
from geohue.results.png import write_png
from geohue.web.report import report
from geohue.web.taken import Taken

Labels = NDArray[np.int32]


def _labels(file: Path, what: Taken) -> None:
    if not what.scene.is_grid:
        raise GeohueError("labels.png needs an image: take labels.npy or PLY of a cloud")
    write_png(file, (what.labels + 1).astype(np.uint16))


def _npy(file: Path, what: Taken) -> None:
    np.save(file, what.labels)


def _points(what: Taken) -> tuple[NDArray[np.float32], NDArray[np.uint8], Labels]:
    known = np.isfinite(what.scene.points[..., 2])
    if not known.any():
        raise GeohueError("the scene has no geometry: take labels or COCO")
    return what.scene.points[known], what.scene.colors[known], what.labels[known]


def _ply(file: Path, what: Taken) -> None:
    write_ply(file, *_points(what))


def _las(file: Path, what: Taken) -> None:
    write_las(file, *_points(what))


def _coco(file: Path, what: Taken) -> None:
    if not what.scene.is_grid:
        raise GeohueError("COCO needs an image: take PLY or LAS of a cloud")
    content = coco(what.labels)
    for annotation in content["annotations"]:
        name = what.names.get(annotation["id"] - 1)
        if name is not None:
            annotation["name"] = name
    file.write_text(json.dumps(content), encoding="utf-8")


def _json(file: Path, what: Taken) -> None:
    content = {"result": what.seg.summary(), "segments": what.table}
    file.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")


def _report(file: Path, what: Taken) -> None:
    file.write_text(report(what), encoding="utf-8")


@dataclass(frozen=True, slots=True)
class Format:
    """A file that can be taken home.

    Attributes
    ----------
    file : str
        Its name.
    media_type : str
    write : callable
        Writes it.
    """

    file: str
    media_type: str
    write: Callable[[Path, Taken], None]


FORMATS: dict[str, Format] = {
    "labels": Format("labels.png", "image/png", _labels),
    "npy": Format("labels.npy", "application/octet-stream", _npy),
    "ply": Format("segmented.ply", "application/octet-stream", _ply),
    "las": Format("segmented.las", "application/octet-stream", _las),
    "coco": Format("coco.json", "application/json", _coco),
    "json": Format("segments.json", "application/json", _json),
    "report": Format("report.html", "text/html; charset=utf-8", _report),
}
"""The exports by name."""
