"""The five steps of the Appendix, one assignment at a time."""

from __future__ import annotations

import numpy as np

from geohue.compute.compiled import compiled, compiled_part
from geohue.fill.heap import bound_of, lower, pop, sink
from geohue.fill.state import OPEN, Border, Image, Windows
from geohue.fill.windows import (
    add_to_window,
    close_window,
    neighbours,
    open_window,
    same_label,
    touches_open,
)


@compiled_part
def pair_cost(image: Image, windows: Windows, p: int, slot: int) -> float:
    """C(p, S^n) of one labelled neighbour p_n, the one whose window has this slot."""
    cost = 0.0
    for channel in range(3):
        cost += abs(np.float64(image.lab[p, channel]) - windows.median[slot, channel])
    return cost


@compiled_part
def cheapest(image: Image, windows: Windows, p: int) -> tuple[float, int]:
    """Step 2 for one pixel: the least cost over its labelled neighbours, and the label of that."""
    best, choice = np.inf, -1
    for q in neighbours(p, image.stride):
        slot = windows.slot[q]
        if slot < 0:
            continue
        cost = pair_cost(image, windows, p, slot)
        label = image.labels[q]
        if cost < best or (cost == best and label < choice):
            best, choice = cost, label
    return best, choice


@compiled_part
def offer(image: Image, border: Border, windows: Windows, q: int) -> None:
    """Tell the open neighbours of q what its label now costs them, if it is less than before."""
    slot = windows.slot[q]
    for p in neighbours(q, image.stride):
        cost = pair_cost(image, windows, p, slot)
        # One branch, seldom taken: whether a pixel is open could not be foretold.
        if (image.labels[p] == OPEN) & (cost < bound_of(border, p)):
            lower(border, p, cost)


@compiled_part
def assign(image: Image, border: Border, windows: Windows, p: int, label: int) -> None:
    """Step 4: give p its label, and bring every window and bound that depends on it up to date."""
    image.labels[p] = label
    for q in neighbours(p, image.stride):
        if windows.slot[q] >= 0 and not touches_open(image.labels, image.stride, q):
            close_window(windows, q)
    n = same_label(image, windows.near, p, label)
    if touches_open(image.labels, image.stride, p):
        open_window(image, windows, p, n)
    for i in range(n):  # p is one of them
        q = windows.near[i]
        slot = windows.slot[q]
        if slot >= 0 and (q == p or add_to_window(image, windows, slot, p)):
            offer(image, border, windows, q)


@compiled
def start(image: Image, border: Border, windows: Windows) -> None:
    """Step 1: the border as it is before the first assignment."""
    for p in range(image.labels.size):
        if image.labels[p] >= 0 and touches_open(image.labels, image.stride, p):
            n = same_label(image, windows.near, p, image.labels[p])
            open_window(image, windows, p, n)
            offer(image, border, windows, p)


@compiled
def spread(image: Image, border: Border, windows: Windows) -> bool:
    """Run steps 3 to 5 until the border is empty (False) or the pool of slots is (True).

    Costs fall and rise with the medians. A fall is noted at once, a rise only when its pixel
    comes to the top: it goes back to where it now belongs, and what stays on top is the cheapest.
    """
    while border.size[0] > 0:
        if windows.n_free[0] == 0:  # an assignment takes one slot at most
            return True
        p = border.heap[0]
        cost, label = cheapest(image, windows, p)
        if cost > border.bound[0]:
            sink(border, p, cost)
        else:
            pop(border)
            assign(image, border, windows, p, label)
    return False
