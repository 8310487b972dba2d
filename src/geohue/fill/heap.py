"""The border as a heap on (cost, pixel index) in which costs may rise and fall."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geohue.compiled import compiled
from geohue.fill.state import Border


@compiled
def before(cost: NDArray[np.float64], p: int, q: int) -> bool:
    """Whether p is assigned before q: by cost, then by index."""
    if cost[p] != cost[q]:
        return bool(cost[p] < cost[q])
    return p < q


@compiled
def rise(
    heap: NDArray[np.int32], place: NDArray[np.int32], cost: NDArray[np.float64], at: int
) -> None:
    """Move the pixel at a place of the heap up to where it belongs."""
    pixel = heap[at]
    while at > 0:
        parent = (at - 1) >> 1
        other = heap[parent]
        if not before(cost, pixel, other):
            break
        heap[at] = other
        place[other] = at
        at = parent
    heap[at] = pixel
    place[pixel] = at


@compiled
def sink(
    heap: NDArray[np.int32], place: NDArray[np.int32], cost: NDArray[np.float64], size: int, at: int
) -> None:
    """Move the pixel at a place of the heap down to where it belongs."""
    pixel = heap[at]
    while True:
        child = 2 * at + 1
        if child >= size:
            break
        if child + 1 < size and before(cost, heap[child + 1], heap[child]):
            child += 1
        other = heap[child]
        if not before(cost, other, pixel):
            break
        heap[at] = other
        place[other] = at
        at = child
    heap[at] = pixel
    place[pixel] = at


@compiled
def pop(border: Border) -> int:
    """Take the cheapest pixel off the border."""
    first = border.heap[0]
    border.place[first] = -1
    border.size[0] -= 1
    size = border.size[0]
    if size > 0:
        border.heap[0] = border.heap[size]
        sink(border.heap, border.place, border.cost, size, 0)
    return int(first)


@compiled
def set_key(border: Border, pixel: int, cost: float) -> None:
    """Put a pixel at its place for a new cost, whether it is in the heap or not."""
    at = border.place[pixel]
    old = border.cost[pixel]
    border.cost[pixel] = cost
    if at < 0:
        at = border.size[0]
        border.size[0] += 1
        border.heap[at] = pixel
        old = np.inf
    if cost <= old:
        rise(border.heap, border.place, border.cost, at)
    else:
        sink(border.heap, border.place, border.cost, border.size[0], at)
