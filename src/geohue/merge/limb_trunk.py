"""Where limbs end and the trunk begins, from the paths that lead from the limbs to the centre."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geohue.merge.limb_spans import Spans
from geohue.merge.limb_surface import Surface

Floats = NDArray[np.float64]
Places = NDArray[np.int64]

TOGETHER = 3
"""Limbs whose paths run side by side in a trunk. Two may be leaves that touch."""

BESIDE = 0.75
"""How near each other, in widths of a limb, paths run side by side."""

STUMP_LENGTH = 0.3
"""Longest stump, as a share of the distance from the centre to the farthest tip."""

STUMP_THICK = 1.5
"""Widths of a limb from which on a stump may be of any length: the foot of a tree."""

STUMP_WIDTH = 0.5
"""Least width of a stump, in widths of a limb."""

STUMP_ANGLE = 30.0
"""Most degrees between a stump and the path that goes on from it."""


@dataclass(frozen=True, slots=True, eq=False)
class Paths:
    """The shortest paths from the inner ends of the limbs to a root.

    Attributes
    ----------
    points : (m,) int64
        Points on a path that are in no limb, one path after the other, each from its limb on.
    limbs : (m,) int64
        The limb that the path comes from.
    """

    points: Places
    limbs: Places

    @classmethod
    def to_root(cls, owner: Places, reach: Floats, before: Places) -> Paths:
        """Follow `before`, the next point towards the root, from each limb's nearest point.

        The limb that begins nearest to the root comes last: a point on two paths is its.
        """
        order = np.lexsort((reach, owner))
        order = order[owner[order] >= 0]
        _, first = np.unique(owner[order], return_index=True)
        mouths = order[first]
        points, limbs = [], []
        for mouth in mouths[np.argsort(-reach[mouths], kind="stable")]:
            at = before[mouth]
            while at >= 0:
                if owner[at] < 0:
                    points.append(at)
                    limbs.append(owner[mouth])
                at = before[at]
        return cls(np.array(points, np.int64), np.array(limbs, np.int64))

    def limbs_beside(self, points: Floats, radius: float) -> Places:
        """Count the limbs with a path within a radius of each point of the paths, (m,)."""
        from scipy.spatial import cKDTree

        place = np.arange(len(self.points))
        near = cKDTree(points[self.points]).query_pairs(radius, output_type="ndarray")
        at = np.concatenate([place, near[:, 0], near[:, 1]])
        there = self.limbs[np.concatenate([place, near[:, 1], near[:, 0]])]
        k = int(self.limbs.max(initial=0)) + 1
        return np.bincount(np.unique(at * k + there) // k, minlength=len(place))


def find_trunk(surface: Surface, owner: Places, reach: Floats, before: Places) -> Places:
    """Give the core back to the limbs, as far as it is not trunk.

    Limbs that touch are closed where they do, far out, and what lies further in is core. But each
    has its own path inwards: a path is trunk where `TOGETHER` limbs have one within `BESIDE`
    widths of it. Every point of the core then goes to the nearest path or limb. A path may take a
    short cut through the limb beside it: then the inner end of its own goes half to the other.

    Paths lead to the end of the stump (`find_stump`) if there is one, so that a stem carries all
    its leaves along its whole length; else to the centre.

    Parameters
    ----------
    surface : Surface
        A connected piece of a cloud, n points.
    owner : (n,) int64
        The limb of each point, -1 for the core; at least one limb.
    reach : (n,) float64
        Length of the shortest path to the centre.
    before : (n,) int64
        The next point on that path, negative at the centre.

    Returns
    -------
    (n,) int64
        The limb of each point, -1 for the trunk.
    """
    points = surface.points
    spans = Spans.of(points, owner, reach)
    paths = Paths.to_root(owner, reach, before)
    roots = np.array([reach.argmin()])
    stump = find_stump(points, owner, reach, paths, spans)
    if stump >= 0:
        roots = np.flatnonzero(owner == stump)
        owner = np.where(owner == stump, -1, owner)
        end = int(roots[reach[roots].argmax()])
        reach, before = surface.paths(end)
        paths = Paths.to_root(owner, reach, before)
    beside = paths.limbs_beside(points, BESIDE * float(np.median(spans.widths)))
    known = owner.copy()
    alone = beside < TOGETHER
    known[paths.points[alone]] = paths.limbs[alone]
    trunk = np.append(paths.points[~alone], roots)
    known[trunk] = -1
    seeds = np.union1d(np.flatnonzero(known >= 0), trunk)
    return np.asarray(known[surface.nearest(seeds)])


def find_stump(points: Floats, owner: Places, reach: Floats, paths: Paths, spans: Spans) -> int:
    """Find the limb that is the trunk's own end, -1 for none.

    The centre divides a stem, so that its lower end comes out as a limb. It is short or clearly
    thicker than a limb, not much thinner in any case, and goes straight on from the trunk; the
    shortest that is all of this is taken.
    """
    usual = float(np.median(spans.widths))
    short = spans.lengths <= STUMP_LENGTH * reach.max()
    sturdy = spans.widths >= np.where(short, STUMP_WIDTH, STUMP_THICK) * usual
    for limb in np.argsort(spans.lengths, kind="stable"):
        inwards = paths.points[paths.limbs == limb]
        if not sturdy[limb] or len(inwards) == 0:
            continue
        inside = np.flatnonzero(owner == limb)
        mouth = points[inside[reach[inside] <= spans.nearest[limb] + usual / 2]].mean(axis=0)
        further = inwards[np.abs(spans.nearest[limb] - 2 * usual - reach[inwards]).argmin()]
        out = points[inside].mean(axis=0) - mouth
        on = mouth - points[further]
        if out @ on > np.cos(np.radians(STUMP_ANGLE)) * np.linalg.norm(out) * np.linalg.norm(on):
            return int(limb)
    return -1
