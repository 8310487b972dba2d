"""Whether a cloud is a thing of thin branching parts, so that its limbs are its segments."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geohue.merge.limbs import Limbs, find_limbs
from geohue.regions.adjacency import adjacent_points, link_pieces
from geohue.scene import Scene

SLIM_LIMB = 3.0
"""A limb so many times as long as it is wide is slim."""

LEAST_SLIM = 0.4
"""Least share of the points in slim limbs."""

LEAST_AGAIN = 0.6
"""Least agreement of the limbs with those found in halves of the points."""


DRAFT = 20_000
"""Points in which limbs are sought."""


@dataclass(frozen=True, slots=True)
class Branching:
    """What speaks for a cloud of thin branching parts.

    Attributes
    ----------
    slim : float
        Share of the points in limbs at least `SLIM_LIMB` times as long as wide. Rooms, statues
        and hills have few: what the sweep finds in them are sectors and rims.
    again : float
        Mean mutual covering of the limbs with those found in four halves of the points. Where a
        scene falls into strips by chance, other points give other strips. 0 if `slim` alone
        decides.
    """

    slim: float
    again: float

    @property
    def is_branching(self) -> bool:
        """Whether both are enough."""
        return self.slim >= LEAST_SLIM and self.again >= LEAST_AGAIN


def branch_labels(
    scene: Scene, rng: np.random.Generator, max_points: int = DRAFT
) -> NDArray[np.int32] | None:
    """Label the limbs of a cloud, if it is a thing of thin branching parts.

    Limbs are sought in a draft; every other point takes the label of the nearest point of it.
    Colour plays no part.

    Parameters
    ----------
    scene : Scene
        A cloud.
    rng : numpy.random.Generator
        The source of chance of the draft.
    max_points : int
        Points of the draft.

    Returns
    -------
    (N,) int32 or None
        Segments from 0, -1 for points without a position; None for any other cloud.

    Examples
    --------
    >>> from geohue.simulate.branching import branching_cloud
    >>> points, truth = branching_cloud("cables", n=2000)
    >>> scene = Scene.from_cloud(points, np.zeros((2000, 3), np.uint8))
    >>> labels = branch_labels(scene, np.random.default_rng(0))
    >>> int(labels.max()), int(truth.max())
    (6, 6)
    """
    from scipy.spatial import cKDTree

    draft = scene.thinning(max_points, rng)
    draft = draft[scene.valid[draft]]
    points = scene.points[draft]
    limbs = find_branches(points, *near_pairs(points))
    if limbs is None:
        return None
    labels = np.full(scene.size, -1, np.int32)
    valid = np.flatnonzero(scene.valid)
    _, nearest = cKDTree(points).query(scene.points[valid])
    labels[valid] = limbs[np.asarray(nearest)]
    return labels


def find_branches(
    points: NDArray[np.floating],
    one: NDArray[np.int64],
    other: NDArray[np.int64],
    spacing: float,
) -> NDArray[np.int32] | None:
    """Label the limbs of points, if they are a thing of thin branching parts.

    Parameters
    ----------
    points : (n, 3) float
        Positions, all finite.
    one, other : (E,) int64
        Pairs of neighbours that connect all points.
    spacing : float
        Median distance of neighbours (`near_pairs`).

    Returns
    -------
    (n,) int32 or None
        Limbs from 0; None for any other cloud.
    """
    limbs = find_limbs(points, one, other, spacing)
    return limbs.labels if branching_evidence(points, limbs).is_branching else None


def near_pairs(
    points: NDArray[np.floating],
) -> tuple[NDArray[np.int64], NDArray[np.int64], float]:
    """Pair the points of a cloud with their neighbours, over small gaps too.

    Parameters
    ----------
    points : (n, 3) float
        Positions, all finite.

    Returns
    -------
    one, other : (E,) int64
        `adjacent_points` and `link_pieces`.
    spacing : float
        Median distance of the pairs of different places, 0 if there is none.

    Examples
    --------
    >>> one, other, spacing = near_pairs(np.array([[0.0, 0, 0], [2, 0, 0]]))
    >>> spacing
    2.0
    """
    scene = Scene.from_cloud(points, np.zeros((len(points), 3), np.uint8))
    one, other = adjacent_points(scene)
    links = link_pieces(scene, one, other)
    one, other = np.concatenate([one, links[0]]), np.concatenate([other, links[1]])
    gap = np.linalg.norm(points[one] - points[other], axis=1)
    apart = gap[gap > 0]  # points in one place say nothing of the others
    return one, other, float(np.median(apart)) if len(apart) else 0.0


def branching_evidence(points: NDArray[np.floating], limbs: Limbs) -> Branching:
    """Say how much a cloud looks like a plant, a tree or a bundle of cables.

    Parameters
    ----------
    points : (n, 3) float
        Positions, all finite.
    limbs : Limbs
        `find_limbs` of them.

    Returns
    -------
    Branching
        Free of chance: the halves are every other point, and every other two, by reach.

    Examples
    --------
    >>> from geohue.simulate.branching import branching_cloud
    >>> points, _ = branching_cloud("cables", n=2000)
    >>> branching_evidence(points, find_limbs(points, *near_pairs(points))).is_branching
    True
    """
    slim = float(limbs.shares[limbs.slimness >= SLIM_LIMB].sum())
    if slim < LEAST_SLIM:
        return Branching(slim, 0.0)
    rank = np.empty(len(points), np.int64)
    rank[np.argsort(limbs.reach, kind="stable")] = np.arange(len(points))
    halves = [(rank >> bit) % 2 == side for bit in (0, 1) for side in (0, 1)]
    return Branching(slim, float(np.mean([_covering(points, limbs, half) for half in halves])))


def _covering(points: NDArray[np.floating], limbs: Limbs, half: NDArray[np.bool_]) -> float:
    """Compare the limbs with those that half of the points have alone."""
    there = points[half]
    alone = find_limbs(there, *near_pairs(there)).labels
    both = limbs.labels[half]
    from geohue.measures import segmentation_covering

    one_way = segmentation_covering(alone, both, ignore=None)
    return (one_way + segmentation_covering(both, alone, ignore=None)) / 2
