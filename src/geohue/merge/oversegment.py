"""The fine regions that merging begins with: Felzenszwalb's rule on all the evidence."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geohue.baselines.graph import merge_graph
from geohue.merge.evidence import Evidence

GAP_WEIGHT = 1.5
"""Lab units that a typical gap counts."""

GAP_MOST = 20.0
"""Gaps beyond so many typical ones count alike."""

VOTE_WEIGHT = 40.0
"""Lab units that a border which all cuts draw counts."""

K, SMALLEST = 20.0, 12
"""Felzenszwalb's k in Lab units, and the least number of points."""


def oversegment(
    evidence: Evidence, lab: NDArray[np.float64], k: float = K, smallest: int = SMALLEST
) -> NDArray[np.int32]:
    """Split the points into some hundred regions that follow colour, geometry and votes.

    The rule of Felzenszwalb and Huttenlocher (2004) on the pairs of neighbours, with the edge
    weight ``sqrt(|dLab|^2 + (1.5 gap)^2 + (40 share)^2)``.

    Parameters
    ----------
    evidence : Evidence
        Points and pairs of neighbours.
    lab : (n, 3) float64
        CIELab with the noise of single pixels blurred.
    k, smallest : float, int
        Larger for larger regions.

    Returns
    -------
    (n,) int32
        Regions 0..R-1 in the order of their first points.
    """
    color = ((lab[evidence.one] - lab[evidence.other]) ** 2).sum(axis=1)
    gap = GAP_WEIGHT * np.minimum(evidence.gap, GAP_MOST)
    weight = np.sqrt(color + gap**2 + (VOTE_WEIGHT * evidence.share) ** 2)
    edges = np.stack([evidence.one, evidence.other], axis=1).astype(np.int32)
    return merge_graph(len(lab), edges, weight.astype(np.float32), k, smallest)
