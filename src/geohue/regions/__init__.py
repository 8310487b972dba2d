"""Sec. III: connected regions of grids and clouds, small ones merged, and what lies beside what."""
