"""Superpoints: an over-segmentation that follows colour and geometry, of a chosen size, nested."""

from __future__ import annotations

from geohue.superpoint.driver import nested, superpoints

__all__ = ["nested", "superpoints"]
