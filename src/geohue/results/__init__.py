"""What is written: labels, clouds, pictures, tables, whole or not at all."""

from geohue.results.atomic import atomic_write
from geohue.results.ply import write_ply
from geohue.results.png import write_png

__all__ = ["atomic_write", "write_ply", "write_png"]
