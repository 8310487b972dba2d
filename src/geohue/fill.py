"""Labels for the pixels without depth, spread from the labelled ones by colour (Appendix).

The paper's five steps assign one pixel at a time, the globally cheapest, and every assignment
changes the medians around it. Here a heap holds each unlabelled pixel of the border once, and
each labelled pixel of the border keeps the colours of its window sorted: an assignment inserts one
colour into the few windows that see it, and the costs that rest on a changed median move up or
down in the heap. The order is the paper's, step by step, never a stale one.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar, cast

import numpy as np
from numba import njit
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.regions import check_labels

_OPEN = -1  # unlabelled, to be filled
_WALL = -2  # outside the image, or unlabelled and outside the mask
_STALE = -3  # in place of a choice: the cost is to be computed anew

_F = TypeVar("_F", bound=Callable[..., Any])


def _compiled(function: _F) -> _F:
    """Compile, keep the code on disk, and let other Python threads run meanwhile.

    The arrays come from the caller and none is made inside, so their references are not counted
    (``_nrt``): counting every array of a tuple at every call took a third of the time. No
    fast-math, so that sums round as written.
    """
    options: dict[str, Any] = {"cache": True, "nogil": True, "forceinline": True, "_nrt": False}
    return cast(_F, njit(**options)(function))


class _Image(NamedTuple):
    """The frame with a margin as wide as half a window, flattened: no step needs a bounds check.

    Flat indices of the padded frame grow in the same order as those of the frame itself.
    """

    labels: NDArray[np.int32]  # (n,) a label, _OPEN or _WALL
    lab: NDArray[np.float32]  # (n, 3)
    stride: int  # width with the margin
    reach: int  # half a window


class _Border(NamedTuple):
    """The paper's B_S: unlabelled pixels next to labelled ones, a heap on (cost, index)."""

    heap: NDArray[np.int32]  # (n_open,) pixels
    place: NDArray[np.int32]  # (n,) where a pixel stands in the heap, -1 = nowhere
    cost: NDArray[np.float64]  # (n,) lowest cost over its labelled neighbours
    choice: NDArray[np.int32]  # (n,) the label of that cost
    size: NDArray[np.int64]  # (1,) pixels in the heap
    stale: NDArray[np.int32]  # pixels whose cost is to be computed anew in the present step


class _Windows(NamedTuple):
    """The colours in W^n of every labelled border pixel p_n, sorted per channel, in pool slots."""

    slot: NDArray[np.int32]  # (n,) slot of a pixel, -1 = not on the border
    values: NDArray[np.float32]  # (slots, 3, window^2)
    length: NDArray[np.int32]  # (slots,) values in use
    median: NDArray[np.float64]  # (slots, 3)
    free: NDArray[np.int32]  # (slots,) a stack of unused slots
    n_free: NDArray[np.int64]  # (1,)
    raw: NDArray[np.float32]  # (3, window^2) one window before it is sorted


# --- the heap ------------------------------------------------------------------------------------


@_compiled
def _before(cost: NDArray[np.float64], p: int, q: int) -> bool:
    if cost[p] != cost[q]:
        return bool(cost[p] < cost[q])
    return p < q


@_compiled
def _rise(
    heap: NDArray[np.int32], place: NDArray[np.int32], cost: NDArray[np.float64], at: int
) -> None:
    pixel = heap[at]
    while at > 0:
        parent = (at - 1) >> 1
        other = heap[parent]
        if not _before(cost, pixel, other):
            break
        heap[at] = other
        place[other] = at
        at = parent
    heap[at] = pixel
    place[pixel] = at


@_compiled
def _sink(
    heap: NDArray[np.int32], place: NDArray[np.int32], cost: NDArray[np.float64], size: int, at: int
) -> None:
    pixel = heap[at]
    while True:
        child = 2 * at + 1
        if child >= size:
            break
        if child + 1 < size and _before(cost, heap[child + 1], heap[child]):
            child += 1
        other = heap[child]
        if not _before(cost, other, pixel):
            break
        heap[at] = other
        place[other] = at
        at = child
    heap[at] = pixel
    place[pixel] = at


@_compiled
def _pop(border: _Border) -> int:
    first = border.heap[0]
    border.place[first] = -1
    border.size[0] -= 1
    size = border.size[0]
    if size > 0:
        border.heap[0] = border.heap[size]
        _sink(border.heap, border.place, border.cost, size, 0)
    return int(first)


@_compiled
def _set_key(border: _Border, pixel: int, cost: float) -> None:
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
        _rise(border.heap, border.place, border.cost, at)
    else:
        _sink(border.heap, border.place, border.cost, border.size[0], at)


# --- the windows ---------------------------------------------------------------------------------


@_compiled
def _neighbours(p: int, stride: int) -> tuple[int, int, int, int]:
    return p - stride, p - 1, p + 1, p + stride


@_compiled
def _touches_open(labels: NDArray[np.int32], stride: int, p: int) -> bool:
    for q in _neighbours(p, stride):  # noqa: SIM110 (numba compiles no generator here)
        if labels[q] == _OPEN:
            return True
    return False


@_compiled
def _sort(
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


@_compiled
def _insert(
    values: NDArray[np.float32], slot: int, channel: int, n: int, value: np.float32
) -> None:
    """Insert into n sorted values: each place takes the middle of itself, its left and the new.

    No branch depends on the value, which the processor could not foretell.
    """
    left = np.float32(-np.inf)
    for i in range(n):
        here = values[slot, channel, i]
        values[slot, channel, i] = max(left, min(here, value))
        left = here
    values[slot, channel, n] = max(left, value)


@_compiled
def _median(values: NDArray[np.float32], slot: int, channel: int, n: int) -> float:
    """Middle of n sorted values; of an even number, the mean of the two in the middle."""
    half = n >> 1
    upper = np.float64(values[slot, channel, half])
    if n & 1:
        return upper
    return (np.float64(values[slot, channel, half - 1]) + upper) / 2.0


@_compiled
def _open_window(image: _Image, windows: _Windows, p: int) -> None:
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
        _sort(windows.raw, windows.values, slot, channel, n)
        windows.median[slot, channel] = _median(windows.values, slot, channel, n)


@_compiled
def _close_window(windows: _Windows, p: int) -> None:
    windows.free[windows.n_free[0]] = windows.slot[p]
    windows.n_free[0] += 1
    windows.slot[p] = -1


@_compiled
def _add_to_window(image: _Image, windows: _Windows, slot: int, p: int) -> bool:
    """Insert the colour of p; return whether a median moved."""
    moved = False
    n = windows.length[slot]
    for channel in range(3):
        _insert(windows.values, slot, channel, n, image.lab[p, channel])
        median = _median(windows.values, slot, channel, n + 1)
        if median != windows.median[slot, channel]:
            windows.median[slot, channel] = median
            moved = True
    windows.length[slot] = n + 1
    return moved


# --- the five steps ------------------------------------------------------------------------------


@_compiled
def _update_cost(image: _Image, border: _Border, windows: _Windows, p: int) -> None:
    """Step 2 for one pixel: C(p, S^n), the least over its labelled neighbours p_n."""
    best, choice = np.inf, -1
    for q in _neighbours(p, image.stride):
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
    _set_key(border, p, best)


@_compiled
def _mark_around(
    labels: NDArray[np.int32], stride: int, border: _Border, p: int, n_stale: int
) -> int:
    """List the open neighbours of p whose cost is to be computed anew, each once."""
    choice, stale = border.choice, border.stale
    for q in _neighbours(p, stride):
        if labels[q] == _OPEN and choice[q] != _STALE:
            choice[q] = _STALE
            stale[n_stale] = q
            n_stale += 1
    return n_stale


@_compiled
def _assign(image: _Image, border: _Border, windows: _Windows, p: int) -> None:
    """Step 4: give p its label, and bring every window and cost that depends on it up to date."""
    label = border.choice[p]
    image.labels[p] = label
    for q in _neighbours(p, image.stride):
        if windows.slot[q] >= 0 and not _touches_open(image.labels, image.stride, q):
            _close_window(windows, q)
    n_stale = 0
    for dy in range(-image.reach, image.reach + 1):
        row = p + dy * image.stride
        for q in range(row - image.reach, row + image.reach + 1):
            slot = windows.slot[q]
            if slot >= 0 and image.labels[q] == label and _add_to_window(image, windows, slot, p):
                n_stale = _mark_around(image.labels, image.stride, border, q, n_stale)
    if _touches_open(image.labels, image.stride, p):
        _open_window(image, windows, p)
        n_stale = _mark_around(image.labels, image.stride, border, p, n_stale)
    for i in range(n_stale):
        _update_cost(image, border, windows, border.stale[i])


@_compiled
def _start(image: _Image, border: _Border, windows: _Windows) -> None:
    """Step 1: the border as it is before the first assignment."""
    for p in range(image.labels.size):
        if image.labels[p] >= 0 and _touches_open(image.labels, image.stride, p):
            _open_window(image, windows, p)
    for p in range(image.labels.size):
        if windows.slot[p] >= 0:
            for q in _neighbours(p, image.stride):
                if image.labels[q] == _OPEN and border.place[q] < 0:
                    _update_cost(image, border, windows, q)


@_compiled
def _spread(image: _Image, border: _Border, windows: _Windows) -> bool:
    """Run steps 3 to 5 until the border is empty (False) or the pool of slots is (True)."""
    while border.size[0] > 0:
        if windows.n_free[0] == 0:  # an assignment takes one slot at most
            return True
        _assign(image, border, windows, _pop(border))
    return False


# --- the edge ------------------------------------------------------------------------------------


def _padded(
    labels: NDArray[np.int32], lab: NDArray[np.float32], mask: NDArray[np.bool_] | None, window: int
) -> _Image:
    h, w = labels.shape
    # Beyond the frame's own size a wider window sees nothing more.
    reach = max(1, min(window // 2, max(h, w)))
    inner = labels if mask is None else np.where((labels < 0) & ~mask, np.int32(_WALL), labels)
    framed = np.pad(inner, reach, constant_values=_WALL).ravel()
    colours = np.pad(lab, ((reach, reach), (reach, reach), (0, 0))).reshape(-1, 3)
    return _Image(framed, colours, w + 2 * reach, min(window // 2, reach))


def _empty_border(image: _Image) -> _Border:
    n = image.labels.size
    return _Border(
        heap=np.empty(np.count_nonzero(image.labels == _OPEN), dtype=np.int32),
        place=np.full(n, -1, dtype=np.int32),
        cost=np.empty(n, dtype=np.float64),
        choice=np.full(n, _OPEN, dtype=np.int32),
        size=np.zeros(1, dtype=np.int64),
        # An assignment reaches the windows around it and their neighbours: one pixel further.
        stale=np.empty((2 * image.reach + 3) ** 2, dtype=np.int32),
    )


def _empty_windows(image: _Image) -> _Windows:
    is_open = image.labels == _OPEN
    touching = np.zeros_like(is_open)
    for step in (1, image.stride):
        touching[:-step] |= is_open[step:]
        touching[step:] |= is_open[:-step]
    slots = int(1.2 * np.count_nonzero(touching & (image.labels >= 0))) + 64
    side = 2 * image.reach + 1
    return _Windows(
        slot=np.full(image.labels.size, -1, dtype=np.int32),
        values=np.empty((slots, 3, side * side), dtype=np.float32),
        length=np.empty(slots, dtype=np.int32),
        median=np.empty((slots, 3), dtype=np.float64),
        # A stack: the lowest slot on top, so that the pool is touched only as far as needed.
        free=np.arange(slots, dtype=np.int32)[::-1].copy(),
        n_free=np.full(1, slots, dtype=np.int64),
        raw=np.empty((3, side * side), dtype=np.float32),
    )


def _grown(windows: _Windows) -> _Windows:
    """Double an exhausted pool (no slot is free)."""
    slots = windows.length.size
    return _Windows(
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
    )


def _check(
    labels: NDArray[np.int32], lab: NDArray[Any], window: int, mask: NDArray[np.bool_] | None
) -> NDArray[np.float32]:
    if lab.shape != (*labels.shape, 3):
        raise GeohueError(
            f"lab: shape {lab.shape} with labels of shape {labels.shape}; "
            f"expected {(*labels.shape, 3)}"
        )
    if not np.issubdtype(lab.dtype, np.floating):
        raise GeohueError(
            f"lab: {lab.dtype} values; expected float32 CIELab (8-bit Lab is scaled differently)"
        )
    if not np.all(np.isfinite(lab)):
        raise GeohueError("lab: NaN or infinite values; colours must be finite")
    if isinstance(window, bool) or not isinstance(window, (int, np.integer)):
        raise GeohueError(f"window: {window!r}; expected an odd whole number of pixels")
    if window < 1 or window % 2 == 0:
        raise GeohueError(f"window: {window}; expected an odd number of pixels, 1 or more")
    if mask is not None and (mask.dtype != np.bool_ or mask.shape != labels.shape):
        raise GeohueError(
            f"mask: {mask.dtype} of shape {mask.shape}; expected bool of shape {labels.shape}"
        )
    return lab.astype(np.float32, copy=False)


def fill_labels(
    labels: NDArray[np.integer[Any]],
    lab: NDArray[np.floating[Any]],
    window: int = 7,
    mask: NDArray[np.bool_] | None = None,
) -> NDArray[np.int32]:
    """Spread labels to unlabelled pixels, one at a time, the cheapest first (Appendix).

    The cost of giving the unlabelled pixel p_i the label of its labelled 4-neighbour p_n is the
    sum over L, a and b of ``|lab(p_i) - median|``, the median over the pixels with the label of
    p_n in the window centred on p_n (clipped at the edge of the image; the median of an even
    number of values is the mean of the two in the middle). Of all such pairs the one with the
    lowest cost is assigned, the pixel counts in the medians from then on, and so on until no
    unlabelled pixel has a labelled neighbour. Equal costs: the lowest flat pixel index first, then
    the lowest label.

    Parameters
    ----------
    labels : (H, W) integer array
        Labels, -1 = none.
    lab : (H, W, 3) float32 array
        CIELab colours, all finite.
    window : int, default 7
        Side of W^n in pixels, odd. The paper gives no size.
    mask : (H, W) bool array, optional
        The pixels to be filled; None means all. Unlabelled pixels outside stay -1 and block the
        way. Labelled pixels keep and spread their labels wherever they are.

    Returns
    -------
    (H, W) int32 array
        The filled labels, a new array. Pixels that no labelled pixel reaches through unlabelled
        4-neighbours of the mask are still -1: ``(filled < 0) & mask`` are those.

    Raises
    ------
    GeohueError
        If a shape or type is wrong, a label is below -1, a colour is not finite, or the window is
        even or not positive.

    Notes
    -----
    The differences are absolute: as printed, without the bars, the minimum would take the most
    negative one. Costs are summed in float64 in the order L, a, b. Memory is about 45 bytes per
    pixel, and 12 bytes times window^2 per labelled pixel on the border. The first call of a
    process compiles the loops or loads them from the cache on disk.

    References
    ----------
    Dal Mutto, Zanuttigh, Cortelazzo, "Fusion of geometry and color information for scene
    segmentation", IEEE J. Sel. Topics Signal Process. 6(5), 2012, Appendix.

    Examples
    --------
    A row between a dark and a bright segment; the middle is closer to the bright one:

    >>> import numpy as np
    >>> lab = np.zeros((1, 5, 3), dtype=np.float32)
    >>> lab[0, :, 0] = [10, 12, 60, 88, 90]
    >>> fill_labels(np.array([[0, -1, -1, -1, 1]]), lab).tolist()
    [[0, 0, 1, 1, 1]]
    """
    checked = check_labels(labels, ndim=2)
    colours = _check(checked, lab, window, mask)
    h, w = checked.shape
    image = _padded(checked, colours, mask, window)
    border = _empty_border(image)
    windows = _empty_windows(image)
    _start(image, border, windows)
    while _spread(image, border, windows):
        windows = _grown(windows)
    margin = (image.stride - w) // 2
    filled = image.labels.reshape(h + 2 * margin, -1)[margin : margin + h, margin : margin + w]
    return np.maximum(filled, _OPEN).astype(np.int32, copy=False)
