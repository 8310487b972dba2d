"""Beyond the paper, on the sample: merged regions, and the points that carry them to the cloud."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geohue.compute.checks import map_offset, without_offset
from geohue.compute.labels import relabel
from geohue.compute.parallel import Workers
from geohue.merge.carry import Examples, carry
from geohue.merge.levels import Detail
from geohue.merge.score import Cues
from geohue.merge.tree import MergeTree
from geohue.prepared import PreparedScene
from geohue.segmentation.merged import MergedDraft, level_of, merge_points
from geohue.segmentation.result import StageClock

Labels = NDArray[np.int32]

_BLOCK = 65_536  # points at a time, for the memory that their neighbours take


@dataclass(frozen=True, slots=True, eq=False)
class MergedRegions:
    """What gives any point of a cloud its region, and the region its segment.

    Attributes
    ----------
    offset : (3,) float64
        Taken off the coordinates of the file (`map_offset` of the sample).
    examples : Examples
        The points of the draft with their regions.
    cues : {"fusion", "color", "geometry"}
        What the regions go by.
    tree : MergeTree
        How the regions merge.
    weight : float
        The paper's lambda of the voter whose maps are most like the segments.
    order : (R,) int32
        The segment of each region.
    """

    offset: NDArray[np.float64]
    examples: Examples
    cues: Cues
    tree: MergeTree
    weight: float
    order: Labels

    def parts(self, xyz: NDArray[np.float64], rgb: NDArray[np.uint8]) -> Labels:
        """Return the region of points, (M, 3) coordinates and colours; -1 without coordinates."""
        points, take = without_offset(xyz, self.offset), self.examples.taker(self.cues)
        index = np.flatnonzero(np.isfinite(points[:, 2]))
        regions = np.full(len(xyz), -1, np.int32)
        for start in range(0, len(index), _BLOCK):
            here = index[start : start + _BLOCK]
            regions[here] = take(points[here], rgb[here])
        return regions


def merge_sample(
    prepared: PreparedScene,
    xyz: NDArray[np.float64],
    k: int | None,
    detail: Detail,
    team: Workers,
    clock: StageClock,
) -> tuple[MergedRegions, Labels]:
    """Merge the regions of a sample as `geohue.segment` does, and keep what carries them.

    Parameters
    ----------
    prepared : PreparedScene
        The sample.
    xyz : (M, 3) float64
        Its coordinates as in the file.
    k : int or None
        Number of segments of the level to take; None for that of `detail`.
    detail : float or str
        Degree of detail (`threshold_of`).
    team : Workers
        Threads to use.
    clock : StageClock
        Times the stages.

    Returns
    -------
    fitted : MergedRegions
        Its segments are numbered by their size in the sample.
    labels : (M,) int32
        The segment of each point of the sample, -1 for those without coordinates.
    """
    draft = merge_points(prepared, k, detail, clock)
    prepared = draft.prepared
    with clock.stage("borders"):
        places = prepared.positions
        full = carry(draft.regions, draft.chosen, places, prepared.scene, team, draft.cues)
    regions, full, tree = _shown(draft, full)
    chosen = level_of(tree, k, detail)
    order = np.empty(int(chosen.max()) + 1, np.int32)
    labels, by_size = relabel(np.append(chosen, np.int32(-1))[full])
    order[by_size] = np.arange(len(by_size), dtype=np.int32)
    scene = prepared.draft
    examples = Examples.of(scene.points, scene.colors, regions, draft.cues)
    offset = map_offset(xyz)
    return MergedRegions(offset, examples, draft.cues, tree, draft.weight, order[chosen]), labels


def _shown(draft: MergedDraft, full: Labels) -> tuple[Labels, Labels, MergeTree]:
    """Leave out regions that no point of the sample has; their examples take the sample's.

    These are examples with others in the same place, which were taken instead.
    """
    kept = np.zeros(draft.tree.n_regions, bool)
    kept[full[full >= 0]] = True
    if kept.all():
        return draft.regions, full, draft.tree
    name = np.append(np.cumsum(kept, dtype=np.int32) - np.int32(1), np.int32(-1))
    regions = np.where(kept[draft.regions], draft.regions, full[draft.prepared.positions])
    return name[regions], name[full], draft.tree.among(kept)
