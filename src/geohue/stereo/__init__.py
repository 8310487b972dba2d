"""Sec. V: two colour views of a scene. Matching, warping (eq. 18), rectification, calibration."""

from geohue.stereo.calibrate import StereoCalibration, calibrate_stereo, epipolar_preview
from geohue.stereo.consistency import ViewAgreement, view_agreement
from geohue.stereo.matching import StereoMatch, estimate_range, match
from geohue.stereo.pair import StereoPair
from geohue.stereo.rig import StereoRig
from geohue.stereo.warping import Warp, find_occlusions, warp_right

__all__ = [
    "StereoCalibration",
    "StereoMatch",
    "StereoPair",
    "StereoRig",
    "ViewAgreement",
    "Warp",
    "calibrate_stereo",
    "epipolar_preview",
    "estimate_range",
    "find_occlusions",
    "match",
    "view_agreement",
    "warp_right",
]
