"""Cameras and calibrations as files."""
