"""What a cue is: values of each point, their normalisation and their share."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.features.block import Block, Side
from geohue.features.normalize import normalized
from geohue.features.raw import Raw

Values = NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class Cue:
    """Something that points are told apart by.

    Attributes
    ----------
    name : str
        As in ``cues=``.
    side : {"color", "geometry"}
        Whether the weight lambda multiplies it.
    values : callable
        From the `Raw` values of a scene to an array in the shape of the scene, with one or more
        channels after it; None where the scene has no such thing. A point whose values are not
        finite takes part without this cue.
    normalize : callable
        From the (M, C) values of the points that take part to normalised ones of mean 0, and
        whether they do not vary.
    share : float
        Size of the normalised values beside the other cues of the side.
    constant : str
        What the user is told where the values do not vary; nothing by default.
    """

    name: str
    side: Side
    values: Callable[[Raw], Values | None]
    normalize: Callable[[Values], tuple[Values, bool]] = normalized
    share: float = 1.0
    constant: str = ""

    def block(self, raw: Raw, index: NDArray[np.int64]) -> tuple[Block, bool] | None:
        """Return the normalised values of some points, and whether they do not vary.

        Parameters
        ----------
        raw : Raw
            The scene.
        index : (M,) int64
            Flat positions of the points.

        Returns
        -------
        (Block, bool) or None
            None where the scene has no such thing.

        Raises
        ------
        GeohueError
            If the values have another shape than the scene.
        """
        values = self.values(raw)
        if values is None:
            return None
        shape = raw.scene.shape
        if values.ndim != len(shape) + 1 or values.shape[:-1] != shape:
            raise GeohueError(
                f"cue {self.name!r}: values of shape {values.shape} for a scene of shape {shape}; "
                "expected one or more channels after that shape"
            )
        rows = _rows(values, index)
        finite = np.isfinite(rows)
        if finite.all():
            scaled, constant = self.normalize(rows)
        else:
            known, scaled = finite.all(axis=1), np.zeros(rows.shape, np.float32)
            constant = True
            if known.any():
                scaled[known], constant = self.normalize(rows[known])
        return Block(self.name, self.side, np.asarray(scaled, np.float32), self.share), constant


def _rows(values: Values, index: NDArray[np.int64]) -> Values:
    """Return the values of some points, of all without a copy."""
    flat = np.asarray(values, np.float32).reshape(-1, values.shape[-1])
    return flat if len(index) == len(flat) else flat.take(index, axis=0)
