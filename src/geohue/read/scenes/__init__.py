"""Whole scenes from files."""
