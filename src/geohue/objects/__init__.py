"""Segments as objects: where each lies, its shape, its colour and its neighbours."""

from __future__ import annotations

from geohue.objects.editing import Editing
from geohue.objects.graph import Neighbours
from geohue.objects.measured import Measured
from geohue.objects.segments import Segment, Segments

__all__ = ["Editing", "Measured", "Neighbours", "Segment", "Segments"]
