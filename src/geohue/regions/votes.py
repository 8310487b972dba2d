"""Votes for a label."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


def most_votes(
    voter: NDArray[np.integer[Any]],
    label: NDArray[np.int32],
    votes: NDArray[np.integer[Any]],
) -> NDArray[np.int32]:
    """Return for each voter 0..n-1 the label with most votes, the lowest of equals."""
    span = int(label.max()) + 1
    key, group = np.unique(voter.astype(np.int64) * span + label, return_inverse=True)
    total = np.bincount(group, weights=votes)
    voters, choices = np.divmod(key, span)
    order = np.lexsort((-total, voters))  # stable: among equals the lower label stays first
    first = np.flatnonzero(np.diff(voters[order], prepend=-1))
    winners: NDArray[np.int32] = choices[order][first].astype(np.int32)
    return winners
