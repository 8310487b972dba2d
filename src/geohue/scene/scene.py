"""What every sensor becomes: colours, points, a grid where there is one, and what is missing."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geohue.camera import Intrinsics
from geohue.compute.checks import (
    centered,
    check_cloud_colors,
    check_depth,
    check_disparity,
    check_image,
    check_normals,
    is_real,
)
from geohue.errors import GeohueError
from geohue.scene.thinning import thin_cloud, thin_grid

if TYPE_CHECKING:
    from collections.abc import Sequence

    from geohue.sensors.rig import Rig
    from geohue.stereo.pair import StereoPair
    from geohue.stereo.rig import StereoRig


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """A scene with colour and geometry, whatever it was recorded with.

    Build one with `from_rgbd`, `from_stereo`, `from_cloud`, `from_range_and_cameras` or
    `from_image`: they check the input and turn every invalid value into a gap, so that nothing
    after them has to.

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

    @classmethod
    def from_rgbd(
        cls,
        rgb: ArrayLike,
        depth: ArrayLike,
        intrinsics: Intrinsics | None = None,
        depth_scale: float | None = None,
    ) -> Scene:
        """Make a scene from an image and a depth map registered to it.

        Parameters
        ----------
        rgb : (H, W, 3) uint8, or (H, W) uint8 for a grey camera
            The image, sRGB.
        depth : (H, W) float or integer
            Metres as floats, or sensor units together with `depth_scale`. Zero, negative, NaN
            and infinite values are missing.
        intrinsics : Intrinsics, optional
            The camera; scaled when it was given for another image size. Without it, a typical
            depth camera is assumed, with a warning: parts are found either way, but not at
            their true proportions.
        depth_scale : float, optional
            Metres per unit (0.001 for millimetres).

        Returns
        -------
        Scene

        Raises
        ------
        GeohueError
            For sizes that differ, a depth map with channels, colours that are not 8-bit, or
            integer depth without a scale.

        Examples
        --------
        >>> import numpy as np
        >>> scene = Scene.from_rgbd(np.zeros((4, 6, 3), np.uint8), np.ones((4, 6)))
        >>> scene.shape, int(scene.valid.sum()), len(scene.warnings)
        ((4, 6), 24, 1)
        """
        colors = check_image(rgb)
        metres = check_depth(depth, colors.shape[:2], depth_scale)
        height, width = metres.shape
        warnings: tuple[str, ...] = ()
        if intrinsics is None:
            intrinsics = Intrinsics.guess(width, height)
            warnings = (
                f"no intrinsics given: assuming a typical depth camera "
                f"(fx = fy = {intrinsics.fx:.0f} px, centre of the image)",
            )
        elif (intrinsics.width, intrinsics.height) not in ((width, height), (None, None)):
            warnings = (
                f"intrinsics are for {intrinsics.width} x {intrinsics.height}: "
                f"scaled to the image's {width} x {height}",
            )
        camera = intrinsics.scaled_to(width, height)
        return cls(colors, camera.unproject(metres), metres, camera, warnings=warnings)

    @classmethod
    def from_cloud(
        cls, points: ArrayLike, colors: ArrayLike, normals: ArrayLike | None = None
    ) -> Scene:
        """Make a scene from a coloured point cloud, organised on a grid or not.

        Parameters
        ----------
        points : (N, 3) or (H, W, 3) float
            Coordinates in any unit and frame; non-finite points are missing.
        colors : (N, 3) or (H, W, 3) uint8, or float in 0..1
            sRGB.
        normals : float, shape of `points`, optional
            Surface normals of any length; zero and not finite ones are missing.

        Returns
        -------
        Scene
            With a grid if the arrays are (H, W, 3).

        Raises
        ------
        GeohueError
            If the shapes differ or the colours are neither 8-bit nor floats in 0..1.

        Examples
        --------
        >>> import numpy as np
        >>> Scene.from_cloud(np.zeros((5, 3)), np.full((5, 3), 0.5)).colors[0].tolist()
        [128, 128, 128]
        """
        xyz = np.asarray(points)
        if xyz.ndim not in (2, 3) or xyz.shape[-1] != 3 or not is_real(xyz):
            raise GeohueError(
                f"points have shape {xyz.shape} and type {xyz.dtype}: "
                "expected (N, 3) or (H, W, 3) numbers"
            )
        rgb = check_cloud_colors(np.asarray(colors), xyz.shape)
        near, offset = centered(xyz)
        return cls(rgb, near, normals=check_normals(normals, xyz.shape), offset=offset)

    @classmethod
    def from_stereo(
        cls,
        left: ArrayLike,
        right: ArrayLike,
        rig: StereoRig | None = None,
        disparity: ArrayLike | None = None,
        views: Literal[1, 2] = 2,
        *,
        disparity_range: tuple[int, int] | None = None,
    ) -> Scene:
        """Make a scene of the left view of a stereo pair (Sec. V).

        Parameters
        ----------
        left, right : (H, W, 3) uint8, or (H, W) uint8 for grey cameras
            The images, sRGB; rectified here if `rig` is that of the raw images.
        rig : StereoRig, optional
            The calibration (`geohue.stereo.StereoRig`). Without it a typical camera is assumed,
            with a warning: depth is up to scale.
        disparity : (H, W) float, optional
            Of the rectified left image: x in the left minus x in the right image, in pixels.
            NaN and infinite values are missing. Without it the pair is matched.
        views : {1, 2}
            Whether the right view's colours take part (eq. 19) or the left one's alone (eq. 5).
        disparity_range : (int, int), optional
            Smallest and largest disparity to look for, where the pair is matched.

        Returns
        -------
        Scene
            The left view. For the right one see `geohue.stereo.StereoPair.swapped`.

        Raises
        ------
        GeohueError
            For images of different size, a blank image, exchanged images, a disparity of the
            wrong sign, or a calibration that cannot rectify the pair.

        Examples
        --------
        >>> import numpy as np
        >>> noise = np.random.default_rng(0).integers(0, 256, (60, 90, 3)).astype(np.uint8)
        >>> scene = Scene.from_stereo(noise[:, :-8], noise[:, 8:])
        >>> scene.shape, scene.second_colors is not None, len(scene.warnings)
        ((60, 82), True, 1)
        """
        from geohue.stereo.pair import StereoPair

        images = check_image(left), check_image(right)
        known = None if disparity is None else check_disparity(disparity)
        pair = StereoPair.prepare(*images, rig, known, disparity_range=disparity_range)
        return cls.from_pair(pair, views)

    @classmethod
    def from_pair(cls, pair: StereoPair, views: Literal[1, 2] = 2) -> Scene:
        """Make a scene of the left view of a prepared pair.

        Parameters
        ----------
        pair : geohue.stereo.StereoPair
            The rectified images with their disparities.
        views : {1, 2}
            Whether the right view's colours take part (eq. 19) or not (eq. 5).

        Returns
        -------
        Scene

        Raises
        ------
        GeohueError
            For another number of views.
        """
        if views not in (1, 2):
            raise GeohueError(f"views is {views!r}: expected 1 (left colours only) or 2 (both)")
        depth, camera = pair.depth, pair.rig.left
        second = pair.warp().colors if views == 2 else None
        return cls(pair.left, camera.unproject(depth), depth, camera, second, pair.warnings)

    @classmethod
    def from_range_and_cameras(
        cls,
        points: ArrayLike,
        images: Sequence[ArrayLike],
        rig: Rig,
        views: Literal[1, 2] = 2,
        choice: Literal["first", "blend"] = "first",
    ) -> Scene:
        """Make a scene of range points and the pictures of calibrated cameras (Sec. VI-A).

        Parameters
        ----------
        points : (N, 3), (H, W, 3) or (H, W) float
            Points in the frame of the range sensor, in a time-of-flight camera's grid or not, or
            the depth map of the rig's depth camera. Non-finite ones are missing.
        images : sequence of (h, w, 3) or (h, w) uint8
            A picture of each camera of the rig, in its order.
        rig : Rig
            The calibration (`geohue.sensors.Rig`).
        views : {1, 2}
            Whether the second camera's colours become `second_colors` (eq. 19, where it sees the
            point) or only serve where the first camera sees nothing.
        choice : {"first", "blend"}
            Where several cameras see a point: the colour of the first of them, or the mean.

        Returns
        -------
        Scene
            On the grid of the points, if they have one. `unseen` marks the points in nobody's
            view: `geohue.segment` gives them the label of the nearest labelled one.

        Raises
        ------
        GeohueError
            For shapes that do not fit, more pictures than cameras, or when no camera sees a point.

        Examples
        --------
        >>> import numpy as np
        >>> from geohue import Intrinsics
        >>> from geohue.sensors import Lens, PosedCamera, Rig
        >>> rig = Rig((PosedCamera(Lens(Intrinsics(10.0, 10.0, 4.5, 4.5, 10, 10))),))
        >>> image = np.full((10, 10, 3), 90, np.uint8)
        >>> scene = Scene.from_range_and_cameras([[0, 0, 2], [0, 0, -2]], [image], rig)
        >>> scene.valid.tolist(), scene.unseen.tolist(), scene.colors[0].tolist()
        ([True, False], [False, True], [90, 90, 90])
        """
        from geohue.sensors.trinocular import color_range_points

        xyz = np.asarray(points)
        depth = None
        if xyz.ndim == 2 and xyz.shape[1] != 3:
            depth = check_depth(xyz, xyz.shape, 1.0)
            xyz = rig.points(depth)
        if xyz.ndim not in (2, 3) or xyz.shape[-1] != 3 or not is_real(xyz):
            raise GeohueError(
                f"points have shape {xyz.shape} and type {xyz.dtype}: "
                "expected (N, 3) or (H, W, 3) numbers, or a depth map (H, W)"
            )
        with np.errstate(over="ignore"):
            cast = xyz.astype(np.float32)
        cast[~np.isfinite(cast).all(axis=-1)] = np.nan
        found = color_range_points(cast, [check_image(image) for image in images], rig, choice)
        unseen = (found.seen_by == 0) & np.isfinite(cast[..., 2])
        camera = None
        if cast.ndim == 3 and rig.depth is not None:
            depth = np.ascontiguousarray(cast[..., 2])
            camera = rig.depth.camera.scaled_to(cast.shape[1], cast.shape[0])
        second = found.second_colors if views == 2 else None
        return cls(found.colors, cast, depth, camera, second, found.warnings, unseen)

    @classmethod
    def from_image(cls, rgb: ArrayLike) -> Scene:
        """Make a scene from an image alone, for ``cues="color"``.

        Parameters
        ----------
        rgb : (H, W, 3) or (H, W) uint8
            The image, sRGB.

        Returns
        -------
        Scene
            With all geometry missing.

        Raises
        ------
        GeohueError
            If the image is not 8-bit with one or three channels.
        """
        colors = check_image(rgb)
        return cls(colors, np.full(colors.shape, np.nan, np.float32))

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

    def take(self, positions: NDArray[np.int64]) -> Scene:
        """Return the scene at some flat positions, in the shape of `positions`."""
        changes: dict[str, Any] = {"source": None}
        for name in ("colors", "points", "depth", "second_colors", "unseen", "normals"):
            values = getattr(self, name)
            if values is not None:
                changes[name] = values.reshape(-1, *values.shape[len(self.shape) :])[positions]
        return replace(self, **changes)
