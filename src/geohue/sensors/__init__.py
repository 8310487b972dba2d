"""Range sensors with colour cameras beside them: registration, and colours for range points."""

from geohue.sensors.alignment import edge_agreement
from geohue.sensors.kinect import DisparityModel
from geohue.sensors.lens import Lens
from geohue.sensors.refine import refine_translation
from geohue.sensors.registration import register_depth, undistorted
from geohue.sensors.rig import PosedCamera, Rig
from geohue.sensors.trinocular import RangeColors, color_range_points

__all__ = [
    "DisparityModel",
    "Lens",
    "PosedCamera",
    "RangeColors",
    "Rig",
    "color_range_points",
    "edge_agreement",
    "refine_translation",
    "register_depth",
    "undistorted",
]
