"""The colours around each labelled border pixel, kept sorted for their medians."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geohue.compiled import compiled
from geohue.fill.state import OPEN, Image, Windows


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
def sort(
    raw: NDArray[np.float32], values: NDArray[np.float32], slot: int, channel: int, n: int
) -> None:
    """Put every raw value at its rank: quadratic, but one plain loop, which becomes vector code.

    A window on a border holds some window^2 / 2 values; up to a hundred or so this is several
    times faster than a sort that branches.
    """
    for i in range(n):
        values[slot, channel, i] = -np.inf
    for i in range(n):
        value = raw[channel, i]
        rank = np.int32(0)
        for j in range(n):
            rank += np.int32(raw[channel, j] < value)
        values[slot, channel, rank] = value
    largest = values[slot, channel, 0]
    for i in range(n):  # equal values share a rank: the places after it are still empty
        largest = max(largest, values[slot, channel, i])
        values[slot, channel, i] = largest


@compiled
def insert(values: NDArray[np.float32], slot: int, channel: int, n: int, value: np.float32) -> None:
    """Insert into n sorted values: each place takes the middle of itself, its left and the new.

    No branch depends on the value, which the processor could not foretell.
    """
    left = np.float32(-np.inf)
    for i in range(n):
        here = values[slot, channel, i]
        values[slot, channel, i] = max(left, min(here, value))
        left = here
    values[slot, channel, n] = max(left, value)


@compiled
def median(values: NDArray[np.float32], slot: int, channel: int, n: int) -> float:
    """Middle of n sorted values; of an even number, the mean of the two in the middle."""
    half = n >> 1
    upper = np.float64(values[slot, channel, half])
    if n & 1:
        return upper
    return (np.float64(values[slot, channel, half - 1]) + upper) / 2.0


@compiled
def open_window(image: Image, windows: Windows, p: int) -> None:
    """Give p a slot with the colours of its own segment in the window around it."""
    windows.n_free[0] -= 1
    slot = windows.free[windows.n_free[0]]
    windows.slot[p] = slot
    n = 0
    for dy in range(-image.reach, image.reach + 1):
        row = p + dy * image.stride
        for q in range(row - image.reach, row + image.reach + 1):
            if image.labels[q] == image.labels[p]:
                for channel in range(3):
                    windows.raw[channel, n] = image.lab[q, channel]
                n += 1
    windows.length[slot] = n
    for channel in range(3):
        sort(windows.raw, windows.values, slot, channel, n)
        windows.median[slot, channel] = median(windows.values, slot, channel, n)


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
    n = windows.length[slot]
    for channel in range(3):
        insert(windows.values, slot, channel, n, image.lab[p, channel])
        middle = median(windows.values, slot, channel, n + 1)
        if middle != windows.median[slot, channel]:
            windows.median[slot, channel] = middle
            moved = True
    windows.length[slot] = n + 1
    return moved
