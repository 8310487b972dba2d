"""The border as a heap on (bound, pixel index) in which bounds may fall, and rise at the top."""

from __future__ import annotations

import numpy as np

from geohue.compute.compiled import compiled_part
from geohue.fill.state import Border


@compiled_part
def before(one: float, p: int, other: float, q: int) -> bool:
    """Whether p with a bound comes before q with another: by bound, then by index."""
    return (one < other) | ((one == other) & (p < q))


@compiled_part
def put(border: Border, at: int, pixel: int, bound: float) -> None:
    """Put a pixel in a place of the heap."""
    border.heap[at] = pixel
    border.bound[at] = bound
    border.place[pixel] = at


@compiled_part
def rise(border: Border, at: int, pixel: int, bound: float) -> None:
    """Put a pixel where it belongs at or above a place of the heap that is free."""
    while at > 0:
        parent = (at - 1) >> 1
        if not before(bound, pixel, border.bound[parent], border.heap[parent]):
            break
        put(border, at, border.heap[parent], border.bound[parent])
        at = parent
    put(border, at, pixel, bound)


@compiled_part
def sink(border: Border, pixel: int, bound: float) -> None:
    """Put a pixel where it belongs below the top of the heap, which is free."""
    size, at = border.size[0], 0
    heap, bounds = border.heap, border.bound
    while True:
        child = 2 * at + 1
        if child >= size:
            break
        other = min(child + 1, size - 1)
        # A sum, not a branch: it could not be foretold.
        child += int(before(bounds[other], heap[other], bounds[child], heap[child]))
        if not before(bounds[child], heap[child], bound, pixel):
            break
        put(border, at, heap[child], bounds[child])
        at = child
    put(border, at, pixel, bound)


@compiled_part
def pop(border: Border) -> None:
    """Take the first pixel off the border."""
    border.place[border.heap[0]] = -1
    border.size[0] -= 1
    last = border.size[0]
    if last > 0:
        sink(border, border.heap[last], border.bound[last])


@compiled_part
def bound_of(border: Border, pixel: int) -> float:
    """The bound of a pixel, infinite if it is not in the heap."""
    at = border.place[pixel]
    bound = border.bound[max(at, 0)]
    return np.inf if at < 0 else bound


@compiled_part
def lower(border: Border, pixel: int, bound: float) -> None:
    """Lower the bound of a pixel, or put it in the heap if it is not there."""
    at = border.place[pixel]
    if at < 0:
        at = border.size[0]
        border.size[0] += 1
    rise(border, at, pixel, bound)
