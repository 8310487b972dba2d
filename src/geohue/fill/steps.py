"""The five steps of the Appendix, one assignment at a time."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geohue.compiled import compiled
from geohue.fill.heap import pop, set_key
from geohue.fill.state import OPEN, STALE, Border, Image, Windows
from geohue.fill.windows import add_to_window, close_window, neighbours, open_window, touches_open


@compiled
def update_cost(image: Image, border: Border, windows: Windows, p: int) -> None:
    """Step 2 for one pixel: C(p, S^n), the least over its labelled neighbours p_n."""
    best, choice = np.inf, -1
    for q in neighbours(p, image.stride):
        slot = windows.slot[q]
        if slot < 0:
            continue
        cost = 0.0
        for channel in range(3):
            cost += abs(np.float64(image.lab[p, channel]) - windows.median[slot, channel])
        label = image.labels[q]
        if cost < best or (cost == best and label < choice):
            best, choice = cost, label
    border.choice[p] = choice
    set_key(border, p, best)


@compiled
def mark_around(
    labels: NDArray[np.int32], stride: int, border: Border, p: int, n_stale: int
) -> int:
    """List the open neighbours of p whose cost is to be computed anew, each once."""
    choice, stale = border.choice, border.stale
    for q in neighbours(p, stride):
        if labels[q] == OPEN and choice[q] != STALE:
            choice[q] = STALE
            stale[n_stale] = q
            n_stale += 1
    return n_stale


@compiled
def assign(image: Image, border: Border, windows: Windows, p: int) -> None:
    """Step 4: give p its label, and bring every window and cost that depends on it up to date."""
    label = border.choice[p]
    image.labels[p] = label
    for q in neighbours(p, image.stride):
        if windows.slot[q] >= 0 and not touches_open(image.labels, image.stride, q):
            close_window(windows, q)
    n_stale = 0
    for dy in range(-image.reach, image.reach + 1):
        row = p + dy * image.stride
        for q in range(row - image.reach, row + image.reach + 1):
            slot = windows.slot[q]
            if slot >= 0 and image.labels[q] == label and add_to_window(image, windows, slot, p):
                n_stale = mark_around(image.labels, image.stride, border, q, n_stale)
    if touches_open(image.labels, image.stride, p):
        open_window(image, windows, p)
        n_stale = mark_around(image.labels, image.stride, border, p, n_stale)
    for i in range(n_stale):
        update_cost(image, border, windows, border.stale[i])


@compiled
def start(image: Image, border: Border, windows: Windows) -> None:
    """Step 1: the border as it is before the first assignment."""
    for p in range(image.labels.size):
        if image.labels[p] >= 0 and touches_open(image.labels, image.stride, p):
            open_window(image, windows, p)
    for p in range(image.labels.size):
        if windows.slot[p] >= 0:
            for q in neighbours(p, image.stride):
                if image.labels[q] == OPEN and border.place[q] < 0:
                    update_cost(image, border, windows, q)


@compiled
def spread(image: Image, border: Border, windows: Windows) -> bool:
    """Run steps 3 to 5 until the border is empty (False) or the pool of slots is (True)."""
    while border.size[0] > 0:
        if windows.n_free[0] == 0:  # an assignment takes one slot at most
            return True
        assign(image, border, windows, pop(border))
    return False
