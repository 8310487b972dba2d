"""Scenes that come with geohue or its dependencies."""

from geohue.datasets.samples import SAMPLES, load_sample

__all__ = ["SAMPLES", "load_sample"]
