"""What the last frame says about this one."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geohue.regions.adjacency import nearest_known

Labels = NDArray[np.int32]

VOTES = 0.25
"""Votes that the labels of the last frame have for each of the cuts'."""


def past_votes(before: Labels, n_cuts: int) -> list[Labels]:
    """Return the labels of the last frame as votes on borders, beside those of the cuts.

    Parameters
    ----------
    before : (h, w) int32
        Identities where they lie in this draft; one that is unknown, -1, counts as the nearest.
    n_cuts : int
        How many cuts vote.

    Returns
    -------
    list of (h, w) int32
        `VOTES` of them for each cut; none where nothing is known.

    Examples
    --------
    >>> [votes.tolist() for votes in past_votes(np.array([[7, -1, -1, 3]], np.int32), 4)]
    [[[7, 7, 3, 3]]]
    """
    known = before >= 0
    if not known.any():
        return []
    return [before.reshape(-1)[nearest_known(known)]] * round(VOTES * n_cuts)


def contingency(
    parts: Labels, tracks: Labels, n: int, names: dict[int, int]
) -> NDArray[np.float64]:
    """Count the pixels of each part on each track.

    Parameters
    ----------
    parts : (h, w) int32
        0..n-1.
    tracks : (h, w) int32
        Identities, -1 = none.
    n : int
        Number of parts.
    names : dict
        The column of each identity; others are left out.

    Returns
    -------
    (n, T) float64

    Examples
    --------
    >>> contingency(np.int32([[0, 1, 1]]), np.int32([[7, 7, -1]]), 2, {7: 0}).tolist()
    [[1.0], [1.0]]
    """
    column = np.full(max([*names, int(tracks.max(initial=-1)), 0]) + 2, -1, np.int64)
    for track, number in names.items():
        column[track] = number
    place = column[tracks.reshape(-1)]  # -1 is the last entry
    known = place >= 0
    cell = parts.reshape(-1)[known].astype(np.int64) * len(names) + place[known]
    return np.bincount(cell, minlength=n * len(names)).reshape(n, len(names)).astype(np.float64)
