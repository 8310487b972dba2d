"""Two calibrated cameras: disparity as depth, and the rectification of raw pairs (Sec. V)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.camera import Intrinsics
from geohue.errors import GeohueError

Vector = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class StereoRig:
    """A left and a right camera.

    In a rectified pair a scene point lies in one row of both images, at ``x`` in the left and at
    ``x - d`` in the right: the disparity d is positive for a nearer point, and its depth is
    ``Z = f b / (d + doffs)``.

    Parameters
    ----------
    left, right : Intrinsics
        The cameras; of the rectified images where the rig is rectified.
    baseline : float, optional
        Distance between the cameras in metres, positive. None: unknown, so that depth is up to
        scale (in baselines).
    doffs : float, optional
        cx of the right camera minus cx of the left one, in pixels. By default taken from them.
        Images that were cropped differently have one too (Middlebury's dmin).
    left_distortion, right_distortion : tuple of float
        OpenCV's coefficients k1, k2, p1, p2, ...; empty for none.
    rotation : (3, 3) float64, optional
        R that takes points of the left camera's frame to the right one's: ``X_r = R X_l + T``.
    translation : (3,) float64, optional
        T, in metres; its first number is negative where the right camera stands on the right.
    centre_known : bool
        False if cx and cy were not given: `scaled_to` puts them in the middle of the image.
    warnings : tuple of str
        Guesses that the user should know of.

    Raises
    ------
    GeohueError
        For a baseline that is not positive, or a rotation or translation of another shape.

    Examples
    --------
    A point 40 px apart, seen with f = 800 px and a baseline of 10 cm, is 2 m away:

    >>> camera = Intrinsics(800.0, 800.0, 319.5, 239.5)
    >>> StereoRig(camera, camera, baseline=0.1).depth(np.array([[40.0, np.nan]]))
    array([[ 2., nan]], dtype=float32)
    """

    left: Intrinsics
    right: Intrinsics
    baseline: float | None = None
    doffs: float | None = None
    left_distortion: tuple[float, ...] = ()
    right_distortion: tuple[float, ...] = ()
    rotation: Vector | None = None
    translation: Vector | None = None
    centre_known: bool = True
    warnings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if self.baseline is None and self.translation is not None:
            object.__setattr__(self, "baseline", float(np.linalg.norm(self.translation)))
        if self.baseline is not None and not 0 < self.baseline < np.inf:
            raise GeohueError(f"baseline {self.baseline}: must be a positive number of metres")
        if self.doffs is not None and not np.isfinite(self.doffs):
            raise GeohueError(f"doffs {self.doffs}: must be a finite number of pixels")
        for name, shape in (("rotation", (3, 3)), ("translation", (3,))):
            value = getattr(self, name)
            if value is not None and (value.shape != shape or not np.isfinite(value).all()):
                raise GeohueError(f"{name} of shape {value.shape}: expected {shape}, all finite")

    @classmethod
    def guess(cls, width: int, height: int) -> StereoRig:
        """Return the fallback without any calibration: geometry up to scale.

        Both cameras are 57 degrees wide and centred, the baseline is unknown and doffs 0. The
        method does not need the absolute scale. But proportions are not true: a wrong focal
        length stretches the depth, and a crop that doffs would tell bends it.

        Examples
        --------
        >>> StereoRig.guess(640, 480).warnings
        ('no stereo calibration: assuming f = 525 px, the centre of the image and an unknown
        baseline; depth is in baselines and its proportions are a guess (give rig=...)',)
        """
        camera = Intrinsics.guess(width, height)
        note = (
            f"no stereo calibration: assuming f = {camera.fx:.0f} px, the centre of the image and "
            "an unknown baseline; depth is in baselines and its proportions are a guess "
            "(give rig=...)"
        )
        return cls(camera, camera, warnings=(note,))

    @property
    def offset(self) -> float:
        """``doffs``, or the difference of the principal points where it was not given."""
        return self.right.cx - self.left.cx if self.doffs is None else self.doffs

    @property
    def is_rectified(self) -> bool:
        """Whether the images need no undistortion and no rotation."""
        if any(self.left_distortion) or any(self.right_distortion):
            return False
        if self.rotation is not None and not np.allclose(self.rotation, np.eye(3), atol=1e-6):
            return False
        shift = self.translation
        if shift is not None and np.abs(shift[1:]).max() > 1e-6 * abs(shift[0]):
            return False
        rows = np.array([[c.fx, c.fy, c.cy] for c in (self.left, self.right)])
        return bool(np.allclose(rows[0], rows[1], rtol=1e-4))

    def scaled_to(self, width: int, height: int) -> StereoRig:
        """Return the same rig for images of another size.

        Where only the height of the calibrated images is known, both sides scale with it.
        """
        cameras = [_scaled(camera, width, height) for camera in (self.left, self.right)]
        doffs = self.doffs
        if not self.centre_known:
            middle = ((width - 1) / 2, (height - 1) / 2)
            cameras = [replace(camera, cx=middle[0], cy=middle[1]) for camera in cameras]
            doffs = self.offset
        if doffs is not None:
            doffs *= cameras[0].fx / self.left.fx
        return replace(self, left=cameras[0], right=cameras[1], doffs=doffs)

    def depth(self, disparity: NDArray[np.floating[Any]]) -> NDArray[np.float32]:
        """Turn disparities of the left image into depth, ``Z = f b / (d + doffs)``.

        Parameters
        ----------
        disparity : (H, W) float
            x in the left minus x in the right image, in pixels; NaN where missing.

        Returns
        -------
        (H, W) float32
            Metres, or baselines where the baseline is unknown. NaN where the disparity is missing
            or the point would lie at infinity or behind it (``d + doffs <= 0``).
        """
        shift = np.asarray(disparity, np.float64) + self.offset
        base = 1.0 if self.baseline is None else self.baseline
        known = np.isfinite(shift) & (shift > 0)
        depth = np.full(shift.shape, np.nan, np.float32)
        depth[known] = self.left.fx * base / shift[known]
        return depth

    def disparity(self, depth: NDArray[np.floating[Any]]) -> NDArray[np.float32]:
        """Turn depth into disparity: the inverse of `depth`."""
        metres = np.asarray(depth, np.float64)
        base = 1.0 if self.baseline is None else self.baseline
        known = np.isfinite(metres) & (metres > 0)
        disparity = np.full(metres.shape, np.nan, np.float32)
        disparity[known] = self.left.fx * base / metres[known] - self.offset
        return disparity

    def mirrored(self, width: int) -> StereoRig:
        """Return the rectified rig of the pair seen in a mirror, which swaps the views' roles.

        Flipped left to right, the right image is the left one of a pair with the same disparity
        range and the same doffs.
        """
        cameras = (replace(camera, cx=width - 1 - camera.cx) for camera in (self.right, self.left))
        left, right = cameras
        return replace(self, left=left, right=right, rotation=None, translation=None)

    def rectify(
        self, left: NDArray[np.uint8], right: NDArray[np.uint8]
    ) -> tuple[NDArray[np.uint8], NDArray[np.uint8], StereoRig]:
        """Turn a raw pair such that a scene point lies in one row of both images.

        Parameters
        ----------
        left, right : (H, W, 3) or (H, W) uint8
            The raw images, of the size that the rig is for.

        Returns
        -------
        left, right : uint8 arrays of the same size
            The rectified images, zoomed such that hardly any pixel lacks a source; those that do
            repeat the nearest. As given where the rig is rectified already.
        rig : StereoRig
            The rig of the rectified images.

        Raises
        ------
        GeohueError
            If R and T are missing, or say that the cameras are swapped or one above the other.
        """
        if self.is_rectified:
            return left, right, self
        import cv2

        height, width = left.shape[:2]
        first, second, P1, P2 = self._rectification(width, height)
        views = []
        for image, camera, distortion, turn, P in (
            (left, self.left, self.left_distortion, first, P1),
            (right, self.right, self.right_distortion, second, P2),
        ):
            x, y = cv2.initUndistortRectifyMap(
                camera_matrix(camera), _or_zeros(distortion), turn, P, (width, height), cv2.CV_32FC1
            )
            views.append(
                np.asarray(
                    cv2.remap(image, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE),
                    np.uint8,
                )
            )
        return views[0], views[1], self._rectified(P1, P2, width, height)

    def left_map(self, width: int, height: int) -> NDArray[np.float32]:
        """Return where each pixel of the raw left image comes to lie in the rectified one.

        Parameters
        ----------
        width, height : int
            Size of the raw image, that of the rig.

        Returns
        -------
        (height, width, 2) float32
            x and y in the rectified image, also beyond its edges.
        """
        import cv2

        turn, _, P, _ = self._rectification(width, height)
        grid = np.indices((height, width), np.float64)[::-1].reshape(2, -1).T
        there = cv2.undistortPoints(
            grid[:, None],
            camera_matrix(self.left),
            _or_zeros(self.left_distortion),
            R=turn,
            P=P,
        )
        return np.asarray(there, np.float32).reshape(height, width, 2)

    def rectified(self, width: int, height: int) -> StereoRig:
        """Return the rig of the rectified images, as `rectify` does, without any image."""
        if self.is_rectified:
            return self
        return self._rectified(*self._rectification(width, height)[2:], width, height)

    def _rectified(self, P1: Vector, P2: Vector, width: int, height: int) -> StereoRig:
        left, right = (camera_from_matrix(P, width, height) for P in (P1, P2))
        return StereoRig(left, right, self.baseline, warnings=self.warnings)

    def _rectification(self, width: int, height: int) -> tuple[Vector, Vector, Vector, Vector]:
        """Return OpenCV's R1, R2, P1, P2, or say why there are none."""
        import cv2

        if self.rotation is None or self.translation is None:
            raise GeohueError(
                "the calibration has no R and T between the cameras, so the pair cannot be "
                "rectified: give them (OpenCV's extrinsics.yml), or a calibration of a rectified "
                "pair"
            )
        solved: tuple[Any, ...] = cv2.stereoRectify(
            camera_matrix(self.left),
            _or_zeros(self.left_distortion),
            camera_matrix(self.right),
            _or_zeros(self.right_distortion),
            (width, height),
            self.rotation,
            self.translation[:, None],
            flags=cv2.CALIB_ZERO_DISPARITY,
            alpha=0,
        )
        first, second, P1, P2 = solved[:4]
        if P2[1, 3] != 0:
            raise GeohueError(
                f"T = {self.translation.round(4).tolist()}: the cameras stand one above the "
                "other; turn both images by 90 degrees and calibrate those"
            )
        if P2[0, 3] > 0:
            raise GeohueError(
                f"T = {self.translation.round(4).tolist()}: the second camera stands to the left "
                "of the first; exchange the images and calibrate again"
            )
        return first, second, P1, P2


def camera_matrix(camera: Intrinsics) -> Vector:
    """Return K, the 3 x 3 matrix of a camera."""
    return np.array([[camera.fx, 0, camera.cx], [0, camera.fy, camera.cy], [0, 0, 1.0]])


def camera_from_matrix(
    K: NDArray[np.floating[Any]], width: int | None = None, height: int | None = None
) -> Intrinsics:
    """Return the camera of a 3 x 3 or 3 x 4 matrix."""
    return Intrinsics(float(K[0, 0]), float(K[1, 1]), float(K[0, 2]), float(K[1, 2]), width, height)


def _or_zeros(distortion: tuple[float, ...]) -> Vector:
    return np.array(distortion or (0.0,) * 5)


def _scaled(camera: Intrinsics, width: int, height: int) -> Intrinsics:
    """Scale a camera; from its height alone where its width is unknown."""
    if camera.width is None and camera.height is not None:
        camera = replace(camera, width=max(1, round(width * camera.height / height)))
    scaled = camera.scaled_to(width, height)
    return replace(scaled, width=width, height=height)
