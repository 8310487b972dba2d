"""The command line: a thin edge around the library."""

from geohue.cli.app import main

__all__ = ["main"]
