"""Segments changed by hand: merged, split, grown by a pick, with every step to be taken back."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.merge.levels import Levels

Labels = NDArray[np.int32]


class Editing:
    """The segments of a scene while somebody changes them.

    Whole fine regions change hands: those of the tree of merges where there is one, else the
    segments. A segment keeps its number through all steps; new ones get the next free number.

    Parameters
    ----------
    labels : (H, W) or (N,) int32
        Segments, -1 = none.
    levels : Levels, optional
        Nested segmentations of the same scene, along which segments are split and grown.

    Examples
    --------
    >>> from geohue.merge.tree import MergeTree
    >>> tree = MergeTree(3, np.array([[0, 1], [0, 2]]), np.array([-1.0, 2.0]))
    >>> edit = Editing(np.int32([0, 0, 1]), Levels(np.int32([0, 1, 2]), tree))
    >>> edit.split(0)
    [0, 2]
    >>> edit.labels.tolist(), edit.merge([1, 2]), edit.labels.tolist()
    ([0, 2, 1], 1, [0, 1, 1])
    >>> edit.undo(), edit.undo(), edit.labels.tolist()
    (True, True, [0, 0, 1])
    """

    def __init__(self, labels: Labels, levels: Levels | None = None) -> None:
        self._levels = levels
        finest = labels if levels is None else levels.regions
        if finest.shape != labels.shape:
            raise GeohueError(f"labels have shape {labels.shape}, the levels {finest.shape}")
        # A segment may be a part of a region, where connected pieces were numbered one by one.
        width = np.int64(finest.max(initial=-1)) + 2
        keys = (labels.astype(np.int64) + 1) * width + finest + 1
        found, place = np.unique(keys, return_inverse=True)
        self._atoms = place.reshape(labels.shape)
        self._region = (found % width - 1).astype(np.int64)
        self._now = (found // width - 1).astype(np.int32)
        self._past: list[Labels] = []
        self._future: list[Labels] = []

    @property
    def labels(self) -> Labels:
        """The segment of each pixel or point now; int32, -1 = none."""
        return np.asarray(self._now[self._atoms])

    @property
    def ids(self) -> list[int]:
        """The numbers of the segments that there are now."""
        return [int(name) for name in np.unique(self._now[self._now >= 0])]

    def merge(self, segments: list[int]) -> int:
        """Make several segments one; return its number, the lowest of theirs.

        Raises
        ------
        GeohueError
            If fewer than two are named, or one is not there.
        """
        names = sorted(set(segments))
        if len(names) < 2:
            raise GeohueError(f"merging needs two segments, not {segments}")
        for name in names:
            self._check(name)
        self._step(np.where(np.isin(self._now, names), np.int32(names[0]), self._now))
        return names[0]

    def split(self, segment: int) -> list[int]:
        """Split a segment where its parts were merged last; return the numbers of the parts.

        The largest part keeps the number. Parts that never merge, pieces that lie apart, come
        asunder all at once.

        Raises
        ------
        GeohueError
            If the segment is not there, or nothing finer is known of it.
        """
        self._check(segment)
        atoms = np.flatnonzero(self._now == segment)
        part = self._parts(atoms)
        if part.max() == 0:
            raise GeohueError(f"segment {segment} is one of the finest regions: it has no parts")
        size = np.bincount(self._atoms.reshape(-1), minlength=len(self._now))[atoms]
        largest = int(np.bincount(part, size).argmax())
        rest = [p for p in range(int(part.max()) + 1) if p != largest]
        names = np.full(len(rest) + 1, segment, np.int32)
        names[rest] = self._next() + np.arange(len(rest), dtype=np.int32)
        after = self._now.copy()
        after[atoms] = names[part]
        self._step(after)
        return [segment, *names[rest].tolist()]

    def grow(self, segment: int) -> int:
        """Join to a segment the one that it would merge with next; return the number of that one.

        Raises
        ------
        GeohueError
            If the segment is not there, or merges with no other.
        """
        self._check(segment)
        other = self._merges_next(segment)
        if other is None:
            raise GeohueError(f"segment {segment} merges with no other: name one to merge it with")
        self._step(np.where(self._now == other, np.int32(segment), self._now))
        return other

    def take(self, segment: int, position: int) -> None:
        """Give a segment the fine region at a flat position in the scene, whoever has it.

        Raises
        ------
        GeohueError
            If the segment is not there, or nothing has a label at that position.
        """
        self._check(segment)
        if not 0 <= position < self._atoms.size:
            raise GeohueError(f"position {position}: the scene has {self._atoms.size} points")
        atom = self._atoms.reshape(-1)[position]
        if self._now[atom] < 0:
            raise GeohueError(f"no label at position {position}: nothing to take")
        after = self._now.copy()
        after[atom] = segment
        self._step(after)

    def undo(self) -> bool:
        """Take the last step back; return whether there was one."""
        return self._move(self._past, self._future)

    def redo(self) -> bool:
        """Take again the last step that was taken back; return whether there was one."""
        return self._move(self._future, self._past)

    def _move(self, source: list[Labels], target: list[Labels]) -> bool:
        if source:
            target.append(self._now)
            self._now = source.pop()
            return True
        return False

    def _step(self, after: Labels) -> None:
        self._past.append(self._now)
        self._future.clear()
        self._now = after

    def _next(self) -> np.int32:
        """A number that no segment has or had in a step that can be taken back."""
        states = [self._now, *self._past]
        return np.int32(max(int(state.max(initial=-1)) for state in states) + 1)

    def _check(self, segment: int) -> None:
        if segment < 0 or not (self._now == segment).any():
            raise GeohueError(f"there is no segment {segment}: choose among {_some(self.ids)}")

    def _parts(self, atoms: NDArray[np.int64]) -> NDArray[np.int64]:
        """The part of each atom of one segment after its last merge is taken back."""
        regions = self._region[atoms]
        inside, place = np.unique(regions, return_inverse=True)
        known = inside >= 0
        if self._levels is None or not known.any():
            return np.zeros(len(atoms), np.int64)
        kept = np.zeros(self._levels.tree.n_regions, bool)
        kept[inside[known]] = True
        tree = self._levels.tree.among(kept)
        whole = tree.n_regions - len(tree.merges)  # pieces that never merge
        part = tree.with_segments(whole if whole > 1 else 2)
        full = np.zeros(len(inside), np.int64)  # an atom without a region stays with the first part
        full[known] = part
        return full[place]

    def _merges_next(self, segment: int) -> int | None:
        """The segment of the other side in the first merge that leads out of this one."""
        if self._levels is None:
            return None
        tree = self._levels.tree
        owner = np.full(tree.n_regions, -1, np.int64)
        placed = (self._region >= 0) & (self._now >= 0)
        owner[self._region[placed]] = self._now[placed]
        members = {int(r): {int(o)} for r, o in enumerate(owner) if o >= 0}
        for one, other in tree.merges.tolist():
            a, b = members.get(one, set()), members.pop(other, set())
            for near, far in ((a, b), (b, a)):
                if segment in near and far - {segment}:
                    return min(far - {segment})
            members[one] = a | b
        return None


def _some(ids: list[int]) -> str:
    shown = ", ".join(map(str, ids[:12]))
    return shown + (", ..." if len(ids) > 12 else "")
