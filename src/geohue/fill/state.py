"""What the fill knows at each step: the frame, its border and the windows on it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

OPEN = -1  # unlabelled, to be filled
WALL = -2  # outside the image, or unlabelled and outside the mask
BLOCK = 64  # values that a loop over a window takes at once, as vectors


class Image(NamedTuple):
    """The frame with a margin as wide as half a window, flattened: no step needs a bounds check.

    Flat indices of the padded frame grow in the same order as those of the frame itself.
    """

    labels: NDArray[np.int32]  # (n,) a label, OPEN or WALL
    lab: NDArray[np.float32]  # (n, 3)
    stride: int  # width with the margin
    reach: int  # half a window


class Border(NamedTuple):
    """The paper's B_S: unlabelled pixels next to labelled ones, a heap on (bound, index).

    The bound of a pixel is the lowest cost seen since it was last computed anew, hence never
    above the cost.
    """

    heap: NDArray[np.int32]  # (n_open,) pixels
    bound: NDArray[np.float64]  # (n_open,) of each pixel in the heap
    place: NDArray[np.int32]  # (n,) where a pixel stands in the heap, -1 = nowhere
    size: NDArray[np.int64]  # (1,) pixels in the heap


class Windows(NamedTuple):
    """The colours in W^n of every labelled border pixel p_n, sorted per channel, in pool slots.

    The values stand at the right end of a row whose length is a multiple of `BLOCK`, with -inf on
    their left and one +inf on their right: a loop takes the whole row and needs no length.
    """

    slot: NDArray[np.int32]  # (n,) slot of a pixel, -1 = not on the border
    values: NDArray[np.float32]  # (slots, 3, row + 1)
    length: NDArray[np.int32]  # (slots,) values in use
    median: NDArray[np.float64]  # (slots, 3)
    free: NDArray[np.int32]  # (slots,) a stack of unused slots
    n_free: NDArray[np.int64]  # (1,)
    raw: NDArray[np.float32]  # (3, row) one window before it is sorted
    rank: NDArray[np.int32]  # (row,) of its values in one channel
    near: NDArray[np.int32]  # (row + 1,) pixels of one window


def padded(
    labels: NDArray[np.int32], lab: NDArray[np.float32], mask: NDArray[np.bool_] | None, window: int
) -> Image:
    """Frame the image with walls and mark what is to be filled."""
    h, w = labels.shape
    # Beyond the frame's own size a wider window sees nothing more.
    reach = max(1, min(window // 2, max(h, w)))
    inner = labels if mask is None else np.where((labels < 0) & ~mask, np.int32(WALL), labels)
    framed = np.pad(inner, reach, constant_values=WALL).ravel()
    colours = np.pad(lab, ((reach, reach), (reach, reach), (0, 0))).reshape(-1, 3)
    return Image(framed, colours, w + 2 * reach, min(window // 2, reach))


def empty_border(image: Image) -> Border:
    """Make a border without pixels, with room for all that are open."""
    n_open = max(int(np.count_nonzero(image.labels == OPEN)), 1)  # a first place always exists
    return Border(
        heap=np.empty(n_open, dtype=np.int32),
        bound=np.empty(n_open, dtype=np.float64),
        place=np.full(image.labels.size, -1, dtype=np.int32),
        size=np.zeros(1, dtype=np.int64),
    )


def empty_windows(image: Image) -> Windows:
    """Make a pool of windows, with some room beyond the first border."""
    is_open = image.labels == OPEN
    touching = np.zeros_like(is_open)
    for step in (1, image.stride):
        touching[:-step] |= is_open[step:]
        touching[step:] |= is_open[:-step]
    slots = int(1.2 * np.count_nonzero(touching & (image.labels >= 0))) + 64
    row = -(-((2 * image.reach + 1) ** 2) // BLOCK) * BLOCK
    return Windows(
        slot=np.full(image.labels.size, -1, dtype=np.int32),
        values=np.empty((slots, 3, row + 1), dtype=np.float32),
        length=np.empty(slots, dtype=np.int32),
        median=np.empty((slots, 3), dtype=np.float64),
        # A stack: the lowest slot on top, so that the pool is touched only as far as needed.
        free=np.arange(slots, dtype=np.int32)[::-1].copy(),
        n_free=np.full(1, slots, dtype=np.int64),
        raw=np.zeros((3, row), dtype=np.float32),
        rank=np.empty(row, dtype=np.int32),
        near=np.empty(row + 1, dtype=np.int32),
    )


def grown(windows: Windows) -> Windows:
    """Double an exhausted pool (no slot is free)."""
    slots = windows.length.size
    return Windows(
        slot=windows.slot,
        values=np.concatenate((windows.values, np.empty_like(windows.values))),
        length=np.concatenate((windows.length, np.empty_like(windows.length))),
        median=np.concatenate((windows.median, np.empty_like(windows.median))),
        free=np.concatenate(
            (
                np.arange(slots, 2 * slots, dtype=np.int32)[::-1],
                np.empty(slots, dtype=np.int32),
            )
        ),
        n_free=np.full(1, slots, dtype=np.int64),
        raw=windows.raw,
        rank=windows.rank,
        near=windows.near,
    )
