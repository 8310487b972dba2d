"""Segments changed by hand: laws of merging, splitting, growing and taking back."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from geohue import GeohueError, Scene, segment
from geohue.merge.levels import Levels
from geohue.merge.tree import MergeTree
from geohue.objects import Editing


def editing() -> Editing:
    """Regions 0..4 in a row: 0 and 1 merge, then 2 and 3, then these; 4 stays apart."""
    merges = np.array([[0, 1], [2, 3], [0, 2]])
    tree = MergeTree(5, merges, np.array([-3.0, -2.0, -1.0]))
    regions = np.repeat(np.arange(5, dtype=np.int32), [2, 3, 2, 2, 4])
    return Editing(tree.at(0.0)[regions], Levels(regions, tree))


def test_splitting_follows_the_tree_down_to_its_regions() -> None:
    edit = editing()
    assert edit.split(0) == [0, 2]
    assert edit.labels.tolist() == [0] * 5 + [2] * 4 + [1] * 4
    assert edit.split(0) == [0, 3]  # the larger part keeps the number
    assert edit.labels.tolist() == [3] * 2 + [0] * 3 + [2] * 4 + [1] * 4
    with pytest.raises(GeohueError, match="segment 1 is one of the finest regions"):
        edit.split(1)


def test_splitting_what_never_merged_parts_the_pieces() -> None:
    edit = editing()
    assert edit.merge([1, 0]) == 0
    assert edit.split(0) == [0, 2]
    assert edit.labels.tolist() == [0] * 9 + [2] * 4


def test_growing_takes_the_next_of_the_tree() -> None:
    edit = editing()
    edit.split(0)
    edit.split(0)
    assert edit.grow(0) == 3
    assert edit.grow(0) == 2
    with pytest.raises(GeohueError, match="merges with no other"):
        edit.grow(0)


def test_taking_a_region_by_a_pick() -> None:
    edit = editing()
    edit.take(1, 5)
    assert edit.labels.tolist() == [0] * 5 + [1] * 2 + [0] * 2 + [1] * 4
    with pytest.raises(GeohueError, match="position 13"):
        edit.take(1, 13)
    with pytest.raises(GeohueError, match="no segment 7: choose among 0, 1"):
        edit.take(7, 0)
    with pytest.raises(GeohueError, match="no label"):
        Editing(np.array([0, -1], np.int32)).take(0, 1)


def test_numbers_are_not_given_twice() -> None:
    edit = editing()
    edit.split(0)  # 2 is new
    edit.merge([0, 2])
    assert edit.split(0) == [0, 3]


def step(edit: Editing, name: int, rng: np.random.Generator) -> bool:
    """Take some step with a segment; whether it could be taken."""
    kind, other = int(rng.integers(4)), int(rng.choice(edit.ids))
    try:
        if kind == 0:
            edit.split(name)
        elif kind == 1:
            edit.grow(name)
        elif kind == 2:
            edit.merge([name, other])
        else:
            edit.take(name, int(rng.integers(13)))
    except GeohueError:
        return False
    return True


@given(seed=st.integers(0, 999))
@settings(max_examples=30, deadline=None)
def test_every_step_can_be_taken_back_and_again(seed: int) -> None:
    rng = np.random.default_rng(seed)
    edit = editing()
    states = [edit.labels]
    for _ in range(8):
        name = int(rng.choice(edit.ids))
        if step(edit, name, rng):
            states.append(edit.labels)
    for state in states[-2::-1]:
        assert edit.undo()
        assert (edit.labels == state).all()
    assert not edit.undo()
    for state in states[1:]:
        assert edit.redo()
        assert (edit.labels == state).all()
    assert not edit.redo()


def test_a_step_forgets_what_was_taken_back() -> None:
    edit = editing()
    edit.split(0)
    edit.undo()
    edit.merge([0, 1])
    assert not edit.redo()


def test_pieces_of_one_region_are_changed_one_by_one() -> None:
    levels = Levels(
        np.array([0, 0, 0], np.int32), MergeTree(1, np.zeros((0, 2), np.int64), np.zeros(0))
    )
    edit = Editing(np.array([0, 1, 2], np.int32), levels)
    edit.merge([0, 2])
    assert edit.labels.tolist() == [0, 1, 0]


def test_without_levels_there_is_nothing_finer() -> None:
    edit = Editing(np.array([0, 1, -1], np.int32))
    for step in (edit.split, edit.grow):
        with pytest.raises(GeohueError):
            step(0)
    with pytest.raises(GeohueError, match="two segments"):
        edit.merge([1, 1])
    with pytest.raises(GeohueError, match="shape"):
        Editing(np.array([0], np.int32), editing()._levels)


def test_an_edited_segmentation(three_boxes: tuple[Scene, NDArray[np.int32]]) -> None:
    seg = segment(three_boxes[0])
    edit = seg.edit()
    assert (edit.labels == seg.labels).all()
    edit.merge([0, seg.k - 1])
    after = seg.edited(edit)
    assert after.k == seg.k - 1
    assert after.k == int(after.labels.max()) + 1
    assert after.segments[0].area > seg.segments[0].area
    with pytest.raises(GeohueError, match="shape"):
        seg.edited(Editing(np.array([0], np.int32)))
