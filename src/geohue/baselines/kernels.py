"""Compiled helpers that several systems share."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from geohue.compute.compiled import kept_on_disk, within_loops
from geohue.regions.pieces import find_root

__all__ = [
    "compiled",
    "compiled_part",
    "find_root",
    "flatten",
    "join_roots",
    "vectorised_part",
]

_F = TypeVar("_F", bound=Callable[..., Any])


def compiled(function: _F) -> _F:
    """Compile for the processor, kept on disk; no fast-math, so the sums round as written."""
    return kept_on_disk(function)


def compiled_part(function: _F) -> _F:
    """Compile what loops of `compiled` call, as part of these."""
    return within_loops(function)


def vectorised_part(function: _F) -> _F:
    """Compile a part with sums in any order, so that several pixels are taken at once.

    The order is fixed when it is compiled: it depends on the processor, never on the threads.
    """
    return within_loops(function, fastmath={"reassoc", "nsz"})


@compiled_part
def join_roots(parent: NDArray[np.int32], one: int, other: int) -> int:
    """Join two sets by their representatives, maybe the same; the lower one represents them."""
    low, high = min(one, other), max(one, other)
    parent[high] = low
    return low


@compiled_part
def flatten(parent: NDArray[np.int32]) -> NDArray[np.int32]:
    """Number the sets 0..K-1 in the order of their first nodes."""
    labels = np.empty(len(parent), np.int32)
    count = 0
    for node in range(len(parent)):
        root = find_root(parent, node)
        if root == node:  # representatives are the lowest: the others come after them
            labels[node] = count
            count += 1
        else:
            labels[node] = labels[root]
    return labels
