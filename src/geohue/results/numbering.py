"""How segments are numbered in each file: the library counts from 0, label images from 1."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

MOST_IN_PNG = 2**16 - 1
"""Segments that 16 bits tell apart, 0 being none."""

_FROM_0: dict[str, Any] = {"none": -1, "first": 0}

_NUMBERING: dict[str, dict[str, Any]] = {
    "labels.png": {"none": 0, "first": 1},
    "labels.npy": _FROM_0,
    "segmented.ply": {"field": "label", **_FROM_0},
    "segmented.pcd": {"field": "label", **_FROM_0},
    "segmented.las": {"field": "segment_id", **_FROM_0},
    "segmented.laz": {"field": "segment_id", **_FROM_0},
    "coco.json": {"field": "annotations.id", "none": None, "first": 1},
}


def numbering(names: Iterable[str]) -> dict[str, dict[str, Any]]:
    """Return, of each file with labels, what stands for none and for the first segment.

    Examples
    --------
    >>> numbering(["labels.png", "overlay.png"])
    {'labels.png': {'none': 0, 'first': 1}}
    """
    return {name: dict(_NUMBERING[name]) for name in names if name in _NUMBERING}
