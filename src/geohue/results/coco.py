"""Segments as COCO annotations, their masks run-length encoded."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.results.atomic import atomic_write


def write_coco(path: str | Path, labels: NDArray[np.int32], file_name: str = "color.png") -> None:
    """Write the segments of an image as a COCO instance file.

    Parameters
    ----------
    path : path-like
        The JSON file.
    labels : (H, W) int32
        Segments from 0; -1 for none.
    file_name : str
        What the file says the picture is called.

    Raises
    ------
    GeohueError
        If the file cannot be written.
    """
    with atomic_write(path) as temporary:
        content = json.dumps(coco(labels, file_name), indent=1)
        temporary.write_text(content + "\n", encoding="utf-8")


def coco(labels: NDArray[np.int32], file_name: str = "color.png") -> dict[str, Any]:
    """Return the content of a COCO instance file: an annotation a segment, all of one category.

    Examples
    --------
    >>> coco(np.array([[0, 1]], np.int32))["annotations"][0]["bbox"]
    [0, 0, 1, 1]
    """
    height, width = labels.shape
    found = np.unique(labels[labels >= 0])
    return {
        "info": {"description": "geohue segments"},
        "images": [{"id": 1, "file_name": file_name, "width": width, "height": height}],
        "categories": [{"id": 1, "name": "segment"}],
        "annotations": [_annotation(labels == label, int(label)) for label in found],
    }


def _annotation(mask: NDArray[np.bool_], label: int) -> dict[str, Any]:
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    left, top = int(columns[0]), int(rows[0])
    return {
        "id": label + 1,
        "image_id": 1,
        "category_id": 1,
        "iscrowd": 0,
        "area": int(mask.sum()),
        "bbox": [left, top, int(columns[-1]) - left + 1, int(rows[-1]) - top + 1],
        "segmentation": {"size": list(mask.shape), "counts": encode_rle(mask)},
    }


def encode_rle(mask: NDArray[np.bool_]) -> str:
    """Encode a mask as COCO's compressed run lengths.

    Runs go down the columns and begin with the zeros. From the fourth on each is written as its
    difference from the run two before, in groups of five bits, the lowest first.

    Parameters
    ----------
    mask : (H, W) bool

    Returns
    -------
    str

    Examples
    --------
    >>> encode_rle(np.array([[False, True], [False, True]]))
    '22'
    """
    flat = np.concatenate([[False], mask.ravel(order="F"), [False]])
    ends = np.flatnonzero(flat[1:] != flat[:-1])
    if mask.size and mask.ravel(order="F")[-1]:
        ends = ends[:-1]
    runs = np.diff(np.concatenate([[0], ends, [mask.size]])).tolist()
    text = []
    for i, run in enumerate(runs):
        text.append(_signed(run - runs[i - 2] if i > 2 else run))
    return "".join(text)


def _signed(value: int) -> str:
    """Write a number as characters of five bits and a mark for "more follows"."""
    characters = []
    more = True
    while more:
        bits = value & 31
        value >>= 5
        more = not ((value == 0 and not bits & 16) or (value == -1 and bits & 16))
        characters.append(chr((bits | 32 if more else bits) + 48))
    return "".join(characters)
