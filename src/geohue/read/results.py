"""A segmentation from the folder that it was written to."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.read.files import broken, read_bytes, reason
from geohue.read.labels import read_segments
from geohue.read.levels import read_levels
from geohue.segmentation.result import Segmentation
from geohue.segmentation.words import weight_from

RESULT = "result.json"
"""The file that says what the others in a folder are."""

_NEEDED = ("k", "method", "preset", "cues", "seed", "weight", "quality", "weight_curve")
_MOST = 1 << 28


def read_segmentation(folder: str | Path) -> Segmentation:
    """Read what `Segmentation.save` wrote; see `Segmentation.load`."""
    here = Path(folder)
    if not here.is_dir():
        raise broken(folder, "is no folder; give the one that a segmentation was written to")
    file = here / RESULT
    content = _content(file)
    labels = read_segments(labels_of(here))
    levels = read_levels(here / "levels.npz") if (here / "levels.npz").exists() else None
    found = int(labels.max(initial=-1)) + 1
    if levels is not None and levels.regions.shape != labels.shape:
        raise broken(here / "levels.npz", f"is of another scene than the labels in {folder}")
    try:
        seg = _segmentation(content, labels)
    except (KeyError, TypeError, ValueError) as error:
        raise broken(file, f"is no summary of a segmentation ({reason(error)})") from error
    if seg.k != found:
        raise broken(file, f"says {seg.k} segments, but the labels have {found}; write it again")
    if levels is None:
        return seg
    from dataclasses import replace

    return replace(seg, levels=levels)


def labels_of(folder: Path) -> Path:
    """Return the file of the labels in a folder of results.

    Raises
    ------
    GeohueError
        If there is none.
    """
    for name in ("labels.png", "labels.npy"):
        if (folder / name).is_file():
            return folder / name
    raise broken(folder, "has neither labels.png nor labels.npy; give a folder of results")


def _content(file: Path) -> dict[str, Any]:
    try:
        content = json.loads(read_bytes(file, _MOST))
    except GeohueError:
        raise
    except ValueError as error:
        raise broken(file, f"is no whole JSON file ({reason(error)}); write it again") from error
    missing = [n for n in _NEEDED if n not in content] if isinstance(content, dict) else _NEEDED
    if missing:
        raise broken(file, f"is no summary of a segmentation (no {', '.join(missing[:3])})")
    return dict(content)


def _segmentation(content: dict[str, Any], labels: NDArray[np.int32]) -> Segmentation:
    words = content.get("weight_in_words", "")
    return Segmentation(
        labels,
        int(content["k"]),
        weight_from(content["weight"], str(words)),
        None if content["quality"] is None else float(content["quality"]),
        [(float(weight), float(value)) for weight, value in content["weight_curve"]],
        str(content["method"]),
        str(content["preset"]),
        str(content["cues"]),
        int(content["seed"]),
        {str(stage): float(s) for stage, s in content.get("timings_s", {}).items()},
        tuple(str(text) for text in content.get("warnings", ())),
        detail=content.get("detail"),
        merged=bool(content.get("merged", content.get("levels") is not None)),
        border_votes=[(int(a), int(b), float(s)) for a, b, s in content.get("border_votes", ())],
    )
