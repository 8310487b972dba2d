"""Scenes of every kind of sensor, from arrays or files."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal, Self

import numpy as np
from numpy.typing import ArrayLike

from geohue.compute.checks import check_depth, is_real
from geohue.errors import GeohueError
from geohue.scene.cloud import cloud_given
from geohue.scene.data import SceneData
from geohue.scene.frame import Trust, build_frame, mask_given
from geohue.scene.given import (
    Camera,
    Picture,
    RigCalibration,
    StereoCalibration,
    disparity_given,
    is_path,
    picture_given,
    read,
    rig_given,
    stereo_rig_given,
    tell,
)
from geohue.sensors.orientation import upright

if TYPE_CHECKING:
    from geohue.stereo.pair import StereoPair


@dataclass(frozen=True, slots=True, eq=False)
class Scene(SceneData):
    """A scene with colour and geometry, whatever it was recorded with.

    Build one with `from_rgbd`, `from_stereo`, `from_cloud`, `from_range_and_cameras` or
    `from_image`: they check the input and turn every invalid value into a gap, so that nothing
    after them has to. Wherever they take an array, the path of a file does as well. What the user
    should know is in `warnings`, and given as `GeohueWarning`.

    Images are (H, W, 3), (H, W) for a grey camera or (H, W, 4), whose alpha is not used; uint8,
    uint16 or floats in 0..1; sRGB. The attributes are those of `geohue.scene.SceneData`.
    """

    @classmethod
    def from_rgbd(
        cls,
        rgb: Picture,
        depth: Picture,
        intrinsics: Camera | None = None,
        depth_scale: float | str | None = None,
        *,
        confidence: Picture | None = None,
        least: float | None = None,
        min_depth: float | None = None,
        max_depth: float | None = None,
        mask: Picture | None = None,
    ) -> Self:
        """Make a scene from an image and a depth map registered to it.

        Parameters
        ----------
        rgb : (H, W, 3), (H, W, 4) or (H, W) array, or path
            The image. A file that is marked as turned (EXIF) is turned upright, with the depth map
            and the camera of the same orientation.
        depth : (H, W) or (H, W, 1) float or integer, or path
            Metres as floats, or sensor units together with `depth_scale`. Zero, negative, NaN
            and infinite values are missing. A map of another size and the same proportions is
            scaled to the image, without averaging across edges.
        intrinsics : Intrinsics, (3, 3) array, (fx, fy, cx, cy), dict or path, optional
            The camera; scaled when it was given for another image size. Without it, a typical
            depth camera is assumed, with a warning: parts are found either way, but not at
            their true proportions.
        depth_scale : float or str, optional
            Metres per unit (0.001 for millimetres), or a name such as "tum"; for a file by default
            what the camera says, else 0.001 for integers and 1 for floats.
        confidence : (h, w) array or path, optional
            How sure the sensor is of each pixel of the depth map; higher is surer.
        least : float, optional
            Confidence from which on depth is used; by default half of the highest.
        min_depth, max_depth : float, optional
            Metres; depth outside is not used.
        mask : (H, W) array or path, optional
            0 where the image is to be left out: no geometry, and the label -1.

        Returns
        -------
        Scene

        Raises
        ------
        GeohueError
            For sizes of other proportions, a depth map with channels, colours of another type or
            range, integer depth without a scale, or a file that cannot be read.

        Examples
        --------
        >>> import numpy as np
        >>> scene = Scene.from_rgbd(np.zeros((4, 6, 3), np.uint8), np.ones((4, 6)))
        >>> scene.shape, int(scene.valid.sum()), len(scene.warnings)
        ((4, 6), 24, 1)
        """
        trust = Trust(confidence, least, min_depth, max_depth)
        frame = build_frame(rgb, depth, intrinsics, depth_scale, trust)
        points = frame.camera.unproject(frame.depth)
        scene = cls(frame.colors, points, frame.depth, frame.camera, warnings=frame.notes)
        if mask is not None:
            scene = scene.masked(mask_given(mask, frame.depth.shape, frame.orientation))
        tell(scene.warnings)
        return scene

    @classmethod
    def from_cloud(
        cls,
        points: Picture,
        colors: ArrayLike | None = None,
        normals: ArrayLike | None = None,
    ) -> Self:
        """Make a scene from a point cloud, organised on a grid or not.

        Parameters
        ----------
        points : (N, 3) or (H, W, 3) float, or path
            Coordinates in any unit and frame; non-finite points are missing. A file has its own
            colours and normals.
        colors : (N, 3), (N, 4), (H, W, 3) or (H, W, 4), optional
            sRGB as uint8, uint16 or floats in 0..1; alpha is not used. Without it, the scene is
            segmented by its geometry alone.
        normals : float, shape of `points`, optional
            Surface normals of any length; zero and not finite ones are missing.

        Returns
        -------
        Scene
            With a grid if the arrays are (H, W, 3).

        Raises
        ------
        GeohueError
            If the shapes differ, the colours are of another type or range, or the file cannot be
            read.

        Examples
        --------
        >>> import numpy as np
        >>> Scene.from_cloud(np.zeros((5, 3)), np.full((5, 3), 0.5)).colors[0].tolist()
        [128, 128, 128]
        """
        cloud = cloud_given(points, colors, normals)
        scene = cls(
            cloud.colors,
            cloud.points,
            warnings=cloud.notes,
            normals=cloud.normals,
            has_colors=cloud.has_colors,
            offset=cloud.offset,
            source=cloud.source,
        )
        tell(scene.warnings)
        return scene

    @classmethod
    def from_stereo(
        cls,
        left: Picture,
        right: Picture,
        rig: StereoCalibration | None = None,
        disparity: Picture | None = None,
        views: Literal[1, 2] = 2,
        *,
        disparity_range: tuple[int, int] | None = None,
        disparity_scale: float | str | None = None,
    ) -> Self:
        """Make a scene of the left view of a stereo pair (Sec. V).

        Parameters
        ----------
        left, right : (H, W, 3), (H, W, 4) or (H, W) array, or path
            The images; rectified here if `rig` is that of the raw images.
        rig : StereoRig, dict, (f, baseline[, doffs[, cx, cy]]), (K1, D1, K2, D2, R, T) or path
            The calibration (`geohue.stereo.StereoRig`); a dict has OpenCV's names, or f and
            baseline. Without it a typical camera is assumed, with a warning: depth is up to scale.
        disparity : (H, W) float or path, optional
            Of the rectified left image: x in the left minus x in the right image, in pixels.
            NaN and infinite values are missing. Without it the pair is matched.
        views : {1, 2}
            Whether the right view's colours take part (eq. 19) or the left one's alone (eq. 5).
        disparity_range : (int, int), optional
            Smallest and largest disparity to look for, where the pair is matched.
        disparity_scale : float or str, optional
            Pixels per unit of the disparity map, such as 1/16 or "1/256"; by default 1 for arrays
            and a guess, with a warning, for pictures of whole numbers.

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
        >>> scene = Scene.from_stereo(noise[:, :-8], noise[:, 8:], {"f": 60, "baseline": 0.1})
        >>> scene.shape, scene.second_colors is not None
        ((60, 82), True)
        """
        from geohue.stereo.pair import StereoPair

        images = picture_given(left)[0], picture_given(right)[0]
        if images[0].shape != images[1].shape and is_path(left) and is_path(right):
            sizes = " and ".join(f"{image.shape[1]} x {image.shape[0]}" for image in images)
            raise GeohueError(
                f"{right!s}: differs in size from {left!s}: {sizes}; give a pair of one size"
            )
        known, notes = stereo_rig_given(rig)
        shifts, more = disparity_given(disparity, disparity_scale)
        pair = StereoPair.prepare(*images, known, shifts, disparity_range=disparity_range)
        scene = cls.from_pair(replace(pair, warnings=(*notes, *more, *pair.warnings)), views)
        tell(scene.warnings)
        return scene

    @classmethod
    def from_pair(cls, pair: StereoPair, views: Literal[1, 2] = 2) -> Self:
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
        points = camera.unproject(depth)
        return cls(pair.left, points, depth, camera, second, pair.warnings, pair=pair)

    @classmethod
    def from_range_and_cameras(
        cls,
        points: Picture,
        images: Sequence[Picture],
        rig: RigCalibration,
        views: Literal[1, 2] = 2,
        choice: Literal["first", "blend"] = "first",
    ) -> Self:
        """Make a scene of range points and the pictures of calibrated cameras (Sec. VI-A).

        Parameters
        ----------
        points : (N, 3), (H, W, 3) or (H, W) float, or path
            Points in the frame of the range sensor, in a time-of-flight camera's grid or not, or
            the depth map of the rig's depth camera. Non-finite ones are missing.
        images : sequence of (h, w, 3), (h, w, 4) or (h, w) arrays, or paths
            A picture of each camera of the rig, in its order.
        rig : Rig, dict or path
            The calibration (`geohue.sensors.Rig`, `geohue.read.cameras.rig.read_rig`).
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

        known = rig_given(rig)
        notes: tuple[str, ...] = ()
        if is_path(points):
            points, notes = read("range_points", points, known)
        xyz = np.asarray(points)
        depth = None
        if xyz.ndim == 2 and xyz.shape[1] != 3:
            depth = check_depth(xyz, 1.0)
            xyz = known.points(depth)
        if xyz.ndim not in (2, 3) or xyz.shape[-1] != 3 or not is_real(xyz):
            raise GeohueError(
                f"points have shape {xyz.shape} and type {xyz.dtype}: "
                "expected (N, 3) or (H, W, 3) numbers, or a depth map (H, W)"
            )
        with np.errstate(over="ignore"):
            cast = xyz.astype(np.float32)
        cast[~np.isfinite(cast).all(axis=-1)] = np.nan
        pictures = [picture_given(image)[0] for image in images]
        found = color_range_points(cast, pictures, known, choice)
        unseen = (found.seen_by == 0) & np.isfinite(cast[..., 2])
        camera = None
        if cast.ndim == 3 and known.depth is not None:
            depth = np.ascontiguousarray(cast[..., 2])
            camera = known.depth.camera.scaled_to(cast.shape[1], cast.shape[0])
        second = found.second_colors if views == 2 else None
        notes = (*notes, *found.warnings)
        scene = cls(found.colors, cast, depth, camera, second, notes, unseen)
        tell(scene.warnings)
        return scene

    @classmethod
    def from_image(cls, rgb: Picture) -> Self:
        """Make a scene from an image alone, for ``cues="color"``.

        Parameters
        ----------
        rgb : (H, W, 3), (H, W, 4) or (H, W) array, or path
            The image.

        Returns
        -------
        Scene
            With all geometry missing.

        Raises
        ------
        GeohueError
            If the image has another number of channels, type or range.
        """
        colors = upright(*picture_given(rgb))
        return cls(colors, np.full(colors.shape, np.nan, np.float32))
