"""Files: pictures, depth maps, clouds and camera intrinsics in and out, one format a module."""

from geohue.io.atomic import atomic_write
from geohue.io.cloud import CloudData, read_cloud
from geohue.io.images import DepthImage, read_color, read_depth, read_labels, write_png
from geohue.io.intrinsics import read_intrinsics
from geohue.io.pcd import read_pcd
from geohue.io.ply import read_ply, write_ply

__all__ = [
    "CloudData",
    "DepthImage",
    "atomic_write",
    "read_cloud",
    "read_color",
    "read_depth",
    "read_intrinsics",
    "read_labels",
    "read_pcd",
    "read_ply",
    "write_ply",
    "write_png",
]
