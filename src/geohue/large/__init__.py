"""Clouds larger than memory: two passes over the file, one to measure it, one to label it.

The first pass gathers the moments of colour and geometry (eq. 3, 4) and a random sample. What is
decided in memory on a draft is decided on the sample: regions and the tree of their merges, or the
paper's cut. The second pass labels every point. See docs/large.md.
"""

from geohue.large.result import FileSegmentation
from geohue.large.run import segment_file
from geohue.large.superpoints import FileSuperpoints, superpoints_file

__all__ = ["FileSegmentation", "FileSuperpoints", "segment_file", "superpoints_file"]
