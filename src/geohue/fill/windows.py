"""The colours around each labelled border pixel, kept sorted for their medians."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geohue.compute.compiled import compiled_part
from geohue.fill.state import BLOCK, OPEN, Image, Windows


@compiled_part
def neighbours(p: int, stride: int) -> tuple[int, int, int, int]:
    """Up, left, right and down of a pixel; the margin makes them always exist."""
    return p - stride, p - 1, p + 1, p + stride


@compiled_part
def touches_open(labels: NDArray[np.int32], stride: int, p: int) -> bool:
    """Whether a pixel has a neighbour that is still to be filled."""
    up, left, right, down = neighbours(p, stride)
    across = (labels[left] == OPEN) | (labels[right] == OPEN)
    return bool(across | (labels[up] == OPEN) | (labels[down] == OPEN))


@compiled_part
def sort(
    raw: NDArray[np.float32], rank: NDArray[np.int32], values: NDArray[np.float32], n: int
) -> None:
    """Put every one of n raw values at its rank: quadratic, but plain loops, which become vectors.

    A window on a border holds some window^2 / 2 values; up to a hundred or so this is several
    times faster than a sort that branches. What ``raw`` has after the n values is of no effect.
    """
    size = raw.size
    for i in range(size):
        values[i] = -np.inf
        rank[i] = size - n
    values[size] = np.inf
    for block in range(0, n, BLOCK):
        part, ranks = raw[block : block + BLOCK], rank[block : block + BLOCK]
        for j in range(n):
            value = raw[j]
            for i in range(BLOCK):
                ranks[i] += np.int32(value < part[i])
    for i in range(n):
        values[rank[i]] = raw[i]
    largest = np.float32(-np.inf)
    for i in range(size - n, size):  # equal values share a rank: the places after it are empty
        largest = max(largest, values[i])
        values[i] = largest


@compiled_part
def insert(values: NDArray[np.float32], n: int, value: np.float32) -> None:
    """Insert into the n sorted values on the right of a row; those below make room to the left.

    Each place takes the middle of itself, its right and the new one: no branch depends on the
    value, which the processor could not foretell.
    """
    size = values.size - 1
    for block in range((size - n - 1) // BLOCK * BLOCK, size, BLOCK):
        part = values[block : block + BLOCK + 1]
        for i in range(BLOCK):
            part[i] = min(part[i + 1], max(part[i], value))


@compiled_part
def median(values: NDArray[np.float32], n: int) -> float:
    """Middle of the n sorted values; of an even number, the mean of the two in the middle."""
    first = values.size - 1 - n
    upper = np.float64(values[first + (n >> 1)])
    return (np.float64(values[first + ((n - 1) >> 1)]) + upper) / 2.0  # of an odd number: the same


@compiled_part
def same_label(image: Image, near: NDArray[np.int32], p: int, label: int) -> int:
    """List the pixels with a label in the window around p; returns how many there are.

    Each is written, and then kept or written over: no branch that could not be foretold.
    """
    n = 0
    for dy in range(-image.reach, image.reach + 1):
        row = p + dy * image.stride
        for q in range(row - image.reach, row + image.reach + 1):
            near[n] = q
            n += int(image.labels[q] == label)
    return n


@compiled_part
def open_window(image: Image, windows: Windows, p: int, n: int) -> None:
    """Give p a slot with the colours of its own segment: the first n pixels of ``near``."""
    windows.n_free[0] -= 1
    slot = windows.free[windows.n_free[0]]
    windows.slot[p] = slot
    for i in range(n):
        for channel in range(3):
            windows.raw[channel, i] = image.lab[windows.near[i], channel]
    windows.length[slot] = n
    for channel in range(3):
        sort(windows.raw[channel], windows.rank, windows.values[slot, channel], n)
        windows.median[slot, channel] = median(windows.values[slot, channel], n)


@compiled_part
def close_window(windows: Windows, p: int) -> None:
    """Give back the slot of a pixel that has left the border."""
    windows.free[windows.n_free[0]] = windows.slot[p]
    windows.n_free[0] += 1
    windows.slot[p] = -1


@compiled_part
def add_to_window(image: Image, windows: Windows, slot: int, p: int) -> bool:
    """Insert the colour of p; return whether a median moved."""
    moved = False
    n = windows.length[slot] + 1
    for channel in range(3):
        values = windows.values[slot, channel]
        insert(values, n - 1, image.lab[p, channel])
        middle = median(values, n)
        moved |= middle != windows.median[slot, channel]
        windows.median[slot, channel] = middle
    windows.length[slot] = n
    return moved
