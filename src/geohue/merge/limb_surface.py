"""Distances along the surface of a cloud: shortest paths over pairs of neighbours."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from geohue.regions.groups import join_pairs

if TYPE_CHECKING:
    from scipy.sparse import csr_array


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """Points of a cloud and the distances of neighbours.

    Attributes
    ----------
    points : (n, 3) float64
        Positions.
    graph : (n, n) csr_array
        The distance of each two neighbours, in both directions.
    """

    points: NDArray[np.float64]
    graph: csr_array[np.float64, tuple[int, int]]

    @classmethod
    def of(
        cls,
        points: NDArray[np.float64],
        one: NDArray[np.int64],
        other: NDArray[np.int64],
        most: float,
    ) -> Surface:
        """Connect pairs of points at most so far apart; they may come twice and in any direction.

        Examples
        --------
        >>> line = np.array([[0.0, 0, 0], [1, 0, 0], [3, 0, 0], [9, 0, 0]])
        >>> surface = Surface.of(line, np.array([0, 1, 1, 2]), np.array([1, 0, 2, 3]), most=5)
        >>> surface.distances(0).tolist(), surface.pieces().tolist()
        ([0.0, 1.0, 3.0, inf], [0, 0, 0, 1])
        """
        from scipy.sparse import coo_array  # not what every cut should wait for

        n = len(points)
        pairs = np.unique(np.minimum(one, other) * n + np.maximum(one, other))
        one, other = pairs // max(n, 1), pairs % max(n, 1)
        gap = np.linalg.norm(points[one] - points[other], axis=1)
        near = (gap <= most) & (one != other)
        one, other, gap = one[near], other[near], gap[near]
        ends = np.concatenate([one, other]), np.concatenate([other, one])
        graph = coo_array((np.concatenate([gap, gap]), ends), shape=(n, n)).tocsr()
        return cls(points, graph)

    def part(self, index: NDArray[np.int64]) -> Surface:
        """Return the surface of some of the points."""
        return Surface(self.points[index], self.graph[index][:, index])

    def pieces(self) -> NDArray[np.int32]:
        """Number the connected pieces, (n,)."""
        n = len(self.points)
        one = np.repeat(np.arange(n), np.diff(self.graph.indptr))
        return join_pairs(one, self.graph.indices.astype(np.int64), n)

    def distances(self, source: int) -> NDArray[np.float64]:
        """Return the length of each point's shortest path to one point, (n,)."""
        return self.paths(source)[0]

    def paths(self, source: int) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """Return the lengths, and the next point on each path, negative at its end; (n,) each."""
        from scipy.sparse.csgraph import dijkstra

        length, before = dijkstra(self.graph, True, np.array([source]), return_predecessors=True)
        return length[0], before[0].astype(np.int64)

    def nearest(self, sources: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the nearest source of each point, negative where none can be reached, (n,)."""
        from scipy.sparse.csgraph import dijkstra

        found = dijkstra(self.graph, True, sources, return_predecessors=True, min_only=True)
        return np.asarray(found[2], np.int64)
