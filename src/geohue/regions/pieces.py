"""Connected pieces of a label image and what they touch, in compiled passes over the pixels."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geohue.compute.compiled import compiled, compiled_part


@compiled_part
def find_root(parent: NDArray[np.int32], at: int) -> int:
    """Follow the parents of a set to its root, halving the way for the next to come."""
    while parent[at] != at:
        parent[at] = parent[parent[at]]
        at = parent[at]
    return at


@compiled
def number_pieces(
    labels: NDArray[np.int32],
    pieces: NDArray[np.int32],
    parent: NDArray[np.int32],
    sizes: NDArray[np.int64],
    label_of: NDArray[np.int32],
    corners: bool,
) -> int:
    """Number the connected pieces of equal label in the order of their first pixels.

    Fills ``pieces`` (H, W) with -1 where there is no label, ``sizes`` and ``label_of`` of each
    piece, and returns how many there are. ``parent``, ``sizes`` and ``label_of`` have room for a
    piece a pixel.
    """
    n_runs = join_runs(labels, pieces, parent, corners)
    n = 0
    for run in range(n_runs):  # a root is the first run of its piece
        if parent[run] == run:
            parent[run] = n
            sizes[n] = 0
            n += 1
        else:
            parent[run] = parent[parent[run]]
    height, width = labels.shape
    for y in range(height):
        for x in range(width):
            if pieces[y, x] >= 0:
                piece = parent[pieces[y, x]]
                pieces[y, x] = piece
                sizes[piece] += 1
                label_of[piece] = labels[y, x]
    return n


@compiled_part
def join_runs(
    labels: NDArray[np.int32], pieces: NDArray[np.int32], parent: NDArray[np.int32], corners: bool
) -> int:
    """Number the runs of equal label in each row; join those that touch in the row above.

    A parent is never above its child, so that a root is the first of its piece; returns the
    number of runs.
    """
    height, width = labels.shape
    reach = 1 if corners else 0
    n = 0
    for y in range(height):
        for x in range(width):
            label = labels[y, x]
            if label < 0:
                pieces[y, x] = -1
                continue
            if x > 0 and labels[y, x - 1] == label:
                run = pieces[y, x - 1]
            else:
                run = n
                parent[n] = n
                n += 1
            pieces[y, x] = run
            if y > 0:
                for u in range(max(x - reach, 0), min(x + reach + 1, width)):
                    if labels[y - 1, u] == label:
                        join(parent, run, pieces[y - 1, u])
    return n


@compiled_part
def join(parent: NDArray[np.int32], one: int, other: int) -> None:
    """Make two pieces one, under the root with the lower number."""
    if parent[one] == parent[other]:
        return
    one, other = find_root(parent, one), find_root(parent, other)
    if one < other:
        parent[other] = one
    else:
        parent[one] = other


@compiled
def count_borders(
    pieces: NDArray[np.int32], kept: NDArray[np.bool_], starts: NDArray[np.int64]
) -> int:
    """Count the 4-adjacent pixel pairs of each piece with others, one of the two small.

    Puts where the list of each piece begins into ``starts`` (C + 1,), which comes in with zeros,
    and returns the length of all lists.
    """
    height, width = pieces.shape
    for y in range(height):
        for x in range(width):
            here = pieces[y, x]
            for side in range(2):
                there = beside(pieces, y, x, side)
                if differ(here, there, kept):
                    starts[here] += 1
                    starts[there] += 1
    total = 0
    for piece in range(starts.size):
        count = starts[piece]
        starts[piece] = total
        total += count
    return total


@compiled_part
def beside(pieces: NDArray[np.int32], y: int, x: int, side: int) -> int:
    """The piece to the right (side 0) or below, -1 if none."""
    if side == 0:
        return int(pieces[y, x + 1]) if x + 1 < pieces.shape[1] else -1
    return int(pieces[y + 1, x]) if y + 1 < pieces.shape[0] else -1


@compiled_part
def differ(here: int, there: int, kept: NDArray[np.bool_]) -> bool:
    """Whether two neighbouring pixels lie in two pieces, one of them small."""
    return here != there and here >= 0 and there >= 0 and not (kept[here] and kept[there])


@compiled
def list_borders(
    pieces: NDArray[np.int32],
    kept: NDArray[np.bool_],
    ends: NDArray[np.int64],
    touching: NDArray[np.int32],
) -> None:
    """List the pieces that each one touches, once for every pair of pixels.

    ``ends`` comes in as the starts of the lists and goes out as their ends.
    """
    height, width = pieces.shape
    for y in range(height):
        for x in range(width):
            here = pieces[y, x]
            for side in range(2):
                there = beside(pieces, y, x, side)
                if differ(here, there, kept):
                    touching[ends[here]] = there
                    ends[here] += 1
                    touching[ends[there]] = here
                    ends[there] += 1


@compiled
def take_from_adjacent(
    starts: NDArray[np.int64],
    touching: NDArray[np.int32],
    rank: NDArray[np.int64],
    kept: NDArray[np.bool_],
    queue: NDArray[np.int32],
    votes: NDArray[np.int64],
) -> None:
    """Give small pieces the label most common beside them, round by round from the kept outwards.

    ``rank`` holds the place of each piece's label among all labels, so that of equal votes the
    lowest label wins; ``votes``, one for each label, comes in with zeros. The pieces of a round
    vote by those of the rounds before it: they become kept only when the round is over.
    """
    first, last = 0, 0
    for piece in range(kept.size):
        if kept[piece] and starts[piece] < starts[piece + 1]:
            queue[last] = piece
            last += 1
    while first < last:
        end = last
        for i in range(first, end):
            piece = queue[i]
            for j in range(starts[piece], starts[piece + 1]):
                other = touching[j]
                if not kept[other] and rank[other] >= 0:
                    rank[other] = -1  # waits for its label: in the queue once
                    queue[last] = other
                    last += 1
        for i in range(end, last):
            rank[queue[i]] = mode_around(starts, touching, rank, kept, votes, queue[i])
        for i in range(end, last):
            kept[queue[i]] = True
        first = end


@compiled_part
def mode_around(
    starts: NDArray[np.int64],
    touching: NDArray[np.int32],
    rank: NDArray[np.int64],
    kept: NDArray[np.bool_],
    votes: NDArray[np.int64],
    piece: int,
) -> int:
    """Return the label with most votes among the kept pieces around one, the lowest of equals."""
    for j in range(starts[piece], starts[piece + 1]):
        if kept[touching[j]]:
            votes[rank[touching[j]]] += 1
    best, most = -1, 0
    for j in range(starts[piece], starts[piece + 1]):
        if kept[touching[j]]:
            label = rank[touching[j]]
            if votes[label] > most or (votes[label] == most and label < best):
                best, most = label, votes[label]
    for j in range(starts[piece], starts[piece + 1]):
        if kept[touching[j]]:
            votes[rank[touching[j]]] = 0
    return best
