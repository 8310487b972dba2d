"""Sec. II, V: the cues of each point in one vector (eq. 5, 19)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from geohue.compute.parallel import Workers
from geohue.errors import GeohueError
from geohue.features.block import Block, Side
from geohue.features.raw import Raw
from geohue.features.registry import cues_named, cues_of
from geohue.scene import Scene


@dataclass(frozen=True, slots=True, eq=False)
class Features:
    """The normalised cues of the points that take part in the segmentation.

    They stay apart, each a block, because only their mix depends on the weight.

    Attributes
    ----------
    blocks : tuple of Block
        Those of colour, then those of geometry; at least one of each, zeros if it is not used.
    index : (M,) int64
        Flat position of each row in the scene.
    shape : tuple of int
        Shape of the scene's labels.
    cues : str
        The cues in use, as in ``cues=``.
    notes : tuple of str
        What the user should know: a cue that does not vary.
    """

    blocks: tuple[Block, ...]
    index: NDArray[np.int64]
    shape: tuple[int, ...]
    cues: str
    notes: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.index)

    @property
    def color(self) -> NDArray[np.float32]:
        """Normalised L, a, b (eq. 4), of both views if there are two (eq. 19): (M, 3) or more."""
        return self._side("color")

    @property
    def geometry(self) -> NDArray[np.float32]:
        """Normalised x, y, z (eq. 3): (M, 3), or more with further cues of geometry."""
        return self._side("geometry")

    @property
    def is_fused(self) -> bool:
        """Whether both colour and geometry are used, so that the weight counts."""
        return self.uses("color") and self.uses("geometry")

    def uses(self, side: Side) -> bool:
        """Whether a cue of this side is used."""
        return any(block.side == side and block.used for block in self.blocks)

    def vectors(self, weight: float) -> NDArray[np.float32]:
        """Return the vectors p^f of eq. 5, or of eq. 19 for two views.

        Parameters
        ----------
        weight : float
            The paper's lambda, finite and not negative.

        Returns
        -------
        (M, D) float32
            Each block by its share: L, a, b of each view and lambda times x, y, z (D is 6 or 9),
            and what further cues have.
        """
        return self._scaled({"color": 1.0, "geometry": weight})

    def mixed(self, weight: float) -> NDArray[np.float32]:
        """Return the vectors of eq. 5 or 19 divided by ``sqrt(v + lambda^2)`` for v views.

        The division keeps the spread of the vectors the same for every weight, so that one
        affinity scale serves from lambda = 0 (colour only) to infinity (geometry only). It is
        the same as an affinity scale that grows with ``sqrt(v + lambda^2)``. With further cues it
        is ``sqrt(v + g lambda^2)``, where v and g are the sums of the squared shares of the blocks
        of colour and of geometry.

        Parameters
        ----------
        weight : float
            The paper's lambda, 0 to infinity.

        Returns
        -------
        (M, D) float32
        """
        color, geometry = self._size("color"), self._size("geometry")
        angle = np.arctan(weight * geometry / color)
        return self._scaled({"color": np.cos(angle) / color, "geometry": np.sin(angle) / geometry})

    def at(self, positions: NDArray[np.int64]) -> Features:
        """Return the features at some positions of the scene (`Scene.thinning`).

        They stay normalised over the whole scene, so that what is learnt from a part of it
        holds for all of it.
        """
        flat = positions.reshape(-1)
        if len(self) == np.prod(self.shape):
            rows, index = flat, np.arange(len(flat))
        else:
            row_of = np.full(int(np.prod(self.shape)), -1, np.int64)
            row_of[self.index] = np.arange(len(self))
            rows = row_of[flat]
            index = np.flatnonzero(rows >= 0)
            rows = rows[index]
        blocks = (replace(block, values=block.values.take(rows, axis=0)) for block in self.blocks)
        return Features(tuple(blocks), index, positions.shape, self.cues, self.notes)

    def to_scene(self, labels: NDArray[np.int32]) -> NDArray[np.int32]:
        """Put the label of each row in its place in the scene; -1 elsewhere."""
        if len(labels) == np.prod(self.shape):
            return labels.reshape(self.shape)
        full = np.full(int(np.prod(self.shape)), -1, np.int32)
        full[self.index] = labels
        return full.reshape(self.shape)

    def _side(self, side: Side) -> NDArray[np.float32]:
        parts = [block.values for block in self.blocks if block.side == side]
        return parts[0] if len(parts) == 1 else np.hstack(parts)

    def _size(self, side: Side) -> float:
        return float(np.sqrt(sum(block.share**2 for block in self.blocks if block.side == side)))

    def _scaled(self, shares: dict[Side, float]) -> NDArray[np.float32]:
        columns = [
            (column, np.float32(shares[block.side] * block.share))
            for block in self.blocks
            for column in block.values.T
        ]
        out = np.empty((len(self), len(columns)), np.float32)
        # Column by column: numpy's loops are slow over rows as short as these.
        for j, (column, share) in enumerate(columns):
            np.multiply(column, share, out=out[:, j])
        return out


def extract_features(
    scene: Scene, cues: str = "fusion", raw: Raw | None = None, workers: Workers | None = None
) -> Features:
    """Represent each point by its normalised colour and geometry (eq. 1-4).

    Parameters
    ----------
    scene : Scene
        The scene; points without a position take no part where geometry is used.
    cues : str
        "fusion", "color" or "geometry", with those of `register_cue` after a plus sign.
    raw : Raw, optional
        What is derived from the scene, where it is there already.
    workers : Workers, optional
        Threads to use, a cue each; by default the calling one.

    Returns
    -------
    Features

    Raises
    ------
    GeohueError
        For unknown cues, or if no point has the cues asked for.

    Examples
    --------
    >>> rgb = np.random.default_rng(0).integers(0, 255, (8, 9, 3)).astype(np.uint8)
    >>> f = extract_features(Scene.from_rgbd(rgb, np.ones((8, 9))))
    >>> f.vectors(2.0).shape, bool(np.isclose(f.color.std(axis=0).mean(), 1.0, atol=1e-4))
    ((72, 6), True)
    """
    cues = cues_of(scene, cues)
    used = cues_named(cues)
    solid = any(cue.side == "geometry" for cue in used)
    index = np.flatnonzero(scene.valid if solid else np.ones(scene.shape, bool))
    if len(index) == 0:
        raise GeohueError(
            'no point has a position (all depth is missing): give depth, or use cues="color"'
            if scene.size
            else "the scene has no points"
        )
    values, team = raw or Raw(scene), workers or Workers(None)
    made = list(team.map(lambda cue: cue.block(values, index), used))
    found = [(cue, *one) for cue, one in zip(used, made, strict=True) if one is not None]
    notes = tuple(cue.constant for cue, _, constant in found if constant and cue.constant)
    blocks = _with_both_sides([block for _, block, _ in found], len(index))
    return Features(blocks, index, scene.shape, cues, notes)


def _with_both_sides(blocks: list[Block], n: int) -> tuple[Block, ...]:
    """Add zeros for a side without a cue: the vectors have the columns of eq. 5 at the least."""
    sides: tuple[Side, ...] = ("color", "geometry")
    zeros = np.zeros((n, 3), np.float32)
    full: list[Block] = []
    for side in sides:
        own = [block for block in blocks if block.side == side]
        full += own or [Block(side, side, zeros, used=False)]
    return tuple(full)
