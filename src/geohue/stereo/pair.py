"""From two images to a scene: checks, rectification, matching, and the roles swapped (Sec. V)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.stereo.evidence import (
    doubt_disparity,
    looks_swapped,
    looks_unrectified,
    match_features,
)
from geohue.stereo.matching import is_blank, match
from geohue.stereo.rig import StereoRig
from geohue.stereo.warping import Warp, check_pair, warp_right

Views = Literal[1, 2]

_CLEAR = 0.5  # px; what a disparity is uncertain by, at best
_ALREADY = 0.5  # px; a pair whose features lie this close to one row is rectified


@dataclass(frozen=True, slots=True, eq=False)
class StereoPair:
    """A rectified pair with its disparities.

    Build one with `prepare`.

    Attributes
    ----------
    left, right : (H, W, 3) uint8
        The rectified images, sRGB.
    rig : StereoRig
        The rig of the rectified images.
    disparity : (H, W) float32
        Of the left image: ``x_left - x_right`` in pixels, NaN where missing.
    right_disparity : (H, W) float32 or None
        Of the right image, with the same sign.
    warnings : tuple of str
        Guesses, and doubts with their evidence.
    unrectified : (h, w, 2) float32 or None
        Where each pixel of the left image as it was given lies in `left`, x and y, if the pair
        was rectified; None if it was given so.
    """

    left: NDArray[np.uint8]
    right: NDArray[np.uint8]
    rig: StereoRig
    disparity: NDArray[np.float32]
    right_disparity: NDArray[np.float32] | None = None
    warnings: tuple[str, ...] = ()
    unrectified: NDArray[np.float32] | None = None

    @classmethod
    def prepare(
        cls,
        left: NDArray[np.uint8],
        right: NDArray[np.uint8],
        rig: StereoRig | None = None,
        disparity: NDArray[np.floating[Any]] | None = None,
        right_disparity: NDArray[np.floating[Any]] | None = None,
        disparity_range: tuple[int, int] | None = None,
    ) -> StereoPair:
        """Check, rectify and match a pair.

        Parameters
        ----------
        left, right : (H, W, 3) uint8
            The images.
        rig : StereoRig, optional
            Their calibration, scaled where it is for another size. None: `StereoRig.guess`.
        disparity, right_disparity : (H, W) float, optional
            Disparities of the rectified images, in pixels, positive in front of the cameras; NaN
            where missing. None: both are computed (`match`); if only `disparity` is given, the
            right one stays unknown.
        disparity_range : (int, int), optional
            For `match`.

        Returns
        -------
        StereoPair

        Raises
        ------
        GeohueError
            If the sizes differ, an image is blank that would have to be matched, left and right
            are exchanged, the disparity has the wrong sign, or the rig cannot be rectified.
        """
        check_pair(left, right)
        height, width = left.shape[:2]
        given = StereoRig.guess(width, height) if rig is None else rig
        known = given.scaled_to(width, height)
        doubts = [*known.warnings, *_size_doubts(given, width, height)]
        raw = left, known
        left, right, known, more = _rectified(left, right, known)
        doubts += more
        turned = None if left is raw[0] else raw[1].left_map(width, height)
        if disparity is None:
            end = None if rig is None else -known.offset
            found = match(left, right, disparity_range, at_infinity=end)
            disparity, right_disparity = found.left, found.right
        else:
            check_pair(left, right, disparity)
            doubts += _disparity_doubts(left, right, known, disparity)
        other = None if right_disparity is None else _as_float(right_disparity)
        pair = cls(left, right, known, _as_float(disparity), other)
        return replace(pair, warnings=(*doubts, *_emptiness(pair)), unrectified=turned)

    @property
    def depth(self) -> NDArray[np.float32]:
        """Depth of the left image, ``Z = f b / (d + doffs)``.

        NaN where the disparity is missing, or less than half a pixel from that of infinity: such
        a point may be anywhere beyond, and a few at a thousand times the distance of the scene
        would be all that its deviation (eq. 2) is made of.
        """
        near = self.disparity + self.rig.offset >= _CLEAR
        return self.rig.depth(np.where(near, self.disparity, np.nan))

    def warp(self) -> Warp:
        """Warp the right view to the left one (eq. 18)."""
        return warp_right(self.left, self.right, self.disparity, self.right_disparity)

    def to_original(self, values: NDArray[Any], missing: Any) -> NDArray[Any]:
        """Bring a map of the rectified left image back to the pixels of the one that was given.

        Parameters
        ----------
        values : (H, W)
            Labels, or any values that are not to be mixed: each comes from the nearest pixel.
        missing : scalar
            For pixels that the rectified image has not.

        Returns
        -------
        (h, w)
            `values` as it is where the pair was not rectified here.
        """
        if self.unrectified is None:
            return values
        height, width = values.shape
        x, y = (np.rint(self.unrectified[..., i]).astype(np.int64) for i in (0, 1))
        seen = (x >= 0) & (x < width) & (y >= 0) & (y < height)
        found = np.full(x.shape, missing, values.dtype)
        found[seen] = values[y[seen], x[seen]]
        return found

    def swapped(self) -> StereoPair:
        """Return the pair with the roles of the views exchanged, to segment the right one.

        Everything is seen in a mirror, in which the right camera is the left one: flip the labels
        of its scene left to right. Swapping twice gives the pair again.

        Raises
        ------
        GeohueError
            Without a disparity of the right image.
        """
        if self.right_disparity is None:
            raise GeohueError(
                "the right view has no disparity: give right_disparity, or let both be matched"
            )
        return StereoPair(
            np.ascontiguousarray(self.right[:, ::-1]),
            np.ascontiguousarray(self.left[:, ::-1]),
            self.rig.mirrored(self.left.shape[1]),
            np.ascontiguousarray(self.right_disparity[:, ::-1]),
            np.ascontiguousarray(self.disparity[:, ::-1]),
            self.warnings,
        )


def _as_float(disparity: NDArray[np.floating[Any]]) -> NDArray[np.float32]:
    return np.where(np.isfinite(disparity), disparity, np.nan).astype(np.float32)


def _size_doubts(rig: StereoRig, width: int, height: int) -> list[str]:
    w, h = rig.left.width, rig.left.height
    if w is None or h is None or (w, h) == (width, height):
        return []
    note = f"the calibration is for {w} x {h}: scaled to the images' {width} x {height}"
    if abs(w * height - h * width) > 0.01 * h * width:
        note += ", which has other proportions; was the pair cropped?"
    return [note]


def _rectified(
    left: NDArray[np.uint8], right: NDArray[np.uint8], rig: StereoRig
) -> tuple[NDArray[np.uint8], NDArray[np.uint8], StereoRig, list[str]]:
    """Rectify a raw pair; look whether the images bear out what the rig says of them."""
    if is_blank(left) or is_blank(right):
        return *rig.rectify(left, right), []
    matches = match_features(left, right)
    notes: list[str] = []
    if not rig.is_rectified:
        before = matches.vertical
        turned = rig.rectify(left, right)
        after = match_features(turned[0], turned[1])
        if before is not None and before <= _ALREADY and (after.vertical or 0) > before + 1:
            notes = [
                f"the calibration is of raw images, but the pair is rectified already (matched "
                f"features {before:.1f} px apart vertically, {after.vertical:.1f} after "
                "rectifying): used as it is"
            ]
            turned = (left, right, turned[2])
        else:
            matches = after
        left, right, rig = turned
    doubt = looks_unrectified(matches)
    if doubt is not None:
        notes.append(doubt)
    exchanged = looks_swapped(matches, rig.offset)
    if exchanged is not None:
        raise GeohueError(exchanged)
    return left, right, rig, notes


def _disparity_doubts(
    left: NDArray[np.uint8],
    right: NDArray[np.uint8],
    rig: StereoRig,
    disparity: NDArray[np.floating[Any]],
) -> list[str]:
    blank = [name for name, image in (("left", left), ("right", right)) if is_blank(image)]
    if blank:
        return [f"the {' and the '.join(blank)} image is blank: its colours say nothing"]
    doubt = doubt_disparity(left, right, disparity)
    known = disparity[np.isfinite(disparity)]
    behind = float((known + rig.offset <= 0).mean()) if known.size else 0.0
    if behind > 0.5:
        raise GeohueError(
            f"{100 * behind:.0f} % of the disparities are not in front of the cameras "
            f"(d + doffs <= 0, doffs = {rig.offset:.1f}): the sign is wrong, or left and right "
            "are exchanged; " + (doubt or "disparity is x_left - x_right, positive for near points")
        )
    return [doubt] if doubt else []


def _emptiness(pair: StereoPair) -> list[str]:
    share = float(np.isfinite(pair.depth).mean())
    if share >= 0.2:
        return []
    return [f"only {100 * share:.1f} % of the pixels have a depth: the labels rest on little"]
