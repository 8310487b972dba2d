"""Scenes that come with geohue or its dependencies, and data sets as they are published."""

from geohue.datasets.frames import Dataset, Frame
from geohue.datasets.layouts import LAYOUTS, Layout, open_dataset, register_layout
from geohue.datasets.samples import SAMPLES, load_sample

__all__ = [
    "LAYOUTS",
    "SAMPLES",
    "Dataset",
    "Frame",
    "Layout",
    "load_sample",
    "open_dataset",
    "register_layout",
]
