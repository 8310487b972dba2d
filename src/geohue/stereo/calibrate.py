"""A stereo rig from pictures of a checkerboard."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.stereo.rig import StereoRig, camera_from_matrix

FEWEST = 3
"""Pairs that a calibration needs at least; ten or more, tilted and in all corners, are good."""

_OUTLIER = 1.0  # px; a view with more is worth a warning
_GREEN = (80, 220, 80)

Corners = NDArray[np.float32]


@dataclass(frozen=True, slots=True, eq=False)
class StereoCalibration:
    """What `calibrate_stereo` finds.

    Attributes
    ----------
    rig : StereoRig
        K, D of both cameras, R and T (in the unit of the squares; metres make metres).
    error : float
        Root mean square distance in pixels between corners found and corners predicted, over all
        pairs and both cameras.
    left_error, right_error : float
        The same for each camera calibrated alone.
    view_errors : (P, 2) float64
        The same for each pair used, left and right.
    used : tuple of int
        Positions of these pairs in the input.
    size : (int, int)
        Width and height of the images.
    warnings : tuple of str
        Pairs left out, and why; views with large errors.
    """

    rig: StereoRig
    error: float
    left_error: float
    right_error: float
    view_errors: NDArray[np.float64]
    used: tuple[int, ...]
    size: tuple[int, int]
    warnings: tuple[str, ...] = ()


def calibrate_stereo(
    pairs: Sequence[tuple[NDArray[np.uint8], NDArray[np.uint8]]],
    pattern: tuple[int, int] = (9, 6),
    square: float = 1.0,
    *,
    window: int | None = None,
    names: Sequence[str] | None = None,
) -> StereoCalibration:
    """Calibrate two cameras from pairs of pictures of one checkerboard.

    Each camera is calibrated alone (fx, fy, cx, cy, k1, k2, p1, p2, k3); then R and T are found
    and everything is refined together.

    Parameters
    ----------
    pairs : sequence of (left, right)
        (H, W, 3) or (H, W) uint8 images, taken at the same moment; all of one size.
    pattern : (int, int)
        Inner corners along a row and along a column of the board.
    square : float
        Side of a square, in metres if depth is wanted in metres.
    window : int, optional
        Half the side in pixels of the area in which a corner is refined. None: two fifths of the
        least distance between corners in the picture, 2 to 11, so that no second corner is in it.
    names : sequence of str, optional
        What to call the pairs in warnings.

    Returns
    -------
    StereoCalibration

    Raises
    ------
    GeohueError
        If the images differ in size or fewer than three pairs show the whole board.
    """
    _check(pairs, pattern, square, window)
    names = [f"pair {i + 1}" for i in range(len(pairs))] if names is None else names
    height, width = pairs[0][0].shape[:2]
    found = [tuple(find_corners(view, pattern, window) for view in pair) for pair in pairs]
    used = tuple(i for i, (a, b) in enumerate(found) if a is not None and b is not None)
    notes = [_missing(names[i], pair) for i, pair in enumerate(found) if i not in used]
    if len(used) < FEWEST:
        raise GeohueError(
            f"{len(used)} of {len(pairs)} pairs show a whole board of {pattern[0]} x {pattern[1]} "
            f"inner corners, at least {FEWEST} must: check the pattern (inner corners, not "
            "squares), light and sharpness"
        )
    board = board_points(pattern, square)
    first, second = ([found[i][side] for i in used] for side in (0, 1))
    solved = _solve(board, first, second, (width, height))
    errors = np.asarray(solved["view_errors"], np.float64)
    notes += [
        f"{names[i]}: its corners lie {max(e):.1f} px from where they should be; leave it out if "
        "the board moved or bent"
        for i, e in zip(used, errors.tolist(), strict=True)
        if max(e) > _OUTLIER
    ]
    return StereoCalibration(
        _rig(solved, width, height),
        float(solved["error"]),
        float(solved["alone"][0]),
        float(solved["alone"][1]),
        errors,
        used,
        (width, height),
        tuple(notes),
    )


def find_corners(
    image: NDArray[np.uint8], pattern: tuple[int, int], window: int | None = None
) -> Corners | None:
    """Find the inner corners of a checkerboard, row by row, to a fraction of a pixel.

    Parameters
    ----------
    image : (H, W, 3) or (H, W) uint8
        The picture.
    pattern : (int, int)
        Inner corners along a row and along a column.
    window : int, optional
        See `calibrate_stereo`.

    Returns
    -------
    (N, 1, 2) float32 or None
        x and y; None if the board is not wholly there.
    """
    import cv2

    grey = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY) if image.ndim == 3 else image
    flags = cv2.CALIB_CB_ADAPTIVE_THRESH | cv2.CALIB_CB_NORMALIZE_IMAGE
    ok, corners = cv2.findChessboardCorners(grey, pattern, flags=flags)
    if not ok:  # slower, for pictures that are blurred or in bad light
        ok, corners = cv2.findChessboardCornersSB(grey, pattern, flags=cv2.CALIB_CB_NORMALIZE_IMAGE)
        return np.asarray(corners, np.float32).reshape(-1, 1, 2) if ok else None
    corners = np.asarray(corners, np.float32).reshape(-1, 1, 2)
    half = _window(corners, pattern) if window is None else window
    stop = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_MAX_ITER, 100, 1e-4)
    return np.asarray(cv2.cornerSubPix(grey, corners, (half, half), (-1, -1), stop), np.float32)


def _window(corners: Corners, pattern: tuple[int, int]) -> int:
    grid = corners.reshape(pattern[1], pattern[0], 2)
    gaps = [np.linalg.norm(np.diff(grid, axis=axis), axis=2).min() for axis in (0, 1)]
    return int(np.clip(0.4 * min(gaps), 2, 11))


def epipolar_preview(
    left: NDArray[np.uint8], right: NDArray[np.uint8], rig: StereoRig, lines: int = 24
) -> NDArray[np.uint8]:
    """Put a rectified pair side by side with level lines: each must meet the same points in both.

    Parameters
    ----------
    left, right : (H, W, 3) or (H, W) uint8
        A pair as taken; it is rectified here.
    rig : StereoRig
        The calibration.
    lines : int
        How many lines.

    Returns
    -------
    (H, 2 W, 3) uint8
        sRGB.
    """
    pair = rig.scaled_to(left.shape[1], left.shape[0]).rectify(left, right)[:2]
    color = [np.repeat(i[..., None], 3, axis=2) if i.ndim == 2 else i for i in pair]
    picture = np.ascontiguousarray(np.hstack(color))
    rows = (np.arange(1, lines + 1) * picture.shape[0]) // (lines + 1)
    picture[rows] = np.asarray(_GREEN, np.uint8)
    return picture


def _check(
    pairs: Sequence[tuple[NDArray[np.uint8], NDArray[np.uint8]]],
    pattern: tuple[int, int],
    square: float,
    window: int | None,
) -> None:
    sizes = {view.shape[1::-1] for pair in pairs for view in pair}
    if len(sizes) > 1:
        shown = ", ".join(f"{w} x {h}" for w, h in sorted(sizes))
        raise GeohueError(f"the pictures differ in size ({shown}): take all with the same settings")
    if min(pattern) < 3:
        raise GeohueError(f"pattern {pattern}: count the inner corners, at least 3 each way")
    if not 0 < square < np.inf:
        raise GeohueError(f"square {square}: must be a positive length")
    if window is not None and window < 1:
        raise GeohueError(f"window {window}: must be at least 1 px")
    if len(pairs) < FEWEST:
        raise GeohueError(f"{len(pairs)} pair(s): a calibration needs at least {FEWEST}")


def _missing(name: str, corners: tuple[Corners | None, ...]) -> str:
    sides = [side for side, c in zip(("left", "right"), corners, strict=True) if c is None]
    return f"{name}: left out, no whole board in the {' and the '.join(sides)} picture"


def board_points(pattern: tuple[int, int], square: float) -> NDArray[np.float32]:
    """Return the inner corners of a checkerboard in its own frame, (N, 3)."""
    points = np.zeros((pattern[0] * pattern[1], 3), np.float32)
    points[:, :2] = np.mgrid[: pattern[0], : pattern[1]].T.reshape(-1, 2) * square
    return points


def _solve(
    board: NDArray[np.float32],
    first: Sequence[Any],
    second: Sequence[Any],
    size: tuple[int, int],
) -> dict[str, Any]:
    """Calibrate each camera alone, then both together."""
    import cv2

    boards = [board] * len(first)
    alone = [cv2.calibrateCamera(boards, corners, size, None, None) for corners in (first, second)]
    stop = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_MAX_ITER, 200, 1e-8)
    # The last of the results, per-view errors, comes after a varying number of others.
    results: tuple[Any, ...] = cv2.stereoCalibrateExtended(
        boards,
        first,
        second,
        *alone[0][1:3],
        *alone[1][1:3],
        size,
        np.eye(3),
        np.zeros((3, 1)),
        flags=cv2.CALIB_USE_INTRINSIC_GUESS,
        criteria=stop,
    )
    names = ("error", "K1", "D1", "K2", "D2", "R", "T")
    solved = dict(zip(names, results[:7], strict=True))
    return solved | {"view_errors": results[-1], "alone": (alone[0][0], alone[1][0])}


def _rig(solved: dict[str, Any], width: int, height: int) -> StereoRig:
    left, right = (camera_from_matrix(solved[K], width, height) for K in ("K1", "K2"))
    return StereoRig(
        left,
        right,
        left_distortion=tuple(np.ravel(solved["D1"]).tolist()),
        right_distortion=tuple(np.ravel(solved["D2"]).tolist()),
        rotation=np.asarray(solved["R"], np.float64),
        translation=np.asarray(solved["T"], np.float64).ravel(),
    )
