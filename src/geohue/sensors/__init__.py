"""Range sensors with colour cameras beside them: registration, and colours for range points."""

from geohue.sensors.alignment import edge_agreement
from geohue.sensors.kinect import DisparityModel
from geohue.sensors.lens import Lens
from geohue.sensors.refine import refine_translation
from geohue.sensors.registration import register_depth, registered_scene, undistorted
from geohue.sensors.rig import PosedCamera, Rig
from geohue.sensors.trinocular import RangeColors, color_range_points
from geohue.sensors.unseen import label_unseen

__all__ = [
    "DisparityModel",
    "Lens",
    "PosedCamera",
    "RangeColors",
    "Rig",
    "color_range_points",
    "edge_agreement",
    "label_unseen",
    "refine_translation",
    "register_depth",
    "registered_scene",
    "undistorted",
]
