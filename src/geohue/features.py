"""Sec. II, V: colour and geometry of each point in one vector (eq. 1-5, 19)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.scene import Scene

SAME_COLOR = "all colours are equal: colour says nothing here"
SAME_PLACE = "all points lie in one place: geometry says nothing here"

FLOOR = 1e-6
"""A spread below this share of the numbers is rounding of these, not structure."""

Cues = Literal["fusion", "color", "geometry"]
CUES: tuple[Cues, ...] = get_args(Cues)


@dataclass(frozen=True, slots=True, eq=False)
class Features:
    """The normalised colour and geometry of the points that take part in the segmentation.

    The two parts stay separate because only their mix depends on the weight.

    Attributes
    ----------
    color : (M, 3) or (M, 6) float32
        Normalised L, a, b (eq. 4), of both views if there are two (eq. 19); zeros if the cue is
        not used or does not vary.
    geometry : (M, 3) float32
        Normalised x, y, z (eq. 3); zeros likewise.
    index : (M,) int64
        Flat position of each row in the scene.
    shape : tuple of int
        Shape of the scene's labels.
    cues : {"fusion", "color", "geometry"}
        The cues in use.
    notes : tuple of str
        What the user should know: a cue that does not vary.
    """

    color: NDArray[np.float32]
    geometry: NDArray[np.float32]
    index: NDArray[np.int64]
    shape: tuple[int, ...]
    cues: Cues
    notes: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.index)

    def vectors(self, weight: float) -> NDArray[np.float32]:
        """Return the vectors p^f of eq. 5, or of eq. 19 for two views.

        Parameters
        ----------
        weight : float
            The paper's lambda, finite and not negative.

        Returns
        -------
        (M, 6) or (M, 9) float32
            L, a, b of each view and lambda times x, y, z.
        """
        return np.hstack([self.color, np.float32(weight) * self.geometry])

    def mixed(self, weight: float) -> NDArray[np.float32]:
        """Return the vectors of eq. 5 or 19 divided by ``sqrt(v + lambda^2)`` for v views.

        The division keeps the spread of the vectors the same for every weight, so that one
        affinity scale serves from lambda = 0 (colour only) to infinity (geometry only). It is
        the same as an affinity scale that grows with ``sqrt(v + lambda^2)``.

        Parameters
        ----------
        weight : float
            The paper's lambda, 0 to infinity.

        Returns
        -------
        (M, 6) or (M, 9) float32
        """
        views = np.sqrt(self.color.shape[1] / 3)
        angle = np.arctan(weight / views)
        shares = np.float32(np.cos(angle) / views), np.float32(np.sin(angle))
        out = np.empty((len(self), self.color.shape[1] + 3), np.float32)
        columns = [*self.color.T, *self.geometry.T]
        # Column by column: numpy's loops are slow over rows as short as these.
        for j, column in enumerate(columns):
            np.multiply(column, shares[j >= len(columns) - 3], out=out[:, j])
        return out

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
        return Features(
            self.color.take(rows, axis=0),
            self.geometry.take(rows, axis=0),
            index,
            positions.shape,
            self.cues,
            self.notes,
        )

    def to_scene(self, labels: NDArray[np.int32]) -> NDArray[np.int32]:
        """Put the label of each row in its place in the scene; -1 elsewhere."""
        if len(labels) == np.prod(self.shape):
            return labels.reshape(self.shape)
        full = np.full(int(np.prod(self.shape)), -1, np.int32)
        full[self.index] = labels
        return full.reshape(self.shape)


def extract_features(scene: Scene, cues: Cues = "fusion") -> Features:
    """Represent each point by its normalised colour and geometry (eq. 1-4).

    Parameters
    ----------
    scene : Scene
        The scene; points without a value for a used cue take no part.
    cues : {"fusion", "color", "geometry"}
        The cues to use.

    Returns
    -------
    Features

    Raises
    ------
    GeohueError
        If no point has the cues asked for.

    Examples
    --------
    >>> rgb = np.random.default_rng(0).integers(0, 255, (8, 9, 3)).astype(np.uint8)
    >>> f = extract_features(Scene.from_rgbd(rgb, np.ones((8, 9))))
    >>> f.vectors(2.0).shape, bool(np.isclose(f.color.std(axis=0).mean(), 1.0, atol=1e-4))
    ((72, 6), True)
    """
    if cues not in CUES:
        raise GeohueError(f"cues {cues!r}: choose one of {', '.join(CUES)}")
    mask = np.ones(scene.shape, bool) if cues == "color" else scene.valid
    index = np.flatnonzero(mask)
    if len(index) == 0:
        raise GeohueError(
            'no point has a position (all depth is missing): give depth, or use cues="color"'
            if scene.size
            else "the scene has no points"
        )
    zeros = np.zeros((len(index), 3), np.float32)
    color = geometry = zeros
    notes: list[str] = []
    if cues != "geometry":
        color, constant = _color_part(scene, index)
        notes += [SAME_COLOR] * constant
    if cues != "color":
        geometry, constant = _normalized(_rows(scene.points, index))
        notes += [SAME_PLACE] * constant
    return Features(color, geometry, index, scene.shape, cues, tuple(notes))


def _color_part(scene: Scene, index: NDArray[np.int64]) -> tuple[NDArray[np.float32], bool]:
    """Normalise the colours of each view by its own deviation (eq. 4, 19)."""
    color, constant = _normalized(_rows(lab_of(scene.colors), index))
    if scene.second_colors is None:
        return color, constant
    second, _ = _normalized(_rows(lab_of(scene.second_colors), index))
    return np.hstack([color, second]), constant


def lab_of(colors: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Convert sRGB to CIELab, D65 (eq. 1).

    OpenCV converts, much faster than scikit-image and within 0.5 Lab units of it.

    Parameters
    ----------
    colors : (..., 3) uint8
        sRGB.

    Returns
    -------
    (..., 3) float32
        L in 0..100; a and b within about -128..127.

    Examples
    --------
    >>> lab_of(np.array([[255, 255, 255]], np.uint8)).round().tolist()
    [[100.0, 0.0, 0.0]]
    """
    import cv2

    if colors.size == 0:
        return np.zeros(colors.shape, np.float32)
    unit = colors.astype(np.float32) / np.float32(255)
    # One long row: OpenCV would hand the rows to threads, which wait for each other on a busy
    # machine longer than they save.
    lab = np.asarray(cv2.cvtColor(unit.reshape(1, -1, 3), cv2.COLOR_RGB2Lab), np.float32)
    return lab.reshape(colors.shape)


def _rows(values: NDArray[np.float32], index: NDArray[np.int64]) -> NDArray[np.float32]:
    """Return the values of some points, of all without a copy."""
    flat = values.reshape(-1, 3)
    return flat if len(index) == len(flat) else flat.take(index, axis=0)


def _normalized(values: NDArray[np.float32]) -> tuple[NDArray[np.float32], bool]:
    """Divide by the mean of the three standard deviations (eq. 3, 4), centred.

    Only differences matter later; centring first keeps them exact in float32. A cue without
    spread becomes zeros, and the second value is True.
    """
    n = len(values)
    means, deviations = np.empty(3), np.empty(3)
    column, square = np.empty(n), np.empty(n)
    # Column by column: numpy's loops are slow over rows of three.
    for j in range(3):
        column[:] = values[:, j]
        means[j] = column.mean()
        column -= means[j]
        deviations[j] = np.sqrt(np.multiply(column, column, out=square).mean())
    sigma = float(deviations.mean())
    floor = FLOOR * max(float(values.max(initial=0)), -float(values.min(initial=0)))
    if sigma <= floor:
        return np.zeros(values.shape, np.float32), True
    scaled = np.empty(values.shape, np.float32)
    for j in range(3):
        np.subtract(values[:, j], means[j], out=column)
        np.divide(column, sigma, out=scaled[:, j], casting="same_kind")
    return scaled, False
