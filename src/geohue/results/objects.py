"""The objects of a scene as files: a table, and features with outlines."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.objects.segments import Segments, table
from geohue.results.atomic import atomic_write


def write_table(path: str | Path, segments: Segments) -> None:
    """Write the measures of segments as comma-separated values, a row a segment.

    Raises
    ------
    GeohueError
        If the file cannot be written.
    """
    with atomic_write(path) as temporary:
        temporary.write_text(csv_text(table(segments)), encoding="utf-8")


def write_features(path: str | Path, segments: Segments) -> None:
    """Write `features` as JSON.

    Raises
    ------
    GeohueError
        If the file cannot be written.
    """
    with atomic_write(path) as temporary:
        text = json.dumps(features(segments), indent=1, allow_nan=False)
        temporary.write_text(text + "\n", encoding="utf-8")


def csv_text(columns: dict[str, NDArray[Any]]) -> str:
    """Return columns as comma-separated values; empty where a number is not known.

    Examples
    --------
    >>> print(csv_text({"id": np.array([0, 1]), "x": np.array([0.5, np.nan])}), end="")
    id,x
    0,0.5
    1,
    """
    rows = zip(*(map(_cell, column.tolist()) for column in columns.values()), strict=True)
    return "\n".join(",".join(row) for row in [tuple(columns), *rows]) + "\n"


def features(segments: Segments, columns: dict[str, NDArray[Any]] | None = None) -> dict[str, Any]:
    """Return the objects as a GeoJSON-like feature collection.

    The geometry of a segment of an image is its outline in pixels, a MultiPolygon along the sides
    of the pixels: (0, 0) is the upper left corner of the first one. That of a segment of a cloud is
    its centroid, a Point. ``bbox`` is the axis-aligned box in space, and the other measures of
    `geohue.objects.segments.table` are the properties; null where one is not known.

    Parameters
    ----------
    segments : Segments
    columns : dict of arrays, optional
        Their table, if it is there already.

    Returns
    -------
    dict
        Ready for JSON.
    """
    columns = table(segments) if columns is None else columns
    names = list(columns)
    found = []
    for row in zip(*(column.tolist() for column in columns.values()), strict=True):
        known = {name: _known(value) for name, value in zip(names, row, strict=True)}
        box = [known[f"{end}_{axis}"] for end in ("low", "high") for axis in "xyz"]
        feature: dict[str, Any] = {"type": "Feature", "id": known["id"]}
        if None not in box:
            feature["bbox"] = box
        neighbours = segments.measured.neighbours.of(known["id"])
        feature["geometry"] = _geometry(segments, known)
        feature["properties"] = known | {
            "borders": [{"segment": other, "length": n} for other, n in neighbours.items()]
        }
        found.append(feature)
    return {"type": "FeatureCollection", "features": found}


def _geometry(segments: Segments, known: dict[str, Any]) -> dict[str, Any] | None:
    if not segments.measured.scene.is_grid:
        place = [known[axis] for axis in "xyz"]
        return None if None in place else {"type": "Point", "coordinates": place}
    if known["area"] == 0:
        return None
    top, left = known["top"], known["left"]
    rows, cols = slice(top, known["bottom"] + 1), slice(left, known["right"] + 1)
    mask = segments.measured.labels[rows, cols] == known["id"]
    return {"type": "MultiPolygon", "coordinates": outlines(mask, left, top)}


def outlines(mask: NDArray[np.bool_], left: int = 0, top: int = 0) -> list[list[list[list[int]]]]:
    """Return the outlines of a mask along the sides of its pixels: polygons of closed rings.

    The first ring of each polygon is the outer one, those after it are holes.

    Examples
    --------
    >>> outlines(np.array([[True, True]]))
    [[[[0, 0], [0, 1], [2, 1], [2, 0], [0, 0]]]]
    """
    import cv2

    # Each pixel becomes 2 x 2, so that the outlines of its centres are those of its sides: twice
    # the coordinates, less one at the right and the lower side.
    double = np.ascontiguousarray(mask.astype(np.uint8).repeat(2, 0).repeat(2, 1))
    rings, tree = cv2.findContours(double, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_SIMPLE)
    polygons: list[list[list[list[int]]]] = []
    home: dict[int, int] = {}
    for at, (ring, (_, _, _, parent)) in enumerate(zip(rings, tree[0], strict=True)):
        if parent < 0:
            home[at] = len(polygons)
            polygons.append([_ring(ring[:, 0], left, top)])
    for ring, (_, _, _, parent) in zip(rings, tree[0], strict=True):
        if parent >= 0:
            polygons[home[parent]].append(_ring(ring[:, 0], left, top))
    return polygons


def _ring(ring: NDArray[Any], left: int, top: int) -> list[list[int]]:
    corners = (ring + 1) // 2 + np.array([left, top])
    corners = corners[(corners != np.roll(corners, 1, axis=0)).any(axis=1)]
    return [*corners.tolist(), corners[0].tolist()]


def _known(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _cell(value: Any) -> str:
    if isinstance(value, float):
        return format(value, ".9g") if math.isfinite(value) else ""
    return str(int(value)) if isinstance(value, bool) else str(value)
