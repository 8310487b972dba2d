"""What every sensor becomes: colours, points, a grid where there is one, and what is missing."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geohue.camera import Intrinsics
from geohue.errors import GeohueError
from geohue.scene.thinning import thin_cloud, thin_grid

if TYPE_CHECKING:
    from geohue.stereo.pair import StereoPair


_OF_EACH_POINT = ("colors", "points", "depth", "second_colors", "unseen", "normals", "left_out")


@dataclass(frozen=True, slots=True, eq=False)
class SceneData:
    """The colours and the geometry of a scene.

    Attributes
    ----------
    colors : (H, W, 3) or (N, 3) uint8
        sRGB.
    points : (H, W, 3) or (N, 3) float32
        Position of each pixel or point in any unit; NaN in all three where there is none.
    depth : (H, W) float32 or None
        The depth map, NaN where missing; None for a cloud, whose geometry has no preferred axis.
    intrinsics : Intrinsics or None
        The camera of an RGB-D frame.
    second_colors : uint8, shape of `colors`, or None
        The same points as another camera sees them: the right view warped to the left (eq. 18).
    warnings : tuple of str
        Guesses and repairs that the user should know of.
    unseen : bool, shape of the labels, or None
        Range points that no camera sees: they have a position but no colour of their own
        (`colors` has the nearest point's), and take no part in the segmentation.
    normals : float32, shape of `points`, or None
        Surface normals of length 1 that came with a cloud; NaN in all three where there is none.
    offset : (float, float, float)
        What was taken from the coordinates of a cloud: not zero for map coordinates, which float32
        would blur.
    source : Path or None
        The cloud's file, whose points are those of the scene in its order.
    has_colors : bool
        False where the sensor gave no colour: `colors` is grey then, and `geohue.segment` goes by
        the geometry alone.
    left_out : bool, shape of the labels, or None
        Pixels outside of a mask: they have no geometry, and get no label.
    pair : geohue.stereo.StereoPair or None
        The stereo pair that the scene was made of.
    """

    colors: NDArray[np.uint8]
    points: NDArray[np.float32]
    depth: NDArray[np.float32] | None = None
    intrinsics: Intrinsics | None = None
    second_colors: NDArray[np.uint8] | None = None
    warnings: tuple[str, ...] = ()
    unseen: NDArray[np.bool_] | None = None
    normals: NDArray[np.float32] | None = None
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    source: Path | None = None
    has_colors: bool = True
    left_out: NDArray[np.bool_] | None = None
    pair: StereoPair | None = None

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the labels: (H, W) or (N,)."""
        return self.colors.shape[:-1]

    @property
    def is_grid(self) -> bool:
        """Whether the points lie on a pixel grid."""
        return len(self.shape) == 2

    @property
    def size(self) -> int:
        """Number of pixels or points, with and without geometry."""
        return int(np.prod(self.shape))

    @property
    def valid(self) -> NDArray[np.bool_]:
        """Where there is geometry with a colour, in the shape of the labels."""
        known = np.isfinite(self.points[..., 2])
        return known if self.unseen is None else known & ~self.unseen

    def thinning(self, max_points: int, rng: np.random.Generator) -> NDArray[np.int64]:
        """Choose at most about `max_points` points that stand for the scene.

        A grid keeps every n-th row and column, so that windows and regions keep their meaning; more
        of them where its depth is so sparse that hardly a point would be left.
        A cloud keeps a random subset, drawn from the points in the order of their colour and
        then their distance from the centre: neither the order of the points in the file nor the
        pose of the scene changes which points are drawn.

        Parameters
        ----------
        max_points : int
            Most points to keep, about.
        rng : numpy.random.Generator
            The source of chance.

        Returns
        -------
        (h, w) or (m,) int64
            Flat positions in the scene, for `take`.
        """
        if self.is_grid:
            return thin_grid(self.valid, max_points)
        return thin_cloud(self.colors, self.points, self.unseen, max_points, rng)

    def take(self, positions: NDArray[np.int64]) -> Self:
        """Return the scene at some flat positions, in the shape of `positions`."""
        changes: dict[str, Any] = {"source": None, "pair": None}
        for name in _OF_EACH_POINT:
            values = getattr(self, name)
            if values is not None:
                changes[name] = values.reshape(-1, *values.shape[len(self.shape) :])[positions]
        return replace(self, **changes)

    def masked(self, mask: ArrayLike) -> Self:
        """Return the scene without the pixels or points where a mask is 0 or False.

        Parameters
        ----------
        mask : bool or number, shape of the labels
            What to keep. What is left out has no geometry, and gets the label -1.

        Raises
        ------
        GeohueError
            If the mask has another shape, or keeps nothing.

        Examples
        --------
        >>> from geohue import Scene
        >>> scene = Scene.from_cloud(np.eye(3), np.eye(3)).masked([1, 0, 1])
        >>> scene.valid.tolist(), scene.left_out.tolist()
        ([True, False, True], [False, True, False])
        """
        keep = np.asarray(mask)
        if keep.shape != self.shape or keep.dtype.kind not in "biuf":
            raise GeohueError(
                f"the mask has shape {keep.shape} and type {keep.dtype}: expected numbers in the "
                f"shape of the labels, {self.shape}"
            )
        out = ~(keep != 0)
        if out.all():
            raise GeohueError("the mask keeps nothing: it must not be 0 where the scene is wanted")
        points = np.where(out[..., None], np.float32(np.nan), self.points)
        depth = None if self.depth is None else np.where(out, np.float32(np.nan), self.depth)
        return replace(self, points=points, depth=depth, left_out=out)
