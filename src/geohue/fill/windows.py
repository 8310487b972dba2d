"""The colours around each labelled border pixel, kept sorted for their medians."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geohue.compiled import compiled
from geohue.fill.state import BLOCK, OPEN, Image, Windows


@compiled
def neighbours(p: int, stride: int) -> tuple[int, int, int, int]:
    """Up, left, right and down of a pixel; the margin makes them always exist."""
    return p - stride, p - 1, p + 1, p + stride


@compiled
def touches_open(labels: NDArray[np.int32], stride: int, p: int) -> bool:
    """Whether a pixel has a neighbour that is still to be filled."""
    for q in neighbours(p, stride):  # noqa: SIM110 (numba compiles no generator here)
        if labels[q] == OPEN:
            return True
    return False


@compiled
def sort(raw: NDArray[np.float32], values: NDArray[np.float32], n: int) -> None:
    """Put every one of n raw values at its rank: quadratic, but plain loops, which become vectors.

    A window on a border holds some window^2 / 2 values; up to a hundred or so this is several
    times faster than a sort that branches. ``raw`` has +inf after the values.
    """
    first = raw.size - n
    for i in range(raw.size):
        values[i] = -np.inf
    values[raw.size] = np.inf
    for i in range(n):
        value = raw[i]
        rank = np.int32(0)
        for block in range(0, n, BLOCK):
            part = raw[block : block + BLOCK]
            for j in range(BLOCK):
                rank += np.int32(part[j] < value)
        values[first + rank] = value
    largest = np.float32(-np.inf)
    for i in range(first, raw.size):  # equal values share a rank: the places after it are empty
        largest = max(largest, values[i])
        values[i] = largest


@compiled
def insert(values: NDArray[np.float32], value: np.float32) -> None:
    """Insert into the sorted values on the right of a row; those below make room to the left.

    Each place takes the middle of itself, its right and the new one: no branch depends on the
    value, which the processor could not foretell.
    """
    for block in range(0, values.size - 1, BLOCK):
        part = values[block : block + BLOCK + 1]
        for i in range(BLOCK):
            part[i] = min(part[i + 1], max(part[i], value))


@compiled
def median(values: NDArray[np.float32], n: int) -> float:
    """Middle of the n sorted values; of an even number, the mean of the two in the middle."""
    half = values.size - 1 - n + (n >> 1)
    upper = np.float64(values[half])
    if n & 1:
        return upper
    return (np.float64(values[half - 1]) + upper) / 2.0


@compiled
def open_window(image: Image, windows: Windows, p: int) -> None:
    """Give p a slot with the colours of its own segment in the window around it."""
    windows.n_free[0] -= 1
    slot = windows.free[windows.n_free[0]]
    windows.slot[p] = slot
    raw = windows.raw
    n = 0
    for dy in range(-image.reach, image.reach + 1):
        row = p + dy * image.stride
        for q in range(row - image.reach, row + image.reach + 1):
            if image.labels[q] == image.labels[p]:
                for channel in range(3):
                    raw[channel, n] = image.lab[q, channel]
                n += 1
    windows.length[slot] = n
    for channel in range(3):
        for i in range(n, raw.shape[1]):
            raw[channel, i] = np.inf
        sort(raw[channel], windows.values[slot, channel], n)
        windows.median[slot, channel] = median(windows.values[slot, channel], n)


@compiled
def close_window(windows: Windows, p: int) -> None:
    """Give back the slot of a pixel that has left the border."""
    windows.free[windows.n_free[0]] = windows.slot[p]
    windows.n_free[0] += 1
    windows.slot[p] = -1


@compiled
def add_to_window(image: Image, windows: Windows, slot: int, p: int) -> bool:
    """Insert the colour of p; return whether a median moved."""
    moved = False
    n = windows.length[slot] + 1
    for channel in range(3):
        values = windows.values[slot, channel]
        insert(values, image.lab[p, channel])
        middle = median(values, n)
        if middle != windows.median[slot, channel]:
            windows.median[slot, channel] = middle
            moved = True
    windows.length[slot] = n
    return moved
