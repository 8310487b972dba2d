"""How steady the labels of a sequence are: followed along motion, at borders, and by thing."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from geohue.compute.labels import check_labels
from geohue.errors import GeohueError

Labels = NDArray[np.int32]
Places = NDArray[np.int64]


class Steadiness(NamedTuple):
    """How labels last from one frame to the next.

    Attributes
    ----------
    kept : float
        Share of the followed pixels that keep their label.
    kept_at_borders : float
        The same among pixels near a border of the first frame.
    n_followed : int
        Pixels that are followed.
    """

    kept: float
    kept_at_borders: float
    n_followed: int


def steadiness(before: Labels, after: Labels, target: Places, width: int = 4) -> Steadiness:
    """Compare the labels of two frames along the motion between them.

    Parameters
    ----------
    before, after : (H, W) int32
        Labels, -1 = none.
    target : (H, W) int64
        For each pixel of the first frame its flat place in the second, -1 where it is not seen
        there.
    width : int
        Pixels from a border that count as near.

    Returns
    -------
    Steadiness
        NaN where nothing is followed.

    Raises
    ------
    GeohueError
        If the shapes differ.

    Examples
    --------
    >>> before, after = np.int32([[0, 0, 1, 1]]), np.int32([[0, 1, 1, 1]])
    >>> steadiness(before, after, np.array([[0, 1, 2, -1]]))[0].__round__(3)
    0.667
    """
    one, two = check_labels(before, 2), check_labels(after, 2)
    if target.shape != one.shape:
        raise GeohueError(f"target has shape {target.shape}, the labels {one.shape}")
    seen = target >= 0
    same = np.zeros(one.shape, bool)
    same[seen] = one[seen] == two.reshape(-1)[target[seen]]
    near = seen & near_borders(one, width)
    return Steadiness(_mean(same[seen]), _mean(same[near]), int(seen.sum()))


def flicker(labels: Sequence[Labels], targets: Sequence[Places]) -> float:
    """Return the share of pixels that have another label for one frame only.

    Parameters
    ----------
    labels : sequence of (H, W) int32
        Three frames or more.
    targets : sequence of (H, W) int64
        From each frame to the next, as for `steadiness`.

    Returns
    -------
    float
        Of the pixels that can be followed through three frames, those whose first and third label
        are one and the second another; NaN if none can.

    Examples
    --------
    >>> here = np.arange(2)[None]
    >>> flicker([np.int32([[0, 1]]), np.int32([[0, 0]]), np.int32([[0, 1]])], [here, here])
    0.5
    """
    turned = followed = 0
    for i in range(len(labels) - 2):
        first, second, third = (labels[i + j].reshape(-1) for j in range(3))
        start = np.flatnonzero(targets[i] >= 0)
        middle = targets[i].reshape(-1)[start]
        end = targets[i + 1].reshape(-1)[middle]
        there = end >= 0
        a, b, c = first[start[there]], second[middle[there]], third[end[there]]
        turned += int(((a == c) & (a != b)).sum())
        followed += int(there.sum())
    return turned / followed if followed else float("nan")


def identity_switches(
    truth: Sequence[Labels], labels: Sequence[Labels], least: int = 50
) -> dict[int, int]:
    """Count how often each true thing changes the label that covers most of it.

    Parameters
    ----------
    truth : sequence of (H, W) int32
        True things, -1 = none.
    labels : sequence of (H, W) int32
        Labels of the same frames.
    least : int
        Pixels below which a thing does not count as seen.

    Returns
    -------
    dict of int to int
        For each thing that is ever seen; a frame in which the label belongs more to another thing,
        as the thing has no segment of its own, is passed over.

    Examples
    --------
    >>> thing, other = np.zeros((10, 10), np.int32), np.ones((10, 10), np.int32)
    >>> identity_switches([thing] * 3, [thing, other, other])
    {0: 1}
    """
    last: dict[int, int] = {}
    switches: dict[int, int] = {}
    for true, found in zip(truth, labels, strict=True):
        seen = (true >= 0) & (found >= 0)
        n, k = int(true.max(initial=-1)) + 1, int(found.max(initial=-1)) + 1
        cell = true[seen].astype(np.int64) * k + found[seen]
        table = np.bincount(cell, minlength=n * k).reshape(n, k)
        for thing in np.flatnonzero(table.sum(axis=1) >= least).tolist():
            label = int(table[thing].argmax())
            switches.setdefault(thing, 0)
            if int(table[:, label].argmax()) != thing:
                continue
            switches[thing] += last.get(thing, label) != label
            last[thing] = label
    return switches


def near_borders(labels: Labels, width: int) -> NDArray[np.bool_]:
    """Return which pixels lie within `width` pixels of another label.

    Examples
    --------
    >>> near_borders(np.int32([[0, 0, 0, 1, 1]]), 1).tolist()
    [[False, False, True, True, False]]
    """
    near = np.zeros(labels.shape, bool)
    apart = labels[:, 1:] != labels[:, :-1]
    near[:, 1:] |= apart
    near[:, :-1] |= apart
    apart = labels[1:] != labels[:-1]
    near[1:] |= apart
    near[:-1] |= apart
    if width > 1:
        from scipy.ndimage import binary_dilation

        near = binary_dilation(near, np.ones((3, 3), bool), iterations=width - 1)
    return near


def _mean(values: NDArray[np.bool_]) -> float:
    return float(values.mean()) if values.size else float("nan")
