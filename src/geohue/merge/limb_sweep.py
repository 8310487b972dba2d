"""The compiled sweep of `limbs`: sets of points that grow inwards from the ends of a cloud."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geohue.compute.compiled import compiled, compiled_part
from geohue.regions.pieces import find_root

OPEN, CORE, CLOSED = 0, 1, 2
"""What a set is while the sweep runs: still growing, part of the core, a limb for good."""


@compiled
def sweep_inwards(
    order: NDArray[np.int64],
    height: NDArray[np.float64],
    starts: NDArray[np.int32],
    near: NDArray[np.int32],
    shortest: float,
    cell: float,
    met: NDArray[np.int32],
    parent: NDArray[np.int32],
    size: NDArray[np.int64],
    state: NDArray[np.int8],
) -> None:
    """Join points from the farthest inwards; where grown sets meet, each stays by itself.

    A set grows from each local maximum of ``height``, the distance from the centre. It is grown
    up when it is longer than ``shortest`` and its squared length exceeds ``cell`` times its
    points: a limb, not a bump. Where a grown set meets another, or the core, it is closed; the
    sets that are not grown go into the core. What lies between closed limbs is core.

    Parameters
    ----------
    order : (n,) int64
        The points, farthest first.
    height : (n,) float64
        Their distances from the centre.
    starts, near : (n + 1,), (E,) int32
        ``near[starts[v]:starts[v + 1]]`` are the neighbours of v.
    shortest, cell : float
        What a limb is, in the unit of ``height`` and its square.
    met : int32 array
        Room for the neighbours of any point.
    parent : (n,) int32
        Comes in as -1, goes out as the forest of the sets. The root of a set that is not core is
        its farthest point.
    size, state : (n,) integer
        Go out true for the root of each set: its points, and `OPEN`, `CORE` or `CLOSED`.
    """
    for v in order:
        parent[v], size[v], state[v] = v, 1, OPEN
        k, alone = _meet(v, starts, near, parent, state, met)
        if k == 0:
            state[v] = OPEN if alone else CORE
            continue
        grown = 0
        into = met[0]
        for root in met[:k]:
            if state[root] == CORE or _is_limb(root, v, height, size, shortest, cell):
                grown += 1
            if _leads(root, into, height, state):
                into = root
        if grown >= 2 and state[into] != CORE:
            state[v] = CORE
            into = v
        for root in met[:k]:
            apart = grown >= 2 and state[root] == OPEN
            if apart and _is_limb(root, v, height, size, shortest, cell):
                state[root] = CLOSED
            else:
                _join(root, into, parent, size)
        _join(v, into, parent, size)


@compiled_part
def _meet(
    v: int,
    starts: NDArray[np.int32],
    near: NDArray[np.int32],
    parent: NDArray[np.int32],
    state: NDArray[np.int8],
    met: NDArray[np.int32],
) -> tuple[int, bool]:
    """List the sets beside a point that are not closed, each once; whether there is no set."""
    k = 0
    alone = True
    for i in range(starts[v], starts[v + 1]):
        if near[i] == v or parent[near[i]] < 0:
            continue
        alone = False
        root = find_root(parent, near[i])
        known = state[root] == CLOSED
        for j in range(k):
            known = known or met[j] == root
        if not known:
            met[k] = root
            k += 1
    return k, alone


@compiled_part
def _is_limb(
    root: int,
    v: int,
    height: NDArray[np.float64],
    size: NDArray[np.int64],
    shortest: float,
    cell: float,
) -> bool:
    """Whether the set of a root is grown up when the sweep has come to v."""
    length = height[root] - height[v]
    return bool(length > shortest and length * length > cell * size[root])


@compiled_part
def _leads(one: int, other: int, height: NDArray[np.float64], state: NDArray[np.int8]) -> bool:
    """Whether the other set joins the one: the core comes first, then the farther end."""
    if (state[one] == CORE) != (state[other] == CORE):
        return bool(state[one] == CORE)
    return bool(height[one] > height[other])


@compiled_part
def _join(one: int, into: int, parent: NDArray[np.int32], size: NDArray[np.int64]) -> None:
    """Put the set of one root under another root."""
    if one != into:
        parent[one] = into
        size[into] += size[one]
