"""The command line: a thin edge around the library."""

from geohue.cli import clock  # isort: skip  # first: it tells when the command began
from geohue.cli.app import main

__all__ = ["clock", "main"]
