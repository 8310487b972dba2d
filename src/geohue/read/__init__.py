"""Files that are read: pictures, depth maps, clouds, cameras; one format a module."""

from geohue.read.cameras.intrinsics import read_intrinsics
from geohue.read.clouds.cloud import CloudData, read_cloud
from geohue.read.clouds.pcd import read_pcd
from geohue.read.clouds.ply import read_ply
from geohue.read.images.pictures import DepthImage, read_color, read_depth, read_labels
from geohue.read.levels import read_levels

__all__ = [
    "CloudData",
    "DepthImage",
    "read_cloud",
    "read_color",
    "read_depth",
    "read_intrinsics",
    "read_labels",
    "read_levels",
    "read_pcd",
    "read_ply",
]
