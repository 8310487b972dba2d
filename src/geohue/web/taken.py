"""A segmentation with the corrections that were made on the page."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.scene import Scene
from geohue.segmentation.result import Segmentation
from geohue.web.views import describe_regions, finest

Labels = NDArray[np.int32]

LONGEST_NAME = 80
"""Characters of a segment's name."""


@dataclass(frozen=True, slots=True, eq=False)
class Taken:
    """A segmentation as it is taken home.

    Attributes
    ----------
    scene : Scene
    seg : Segmentation
        As it was found.
    labels : int32, shape of the scene
        As it is now: from 0, -1 = none.
    names : dict of int to str
        Names that segments were given.
    """

    scene: Scene
    seg: Segmentation
    labels: Labels
    names: Mapping[int, str]

    @property
    def table(self) -> list[dict[str, Any]]:
        """Name, size, mean colour and extent of each segment that has points."""
        n = int(self.labels.max(initial=-1)) + 1
        facts = describe_regions(self.scene, self.labels, n)
        columns = zip(*(facts[name] for name in ("size", "color", "low", "high")), strict=True)
        rows = [
            {"label": i, "name": self.names.get(i), "size": size, "mean_color": color}
            | ({} if low is None else {"minimum": low, "maximum": high})
            for i, (size, color, low, high) in enumerate(columns)
        ]
        return [row for row in rows if row["size"]]


def taken(
    scene: Scene, seg: Segmentation, segment_of: object = None, names: object = None
) -> Taken:
    """Apply the corrections of a request to a segmentation.

    Parameters
    ----------
    scene : Scene
    seg : Segmentation
    segment_of : list of int, optional
        The segment of each finest region, from 0; -1 for none. None leaves the segments as found.
    names : mapping of str to str, optional
        Names of segments, by their numbers as text.

    Returns
    -------
    Taken

    Raises
    ------
    GeohueError
        For corrections that do not fit the segmentation.
    """
    regions, tree = finest(seg)
    labels = seg.labels
    if segment_of is not None:
        table = _checked(segment_of, tree.n_regions)
        labels = np.append(table, np.int32(-1))[regions]
    return Taken(scene, seg, labels, _checked_names(names))


def _checked(segment_of: object, n: int) -> Labels:
    if not isinstance(segment_of, list) or len(segment_of) != n:
        raise GeohueError(f"segment_of: expected a list of {n} numbers, one a region")
    whole = all(isinstance(s, int) and not isinstance(s, bool) for s in segment_of)
    if not whole or not all(-1 <= s < n for s in segment_of):
        raise GeohueError(f"segment_of: expected whole numbers from -1 to {n - 1}")
    return np.array(segment_of, np.int32)


def _checked_names(names: object) -> dict[int, str]:
    if names is None:
        return {}
    if not isinstance(names, Mapping) or len(names) > 65535:
        raise GeohueError("names: expected an object from numbers of segments to texts")
    for key, name in names.items():
        fits = isinstance(key, str) and key.isdecimal() and len(key) <= 5
        if not fits or not isinstance(name, str) or len(name) > LONGEST_NAME:
            raise GeohueError(
                f"names: expected texts of at most {LONGEST_NAME} characters by numbers of segments"
            )
    return {int(key): name for key, name in names.items()}
